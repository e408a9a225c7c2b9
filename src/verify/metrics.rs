//! Metrics of claims that are no counters. Their definitions are in the claim file.

use crate::frame::Frame;
use crate::report::Answer;
use gpumodel::{BufferTraffic, CacheRole, Gpu, IssueCounters, Pass};
use std::time::Instant;
use tracer::{Query, RayOffset, RaySet, Silent};

/// Runs of the unobserved tracer, of which the best counts.
const CPU_RUNS: u32 = 3;
/// Directions per axis of the grid on which a normal's encoding is tried: 6 x 64 x 64 unit normals.
const NORMALS_PER_EDGE: u32 = 64;

/// A metric of a replayed frame, or why there is none; `None` for a metric that is not of this kind.
pub(super) fn of_replay(metric: &str, answer: &Answer, gpu: &Gpu) -> Option<Result<f64, String>> {
    let counters = &answer.replayed.counters;
    let issue = counters.total().issue;
    let IssueCounters {
        rays, node_steps, up_steps, node_fetches, node_alu, primitive_alu, alu_active, ..
    } = issue;
    let per = |amount: u64, of: u64, what: &str| {
        if of > 0 { Ok(amount as f64 / of as f64) } else { Err(format!("there are no {what}")) }
    };
    Some(match metric {
        "node_steps_per_ray" => per(node_steps, rays, "rays"),
        "traversal_steps_per_ray" => per(node_steps + up_steps, rays, "rays"),
        "node_fetches_without_up_per_ray" => per(node_fetches - up_steps, rays, "rays"),
        "alu_per_node_step" => per(node_alu, node_steps, "node steps"),
        "primitive_alu_share" => per(primitive_alu, alu_active, "operations"),
        "intersection_alu_share" => per(primitive_alu + node_alu, alu_active, "operations"),
        "restarts" => Ok(issue.restarts as f64),
        "node_bytes" => per(answer.replayed.structure_bytes, structure_nodes(answer), "nodes"),
        "node_l1_miss_ratio" | "node_l2_miss_ratio" => {
            let role = if metric == "node_l1_miss_ratio" { CacheRole::L1 } else { CacheRole::L2 };
            let mut nodes = BufferTraffic::default();
            counters.passes.iter().for_each(|pass| nodes += pass.traffic.node);
            let level = gpu.paths.ssbo.iter().copied().find(|&level| gpu.caches[level].role == role);
            match level.map(|level| nodes.levels[level]) {
                Some(served) => per(served.misses, served.accesses, "accesses"),
                None => Err("buffers do not go through a cache of that level".to_owned()),
            }
        }
        "pass_ms:present" => {
            let present = answer.report.pass(Pass::Present.name());
            let time = present.and_then(|pass| pass.counters.get("frame_time_ms")?.value.as_f64());
            time.ok_or_else(|| "the technique has no such pass".to_owned())
        }
        "normal_error_printed" => Ok(normal_error(1.0)),
        "normal_error_half" => Ok(normal_error(0.5)),
        _ => return None,
    })
}

fn structure_nodes(answer: &Answer) -> u64 {
    let nodes = answer.report.counters.get("structure_nodes");
    nodes.and_then(|nodes| nodes.value.as_f64()).unwrap_or(0.0) as u64
}

/// A metric of a built structure; `None` for a metric that is not of this kind.
pub(super) fn of_structure(metric: &str, frame: &Frame<'_>, [ct, ci]: [f64; 2]) -> Option<f64> {
    let structure = &frame.structure;
    Some(match metric {
        "depth" => f64::from(structure.depth()),
        "empty_leaves" => structure.leaf_counts().empty as f64,
        "flat_leaves" => structure.leaf_counts().flat as f64,
        "splits_costlier_than_leaf" => structure.splits_costlier_than_leaf(ct, ci) as f64,
        _ => return None,
    })
}

/// Largest error of any component of a unit normal that is stored as `n * 0.5 + offset` in 8 bits, clamped to [0, 1] and rounded to
/// nearest.
fn normal_error(offset: f64) -> f64 {
    let mut worst = 0.0_f64;
    let coordinate = |step: u32| (f64::from(step) + 0.5) / f64::from(NORMALS_PER_EDGE) * 2.0 - 1.0;
    for (a, b) in (0..NORMALS_PER_EDGE).flat_map(|a| (0..NORMALS_PER_EDGE).map(move |b| (a, b))) {
        let (a, b) = (coordinate(a), coordinate(b));
        let length = (a * a + b * b + 1.0).sqrt();
        // The cube's other faces permute these components and their signs.
        for component in [a / length, b / length, 1.0 / length, -1.0 / length] {
            let stored = ((component * 0.5 + offset).clamp(0.0, 1.0) * 255.0).round() / 255.0;
            worst = worst.max(((stored - offset) / 0.5 - component).abs());
        }
    }
    worst
}

/// Rays per second / 10^6 of the unobserved tracer on one thread.
pub(super) fn cpu_mrays_per_second(frame: &Frame<'_>, [width, height]: [u32; 2]) -> f64 {
    let (view, lights, triangles) = (frame.view(), frame.lights(), frame.triangles());
    let offset = RayOffset::new(triangles);
    let run = || {
        let mut rays = 0_u64;
        let start = Instant::now();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let ray = view.primary_ray(x, y);
            let hit = frame.structure.trace(&ray, Query::Closest, &mut Silent);
            rays += 1;
            for &light in lights.iter().filter(|_| hit.is_hit()) {
                let shadow =
                    offset.shadow_ray(&triangles[hit.primitive as usize], hit.u, hit.v, ray.direction, light);
                std::hint::black_box(frame.structure.trace(&shadow, Query::Any, &mut Silent));
                rays += 1;
            }
        }
        rays as f64 / start.elapsed().as_secs_f64() / 1e6
    };
    (0..CPU_RUNS).map(|_| run()).fold(0.0, f64::max)
}

/// Which audits of a trace a setup asks for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Audits {
    pub(super) leaves_tested_twice: bool,
    pub(super) restarts_above_push_down: bool,
}

impl Audits {
    pub(super) fn any(self) -> bool {
        self.leaves_tested_twice || self.restarts_above_push_down
    }
}

/// What the audits of one ray set found: leaves tested twice, restarts above the push-down node.
pub(super) fn audit(
    audits: Audits,
    topology: &tracer::Topology,
    set: &RaySet,
    stack: Option<&RaySet>,
) -> [u64; 2] {
    let twice =
        if audits.leaves_tested_twice { tracer::audit::leaves_tested_twice(topology, set) } else { 0 };
    let above = match stack {
        Some(stack) => tracer::audit::restarts_above_push_down(topology, stack, set),
        None => 0,
    };
    [twice, above]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_an_offset_keeps_a_normal_to_half_a_step_and_a_whole_one_loses_it() {
        assert!(normal_error(0.5) <= 1.0 / 255.0 + 1e-12, "{}", normal_error(0.5));
        assert!(normal_error(1.0) > 0.9, "positive components are clamped");
    }
}
