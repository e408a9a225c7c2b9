//! The pass over the image: it reads the G-buffer, marches rays through the depth buffer, and lists those that are left.

use super::listing::Listing;
use super::lists::{LOAD_BYTES, Lists, RAY_BYTES};
use super::prices::Prices;
use crate::config::Reflections as Technique;
use crate::counters::Pass;
use crate::lanes::Lanes;
use crate::layout::{BufferKind, PIXEL_BYTES};
use crate::ordering::Binning;
use crate::schedule::HELPER;
use crate::warp::{Emitter, Program};
use tracer::reflections::{Outcome, Reflections};

const PASS: Pass = Pass::ScreenSpace;
const PIXEL: u32 = PIXEL_BYTES as u32;

/// What its warps execute.
pub(super) struct MarchPass<'a> {
    pub(super) program: &'a Program,
    pub(super) technique: &'a Technique,
    pub(super) prices: Prices<'a>,
    pub(super) frame: &'a Reflections<'a>,
    pub(super) lists: &'a Lists,
    pub(super) lanes: &'a Lanes,
}

/// What became of the lanes of a warp, and the texels that they read.
struct Marched {
    outcomes: Vec<Outcome>,
    /// By lane.
    texels: Vec<Vec<u64>>,
}

impl MarchPass<'_> {
    /// A warp of these pixels, up to where its lanes know whether they have a ray that is left.
    pub(super) fn look_up(&self, emitter: &mut Emitter, pixels: &[u32]) {
        let Self { program, prices, frame, lists, .. } = self;
        let [width, _] = frame.size();
        let inside = || pixels.iter().copied().filter(|&pixel| pixel != HELPER);
        let at = |pixel: u32| (pixel % width, pixel / width);
        let lanes = inside().count() as u64;
        if lanes == 0 {
            return;
        }
        let texel = (BufferKind::Attachment, false, PIXEL);
        emitter.access(program, PASS, texel, inside().map(|pixel| lists.depth(0, at(pixel).0, at(pixel).1)));
        for image in [lists.normal, lists.roughness] {
            emitter.access(
                program,
                PASS,
                texel,
                inside().map(|pixel| image.address(at(pixel).0, at(pixel).1)),
            );
        }
        emitter.end_turn(program, PASS, true);
        program.spend(prices.surface(), 1, lanes, emitter.issue(PASS));

        let Marched { outcomes, texels } = self.marched(pixels);
        let reflecting =
            outcomes.iter().filter(|outcome| matches!(outcome, Outcome::ScreenHit { .. } | Outcome::Query));
        let reflecting = reflecting.count() as u64;
        if reflecting > 0 {
            program.spend(prices.direction(), 1, reflecting, emitter.issue(PASS));
        }
        if let Some([set_up, step]) = prices.march(self.technique.screen_space).filter(|_| reflecting > 0) {
            program.spend(set_up, 1, reflecting, emitter.issue(PASS));
            let longest = texels.iter().map(Vec::len).max().unwrap_or(0);
            for index in 0..longest {
                let read = texels.iter().filter_map(|of_lane| of_lane.get(index).copied());
                emitter.access(program, PASS, texel, read);
                emitter.end_turn(program, PASS, true);
            }
            let steps = texels.iter().map(|of_lane| of_lane.len() as u64).sum();
            program.spend(step, longest as u64, steps, emitter.issue(PASS));
        }

        // A hit is judged by its normal, and takes its colour from the screen.
        let hits = outcomes.iter().filter_map(|outcome| match *outcome {
            Outcome::ScreenHit { x, y } => Some((x, y)),
            _ => None,
        });
        let hit_lanes = hits.clone().count() as u64;
        if hit_lanes > 0 {
            for image in [lists.normal, lists.colour] {
                emitter.access(program, PASS, texel, hits.clone().map(|(x, y)| image.address(x, y)));
                emitter.end_turn(program, PASS, true);
            }
            program.spend(prices.screen_hit(), 1, hit_lanes, emitter.issue(PASS));
        }
        // Lanes without a ray show what an environment map does.
        let done = inside().zip(&outcomes).filter(|&(_, outcome)| *outcome != Outcome::Query);
        let done = done.map(|(pixel, _)| lists.output.address(at(pixel).0, at(pixel).1));
        let done_lanes = done.clone().count() as u64;
        if done_lanes > 0 {
            emitter.access(program, PASS, (BufferKind::Image, true, PIXEL), done);
            emitter.end_turn(program, PASS, false);
            program.spend(prices.store_colour(), 1, done_lanes, emitter.issue(PASS));
        }
    }

    /// Lanes of a warp list the rays that are left; `first` is the warp's first lane. With bins, the last warp of a workgroup takes a stretch of
    /// the list for all of it.
    pub(super) fn list(&self, emitter: &mut Emitter, first: usize, listing: &Listing) {
        let Self { program, prices, lists, technique, lanes, .. } = self;
        let warp = first..first + lanes.warp;
        let listed = listing.places[warp.clone()].iter().copied().flatten();
        let rays = listed.clone().count() as u64;
        let any = u64::from(rays > 0);
        let issue = emitter.issue(PASS);
        let counts = if technique.binning == Binning::None {
            program.spend(prices.append(), any, rays, issue);
            rays > 0
        } else {
            let bins = technique.binning.bins();
            let lower = listing.bins[warp.clone()].iter().copied().flatten();
            program.spend(prices.zero_bins(bins, lanes.group as u32), 1, lanes.warp as u64, issue);
            program.spend(prices.bin(technique.binning), any, rays, issue);
            let most = u64::from(lower.clone().max().unwrap_or(0));
            program.spend(prices.lower_bin(), most, lower.map(u64::from).sum(), issue);
            let is_last = warp.end.is_multiple_of(lanes.group);
            program.spend(prices.group(bins), u64::from(is_last), u64::from(is_last), issue);
            is_last
        };
        if counts {
            emitter.access(
                program,
                PASS,
                (BufferKind::Counter, false, PIXEL),
                std::iter::once(lists.counter(0)),
            );
            emitter.end_turn(program, PASS, true);
        }
        if rays > 0 {
            let record = (BufferKind::Record, true, LOAD_BYTES as u32);
            for offset in (0..RAY_BYTES).step_by(LOAD_BYTES as usize) {
                emitter.access(program, PASS, record, listed.clone().map(|place| lists.ray(place) + offset));
            }
            emitter.end_turn(program, PASS, false);
            program.spend(prices.write_ray(), 1, rays, emitter.issue(PASS));
        }
    }

    fn marched(&self, pixels: &[u32]) -> Marched {
        let inside = pixels.iter().copied().filter(|&pixel| pixel != HELPER);
        let (mut outcomes, mut texels) = (Vec::new(), Vec::new());
        for pixel in inside {
            let mut of_lane = Vec::new();
            self.frame.march(pixel, |level, x, y| of_lane.push(self.lists.depth(level, x, y)));
            outcomes.push(self.frame.outcomes()[pixel as usize]);
            texels.push(of_lane);
        }
        Marched { outcomes, texels }
    }
}
