//! Metrics of claims that are no counters. Their definitions are in the claim file.

use crate::frame::Frame;
use crate::report::Answer;
use gpumodel::ordering::AtomicStrategy;
use gpumodel::{BufferTraffic, CacheRole, IssueCounters, Pass, ReplayConfig};
use std::time::Instant;
use tracer::{Query, RayOffset, Silent};

/// Runs of the unobserved tracer, of which the best counts.
const CPU_RUNS: u32 = 3;

/// A metric of a replayed frame, or why there is none; `None` for a metric that is not of this kind.
pub(super) fn of_replay(metric: &str, answer: &Answer, config: &ReplayConfig) -> Option<Result<f64, String>> {
    let gpu = &config.gpu;
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
        "atomics_per_queued_ray" => {
            // An add, and a maximum for the size of the next dispatch.
            let adds = counters.pass(Pass::ScreenSpace).issue.atomics / 2;
            per(adds, counters.pass(Pass::Reflection).issue.rays, "rays that are put into a buffer")
        }
        "buckets_per_warp" => {
            let strategy = config.technique.reflections.as_ref().map(|reflections| reflections.atomics);
            let width = u64::from(gpu.cores.warp_width);
            let warps = counters.pass(Pass::Reflection).issue.rays.div_ceil(width);
            match strategy {
                Some(AtomicStrategy::Subgroup | AtomicStrategy::Ballot) => {
                    per(counters.pass(Pass::BucketCount).issue.atomics, warps, "rays")
                }
                _ => Err("only atomics by subgroups are one for each bucket of a warp".to_owned()),
            }
        }
        "uber_instructions" => {
            let costs = config.costs.reflections().ok_or("the cost table has no [reflections]");
            costs.map(|costs| costs.uber_instructions(counters.materials)).map_err(str::to_owned)
        }
        "secondary_ms" => time_of(answer, |pass| !OF_PRIMARY_HITS.map(Pass::name).contains(&pass)),
        _ => {
            let (counter, passes) = metric.split_once(':')?;
            match counter {
                "pass_ms" => time_of(answer, |pass| passes.split('+').any(|name| name == pass)),
                "simt_efficiency" => {
                    let sum = |id| sum_of(answer, id, |pass| passes.split('+').any(|name| name == pass));
                    sum("alu_operations").and_then(|active| Ok(active / sum("alu_operations_issued")?))
                }
                _ => of_pass(answer, counter, passes),
            }
        }
    })
}

/// Passes that find primary hits, or bring the colour to the screen.
const OF_PRIMARY_HITS: [Pass; 5] =
    [Pass::Binning, Pass::Geometry, Pass::Primary, Pass::Output, Pass::Present];

/// The time of all passes of these names that the frame has.
fn time_of(answer: &Answer, of: impl Fn(&str) -> bool) -> Result<f64, String> {
    sum_of(answer, "frame_time_ms", of)
}

/// A counter's sum over all passes of these names that the frame has.
fn sum_of(answer: &Answer, counter: &str, of: impl Fn(&str) -> bool) -> Result<f64, String> {
    let passes = answer.report.passes.iter().filter(|pass| of(&pass.name));
    let figures = passes.filter_map(|pass| pass.counters.get(counter)?.value.as_f64());
    figures.reduce(|sum, figure| sum + figure).ok_or_else(|| "the frame has no such pass".to_owned())
}

/// A counter of one pass.
fn of_pass(answer: &Answer, counter: &str, pass: &str) -> Result<f64, String> {
    let pass = answer.report.pass(pass).ok_or("the frame has no such pass")?;
    match pass.counters.get(counter).map(|counter| &counter.value) {
        Some(reports::Value::Absent { reason }) => Err(reason.clone()),
        Some(value) => value.as_f64().ok_or_else(|| "it is not a number".to_owned()),
        None => Err("a pass has no such counter".to_owned()),
    }
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
