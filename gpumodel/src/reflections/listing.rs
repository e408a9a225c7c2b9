//! Which place of the list each ray gets.

use super::prices::Prices;
use super::{ReflectionFrame, size};
use crate::config::{Gpu, Launch, Reflections as Technique};
use crate::error::Error;
use crate::lanes::Lanes;
use crate::ordering::{Binning, Compacted, Compaction, Counters, Workgroup, arrival_order};
use crate::schedule::HELPER;
use std::num::NonZero;
use tracer::reflections::{NO_RAY, ReflectionRay};

/// Rays in the order in which they are listed.
pub(super) struct Listing {
    /// By place, the ray, or [`NO_RAY`].
    pub(super) order: Vec<u32>,
    /// By lane of the march, its ray's place.
    pub(super) places: Vec<Option<u32>>,
    /// By lane of the march, its ray's bin.
    pub(super) bins: Vec<Option<u32>>,
    pub(super) compacted: Compacted,
}

impl Listing {
    /// The list of a frame whose march has so many warps on each core at once.
    ///
    /// # Errors
    /// When a workgroup cannot count its bins.
    pub(super) fn new(
        frame: &ReflectionFrame<'_>,
        (technique, prices, gpu): (&Technique, &Prices<'_>, &Gpu),
        lanes: &Lanes,
        resident_warps: u32,
    ) -> Result<Self, Error> {
        let rays = frame.reflections.rays();
        let (width, height) = size(frame.reflections);
        let mut ray_of_pixel = vec![NO_RAY; width as usize * height as usize];
        (0..).zip(rays).for_each(|(ray, ReflectionRay { pixel, .. })| ray_of_pixel[*pixel as usize] = ray);
        let ray_of = |pixel: u32| if pixel == HELPER { NO_RAY } else { ray_of_pixel[pixel as usize] };
        let of_lanes: Vec<u32> = lanes.pixels.iter().map(|&pixel| ray_of(pixel)).collect();
        if technique.launch == Launch::Pixel {
            return Ok(Self {
                order: of_lanes,
                places: Vec::new(),
                bins: Vec::new(),
                compacted: Compacted::default(),
            });
        }
        let bin = |ray: u32| {
            let ray = &rays.get(ray as usize)?.ray;
            Some(technique.binning.bin(ray.direction.to_array(), ray.origin.to_array(), &frame.bounds))
        };
        let bins: Vec<Option<u32>> = of_lanes.iter().map(|&ray| bin(ray)).collect();
        let compaction = Compaction {
            binning: technique.binning,
            workgroup: Workgroup::new(lanes.group, lanes.warp, Counters::Words)?,
            strategy: technique.atomics,
            consumer: lanes.group as u32,
        };
        let durations = durations(frame, (technique, prices, gpu), lanes);
        let slots = (gpu.cores.count * resident_warps) as usize;
        let (durations, slots) = if technique.binning == Binning::None {
            (durations, slots)
        } else {
            // A workgroup waits for the last of its warps.
            let warps = lanes.group / lanes.warp;
            (
                durations.chunks(warps).map(|warps| warps.iter().copied().max().unwrap_or(0)).collect(),
                slots / warps,
            )
        };
        let arrivals = arrival_order(&durations, NonZero::new(slots).unwrap_or(NonZero::<usize>::MIN));
        let compacted = compaction.run(&bins, &arrivals)?;
        let mut places = vec![None; of_lanes.len()];
        (0..).zip(&compacted.order).for_each(|(place, &lane)| places[lane] = Some(place));
        let order = compacted.order.iter().map(|&lane| of_lanes[lane]).collect();
        Ok(Self { order, places, bins, compacted })
    }
}

/// Clocks from the start of each warp of the march until it lists its rays, alone on a core: it waits for one texel after the other.
fn durations(
    frame: &ReflectionFrame<'_>,
    (technique, prices, gpu): (&Technique, &Prices<'_>, &Gpu),
    lanes: &Lanes,
) -> Vec<u64> {
    let latency = gpu.latency_cycles(&gpu.paths.texture, 0);
    let instruction = f64::from(gpu.cores.warp_width) / gpu.cores.alu_lanes;
    let step = prices.march(technique.screen_space).map_or(0, |[_, step]| step.alu);
    let texels = frame.reflections.texels();
    let of_texel = latency + f64::from(step) * instruction;
    let of_warp = |pixels: &[u32]| {
        let inside = pixels.iter().copied().filter(|&pixel| pixel != HELPER);
        let longest = inside.map(|pixel| texels[pixel as usize]).max().unwrap_or(0);
        (f64::from(1 + longest) * of_texel) as u64
    };
    lanes.pixels.chunks(lanes.warp).map(of_warp).collect()
}
