//! What each pixel of a frame of reflections shows and costs.

use super::rays::RayPass;
use super::{ReflectionFrame, size};
use crate::counters::{HeatMap, HeatMaps};
use crate::warp::WarpSteps;
use tracer::reflections::Outcome;
use tracer::{NOT_CAST, RaySet};

/// Where a pixel's reflection comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coverage {
    /// From the screen, which shows what the ray meets.
    Screen,
    /// From the surface that a ray query hits.
    QueryHit,
    /// From the sky: a ray query hits nothing.
    QueryMiss,
    /// From an environment map: the surface is too rough for a ray.
    Fallback,
    /// There is none, as the pixel shows no surface.
    NoSurface,
}

/// Lanes of a warp while it traced reflection rays, in lockstep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaneSlots {
    /// Lanes with a ray.
    pub lanes: u32,
    /// Steps that the warp took, each for the lanes whose turn it was.
    pub warp_steps: u64,
    /// Steps of its lanes, all together.
    pub lane_steps: u64,
}

impl LaneSlots {
    /// Those of a warp whose lanes `rays` have a ray of set `index`.
    pub(super) fn of(warp: &WarpSteps, index: usize, set: &RaySet, rays: impl Iterator<Item = u32>) -> Self {
        let mut slots = Self { warp_steps: warp.sets[index].taken.iter().sum(), ..Self::default() };
        for ray in rays {
            slots.lanes += 1;
            slots.lane_steps += set.range(ray as usize).len() as u64;
        }
        slots
    }

    /// The share of the slots, warp steps times lanes with a ray, in which a lane waited for others: 0 where all rays go the same way, and
    /// less than 1.
    pub fn wasted(self) -> f64 {
        match self.warp_steps * u64::from(self.lanes) {
            0 => 0.0,
            slots => 1.0 - self.lane_steps as f64 / slots as f64,
        }
    }
}

/// What each pixel of a frame of reflections shows, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReflectionMaps {
    /// Pixels per row.
    pub width: u32,
    /// Where the reflection of each pixel comes from.
    pub coverage: Vec<Coverage>,
    /// Of the warp that traced the pixel's reflection ray, where there is such a ray. No map where a ray unit takes each ray by itself: there no lane
    /// waits for another.
    pub lane_slots: Option<Vec<Option<LaneSlots>>>,
}

/// What the rays of one piece of a list cost.
pub(super) struct PieceCosts {
    /// By place in the piece.
    node_fetches: Vec<u32>,
    loaded_bytes: Vec<u32>,
    /// By warp: the places of its rays in the list, and what its lanes did.
    warps: Vec<(Vec<u32>, LaneSlots)>,
}

impl PieceCosts {
    /// `per_ray` are node records and bytes by place.
    pub(super) fn new(
        (node_fetches, loaded_bytes): (Vec<u32>, Vec<u32>),
        warps: Vec<(Vec<u32>, LaneSlots)>,
    ) -> Self {
        Self { node_fetches, loaded_bytes, warps }
    }
}

/// The maps of a frame in the making.
pub(super) struct MapPainter {
    maps: ReflectionMaps,
    heat: HeatMaps,
}

impl MapPainter {
    /// Before any ray is traced: all that the screen has no answer for are misses. `in_lockstep` tells whether lanes wait for each other.
    pub(super) fn new(frame: &ReflectionFrame<'_>, in_lockstep: bool) -> Self {
        let (width, height) = size(frame.reflections);
        let outcomes = frame.reflections.outcomes();
        let coverage = |outcome: &Outcome| match outcome {
            Outcome::Sky => Coverage::NoSurface,
            Outcome::Fallback => Coverage::Fallback,
            Outcome::ScreenHit { .. } => Coverage::Screen,
            Outcome::Query => Coverage::QueryMiss,
        };
        let empty = || HeatMap { width, height, values: vec![0; outcomes.len()] };
        Self {
            maps: ReflectionMaps {
                width,
                coverage: outcomes.iter().map(coverage).collect(),
                lane_slots: in_lockstep.then(|| vec![None; outcomes.len()]),
            },
            heat: HeatMaps {
                node_fetches: empty(),
                loaded_bytes: empty(),
                warp_misses: empty(),
                wasted_slots: None,
            },
        }
    }

    /// What rays hit, by their places in the list.
    pub(super) fn hits(&mut self, pass: &RayPass<'_>, hits: &[u32]) {
        for (place, _) in (0..).zip(hits).filter(|&(_, &hit)| hit < NOT_CAST) {
            if let Some(pixel) = pass.rays.pixel(place) {
                self.maps.coverage[pixel as usize] = Coverage::QueryHit;
            }
        }
    }

