//! Does a frame take no longer with more ALU lanes, whole warps or not?

mod common;

use common::{Traced, config};
use gpumodel::{Fidelity, Maps, ReplayConfig, Value, estimate, replay_all};
use tracer::{Rays, TileSource, Traversal};

/// Times with so many lanes a core, of warps of 32: of what one replay of a frame asks for, or of one warp alone.
fn times(fidelity: Fidelity, lanes: &[f64]) -> Vec<f64> {
    let traced = Traced::new("cornell", Traversal::BvhStack);
    let first_rays = || (0..32).map(|x| traced.view().primary_ray(x, 20)).collect();
    let with = |&lanes: &f64| {
        let mut config = ReplayConfig { fidelity, ..config("fragment") };
        config.gpu.cores.alu_lanes = lanes;
        config
    };
    let configs: Vec<ReplayConfig> = lanes.iter().map(with).collect();
    let (frame, replays) = match fidelity {
        Fidelity::Replay => (traced.frame(), vec![configs[0].clone(); lanes.len()]),
        Fidelity::Timed => (traced.tracer(Rays::List(first_rays()), Vec::new()), configs.clone()),
    };
    let replayed = replay_all(&frame, &replays, Maps::Dropped, &|_, _| ()).expect("it can be replayed");
    let time = |(replayed, config)| {
        let found = estimate(replayed, frame.header(), frame.topology(), config).expect("it has a time");
        found.frame.get("frame_time_ms").and_then(Value::number).expect("a time")
    };
    replayed.iter().zip(&configs).map(time).collect()
}

#[test]
fn a_part_of_a_warp_more_never_costs_time_and_an_instruction_never_takes_less_than_a_cycle() {
    let lanes = [16.0, 24.0, 31.0, 32.0, 40.0, 63.0, 63.999, 64.0, 64.001, 80.0, 96.0, 316.0, 1000.0, 1e9];
    // Many warps are only as smooth as the order in which they happen to run; one replay, and one warp alone, have one order.
    for (fidelity, rounding) in [(Fidelity::Replay, 2e-6), (Fidelity::Timed, 1e-12)] {
        let times = times(fidelity, &lanes);
        for (pair, lanes) in times.windows(2).zip(lanes.windows(2)) {
            assert!(pair[1] <= pair[0] * (1.0 + rounding), "{fidelity:?}, {lanes:?} lanes: {pair:?} ms");
        }
        // As one server that takes half a cycle for an instruction, 63.999 lanes would be 2 % faster.
        assert!(
            (times[6] / times[7] - 1.0).abs() < 5e-3,
            "just before and at whole warps: {fidelity:?}: {times:?}"
        );
    }
}
