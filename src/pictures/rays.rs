//! Rays of a sample of pixels, as the page of a report shows them.

use gpumodel::Pass;
use reports::Report;
use reports::html::{Ray, RayEnd, RaySample};
use tracer::{DECIDED_BY_MICROMAP, NOT_CAST, Op, RaySetId, SampledRay, Step};

/// Pixels whose rays are kept, at most: one in 8 across and down of 1024x1024.
pub(crate) const MOST_SAMPLED_PIXELS: u32 = 16_384;

/// What a step may be, by [`Op`], and after them any-hit tests that a micromap decided.
const OPERATIONS: [&str; 9] =
    ["pop", "restart", "up to", "node", "push", "instance", "triangle", "any-hit shader at", "micromap at"];
const BY_MICROMAP: u8 = 8;

/// Those sets of a sample's rays that the frame traces; none where it traces none of them.
pub(super) fn traced(sample: &tracer::RaySample, sets: &[RaySetId], report: &Report) -> Option<RaySample> {
    let several = sets.iter().any(|set| set.sample > 0);
    let traced = |set: &RaySetId| report.pass(Pass::of(set.kind).name()).is_some();
    let name = |set: &RaySetId| match several {
        true => format!("{} {}", set.kind.name(), set.sample + 1),
        false => set.kind.name().to_owned(),
    };
    let of_pixel = |rays: &[SampledRay]| -> Vec<Ray> {
        rays.iter().zip(sets).filter(|&(_, set)| traced(set)).map(|(sampled, _)| ray(sampled)).collect()
    };
    let names: Vec<String> = sets.iter().filter(|set| traced(set)).map(name).collect();
    let &tracer::RaySample { every, first, size, ref rays } = sample;
    (!names.is_empty()).then(|| RaySample {
        every,
        first,
        size,
        sets: names,
        operations: OPERATIONS.into(),
        rays: rays.chunks(sets.len()).flat_map(of_pixel).collect(),
    })
}

fn ray(SampledRay { steps, hit }: &SampledRay) -> Ray {
    let end = match *hit {
        NOT_CAST => RayEnd::NotCast,
        hit if hit < NOT_CAST => RayEnd::Hit(hit),
        _ => RayEnd::Miss,
    };
    let step = |step: &Step| match (step.op(), step.id()) {
        (Op::AnyHit, id) if id & DECIDED_BY_MICROMAP != 0 => (BY_MICROMAP, id & !DECIDED_BY_MICROMAP),
        (op, id) => (op as u8, id),
    };
    Ray { end, steps: steps.iter().map(step).collect() }
}