    /// What a dispatch cost, of whose warps each read so many lines from memory. A pixel's costs add up over the dispatches that trace.
    pub(super) fn costs(&mut self, pass: &RayPass<'_>, pieces: &[PieceCosts], lines_by_warp: &[u32]) {
        let Self { maps, heat } = self;
        let by_place = |values: fn(&PieceCosts) -> &Vec<u32>| pieces.iter().flat_map(values).copied();
        let costs = by_place(|piece| &piece.node_fetches).zip(by_place(|piece| &piece.loaded_bytes));
        for (place, (fetches, bytes)) in (0..).zip(costs) {
            if let Some(pixel) = pass.rays.pixel(place) {
                heat.node_fetches.values[pixel as usize] += fetches;
                let loaded = &mut heat.loaded_bytes.values[pixel as usize];
                *loaded = loaded.saturating_add(bytes);
            }
        }
        let warps = pieces.iter().flat_map(|piece| &piece.warps);
        for ((places, slots), &lines) in warps.zip(lines_by_warp) {
            for pixel in places.iter().filter_map(|&place| pass.rays.pixel(place)) {
                heat.warp_misses.values[pixel as usize] += lines;
                if let Some(of_pixels) = maps.lane_slots.as_mut().filter(|_| pass.traces_reflections()) {
                    of_pixels[pixel as usize] = Some(*slots);
                }
            }
        }
    }

    pub(super) fn finish(self) -> (ReflectionMaps, HeatMaps) {
        (self.maps, self.heat)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock::{MockRay, Recorded, config};
    use crate::schedule::LaneMap;
    use crate::warp::{Stepper, Walk};
    use proptest::prelude::*;
    use tracer::{Accel, NO_HIT, Op, TileRect};

    /// Of the one warp of the 64 lanes of an Adreno 540 that these rays make.
    fn slots(rays: &[MockRay]) -> LaneSlots {
        let Recorded { header, topology, tiles } = Recorded::list(Accel::Bvh, "stack", 64, rays);
        let config = config(crate::mock::gpu(&[]));
        let walk = Walk::new(&header, &topology, &config);
        let lane_map = LaneMap::new(&config.gpu, header.frame, config.technique.stage);
        let rect = TileRect { x: 0, y: 0, width: rays.len() as u32, height: 1 };
        let mut of_warps = Vec::new();
        let take = |warp: &WarpSteps| {
            let traced = (0..rays.len() as u32).filter(|ray| warp.rays.contains(ray));
            of_warps.push(LaneSlots::of(warp, 0, &tiles[0].ray_sets[0], traced));
            Ok(())
        };
        Stepper::new()
            .run(&header, (&walk, &[true]), &lane_map, (&tiles[0], rect), take)
            .expect("steps that shaders take");
        assert_eq!(of_warps.len(), 1);
        of_warps[0]
    }

    fn visits(nodes: std::ops::Range<u32>) -> MockRay {
        (nodes.map(|node| (Op::Node, node)).collect(), NO_HIT)
    }

    #[test]
    fn a_ray_alone_waits_for_no_other_and_so_do_rays_that_go_the_same_way() {
        assert_eq!(slots(&[visits(0..5)]), LaneSlots { lanes: 1, warp_steps: 5, lane_steps: 5 });
        let alike = vec![visits(0..5); 8];
        assert_eq!(slots(&alike).wasted(), 0.0);
    }

    #[test]
    fn lanes_wait_for_the_longest_of_them() {
        let of_two = slots(&[visits(0..4), visits(0..1)]);
        assert_eq!(of_two, LaneSlots { lanes: 2, warp_steps: 4, lane_steps: 5 });
        assert_eq!(of_two.wasted(), 3.0 / 8.0);
    }

    #[test]
    fn rays_without_steps_waste_nothing() {
        assert_eq!(LaneSlots { lanes: 3, warp_steps: 0, lane_steps: 0 }.wasted(), 0.0);
    }

    proptest! {
        #[test]
        fn one_lane_at_least_takes_every_step(lengths in prop::collection::vec(0_u32..20, 1..32)) {
            let rays: Vec<MockRay> = lengths.iter().map(|&length| visits(0..length)).collect();
            let slots = slots(&rays);
            prop_assert_eq!(slots.lane_steps, lengths.iter().map(|&length| u64::from(length)).sum::<u64>());
            prop_assert!(slots.wasted() >= 0.0 && slots.wasted() <= 1.0 - 1.0 / f64::from(slots.lanes));
        }
    }
}
