//! What adds up many terms: whole numbers, which must not overflow, and floats, which must not lose what they add.

use super::frames::{Traced, config, estimated, gpu, seconds};
use crate::case::{Case, Limit};
use crate::structures::Watch;
use crate::{Size, shapes};
use cachesim::LevelServed;
use gpumodel::{BufferTraffic, Fidelity, Maps, PassCounters, Replayed, Window, replay};
use num_bigint::BigInt;
use num_traits::ToPrimitive;
use tracer::bvh::{Bvh, BvhNodeKind, BvhOptions};

/// Frames whose counts are added up, as a power of two.
const FRAMES: u32 = 24;

pub(crate) fn cases(size: Size, _: &Watch) -> Vec<Case> {
    let traced = Traced::new();
    let frame = traced.frame(size.of(32, 64));
    let config = config(gpu("adreno-540"), Fidelity::Replay);
    let replayed = replay(&frame, &config, Maps::Dropped, &|_, _| ()).expect("the frame can be replayed");
    let many = times_frames(&replayed);
    let (one, all) = (estimated(&frame, &replayed, &config), estimated(&frame, &many, &config));
    let total = many.counters.total();
    let factor = f64::from(1_u32 << FRAMES);
    let steps = replayed.counters.total().issue.lane_steps as f64 * factor;
    let mut cases = vec![
        Case::new(
            "sums/counters",
            "the counts of a frame, added to themselves until they have 1e10 terms, are the product",
            "wrong counts",
            Limit::AtMost(0.0),
            wrong_counts(&replayed.counters.total(), &total) as f64,
        )
        .under("steps added up", steps),
        Case::new(
            "sums/terms",
            "the counts that were added up have at least 1e10 terms",
            "steps of lanes",
            Limit::AtLeast(1e10),
            steps,
        ),
        Case::new(
            "sums/time",
            "the time of as many frames is as many times the time of one",
            "relative error",
            Limit::AtMost(1e-12),
            (seconds(&all) / seconds(&one) / factor - 1.0).abs(),
        )
        .with_residual(one.residual.max(all.residual)),
        Case::new(
            "sums/margin",
            "a frame of 2^26 pixels, each with a thousand times the bytes of a pixel of this one, fits in 64 bits",
            "share of 2^64",
            Limit::AtMost(1.0),
            largest_count(&replayed) / f64::from(frame_pixels(size)) * f64::from(1 << 26) * 1e3
                / 2.0_f64.powi(64),
        ),
    ];
    cases.push(surface_areas(size));
    cases.push(simulated(&traced, size));
    cases
}

fn frame_pixels(size: Size) -> u32 {
    size.of(32 * 32, 64 * 64)
}

/// The counts of 2^24 frames, by doubling.
fn times_frames(replayed: &Replayed) -> Replayed {
    let mut many = replayed.clone();
    for _ in 0..FRAMES {
        let counters = &mut many.counters;
        for pass in &mut counters.passes {
            let other: PassCounters = *pass;
            *pass += other;
        }
        let flush: BufferTraffic = counters.flush;
        counters.flush += flush;
        let schedule = counters.schedule;
        counters.schedule += schedule;
        for window in many.phases.iter_mut().flat_map(|phase| &mut phase.windows) {
            let Window { ticks, turns, warp_ticks, levels, memory_bytes, page_walks, waits } = window;
            for count in [ticks, turns, warp_ticks, memory_bytes, page_walks] {
                *count *= 2;
            }
            for LevelServed { accesses, misses } in levels {
                *accesses *= 2;
                *misses *= 2;
            }
            let other = *waits;
            *waits += other;
        }
    }
    many
}

/// Counts that are not 2^24 times what they were, in whole numbers wide enough for any.
fn wrong_counts(one: &PassCounters, many: &PassCounters) -> usize {
    let counts = |pass: &PassCounters| -> Vec<u128> {
        let traffic = pass.traffic.total();
        let levels = traffic.levels.iter().flat_map(|level| [level.accesses, level.misses]);
        let issue = &pass.issue;
        let counts = [
            issue.rays,
            issue.lane_steps,
            issue.node_fetches,
            issue.primitive_tests,
            issue.alu_active,
            issue.alu_issued,
            issue.line_accesses,
            issue.lane_bytes,
            issue.load_store_cycles,
            traffic.dram_read_bytes,
            traffic.dram_write_bytes,
        ];
        levels.chain(counts).map(u128::from).collect()
    };
    counts(one).iter().zip(counts(many)).filter(|(one, many)| **one << FRAMES != *many).count()
}

/// The count nearest to overflow.
fn largest_count(replayed: &Replayed) -> f64 {
    let issue = replayed.counters.total().issue;
    [issue.alu_issued, issue.lane_bytes, issue.lane_steps].into_iter().max().unwrap_or(0) as f64
}

/// The surface area heuristic of a large tree against its exact sum.
fn surface_areas(size: Size) -> Case {
    let triangles = shapes::soup(size.of(20_000, 500_000), 12);
    let bvh = Bvh::build(&triangles, &BvhOptions::MOBILE);
    let BvhOptions { traversal_cost, intersection_cost, .. } = BvhOptions::MOBILE;
    // In units of 2^-200, in which every term is whole: areas have 53 bits and are above 2^-140.
    let unit = 2.0_f64.powi(100);
    let whole = |value: f64| {
        let (mantissa, exponent) =
            (value.to_bits() & ((1 << 52) - 1) | 1 << 52, (value.to_bits() >> 52) as i64 - 1075);
        if value == 0.0 { BigInt::ZERO } else { BigInt::from(mantissa) << (exponent + 200) as u64 }
    };
    let exact: BigInt = bvh
        .nodes()
        .map(|node| {
            let cost = match node.kind {
                BvhNodeKind::Inner { .. } => traversal_cost,
                BvhNodeKind::Leaf { count, .. } => intersection_cost * f64::from(count),
            };
            whole(cost * node.bounds.half_area())
        })
        .sum();
    let exact = exact.to_f64().unwrap_or(f64::NAN) / unit / unit / bvh.node(0).bounds.half_area();
    let found = bvh.sah_cost(traversal_cost, intersection_cost).unwrap_or(f64::NAN);
    Case::new(
        "sums/surface-areas",
        "the expected cost of a tree against its sum in integers",
        "relative error",
        Limit::AtMost(1e-12),
        (found / exact - 1.0).abs(),
    )
    .under("terms", f64::from(bvh.node_count()))
}

/// Cycles of warps by what they did, added up turn by turn, against the cycles for which warps were resident.
fn simulated(traced: &Traced, size: Size) -> Case {
    let frame = traced.frame(size.of(64, 512));
    let config = config(gpu("adreno-540"), Fidelity::Timed);
    let replayed = replay(&frame, &config, Maps::Dropped, &|_, _| ()).expect("the frame can be replayed");
    let phases = replayed.timed.map_or(Vec::new(), |timed| timed.phases);
    let errors = phases.iter().map(|(_, phase)| {
        let warps = phase.warps;
        let spent = warps.waiting_to_compute
            + warps.computing
            + warps.functions
            + warps.waiting_for_port
            + warps.issuing
            + warps.waiting_for_data;
        (spent / phase.resident_warps - 1.0).abs()
    });
    Case::new(
        "sums/warp-cycles",
        "cycles of simulated warps by what they did add up to those for which they were resident",
        "relative error",
        Limit::AtMost(1e-12),
        errors.fold(0.0, f64::max),
    )
    .under("turns", replayed.counters.total().issue.turns as f64)
}
