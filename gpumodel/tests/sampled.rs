//! Is a sample of a frame worth what it says it is?

mod common;

use common::Traced;
use gpumodel::{Attempt, Goal, Maps, ReplayConfig, Sampled, Sampler, estimate, replay, unsampled};
use std::time::{Duration, Instant};
use tracer::{FrameTracer, Rays, TileSource, Traversal, View};

const EDGE: u32 = 640;

fn frame(traced: &Traced) -> FrameTracer<'_> {
    let view = View::new(&traced.scene.camera, EDGE, EDGE);
    traced.tracer(Rays::View { view, width: EDGE, height: EDGE }, traced.lights.clone())
}

fn number(sampled: &Sampled, id: &str) -> f64 {
    sampled.estimate.frame.get(id).and_then(|value| value.number()).expect("the frame has it")
}

#[test]
fn a_sample_of_everything_counts_what_a_replay_counts() {
    let traced = Traced::new("atrium", Traversal::BvhStack);
    let frame = frame(&traced);
    for technique in ["fragment", "compute"] {
        let config = common::config(technique);
        let whole = replay(&frame, &config, Maps::Dropped, &|_, _| {}).expect("valid");
        let sampler = Sampler::new(&frame, &config).expect("it can be sampled");
        let all = sampler.sample(1e3, 0).expect("valid").replayed;
        for (of_all, of_whole) in all.counters.passes.iter().zip(&whole.counters.passes) {
            assert_eq!(of_all.issue, of_whole.issue, "{technique}");
        }
        // The warps that a block begins among are not quite those that the block before ended with.
        let [of_all, of_whole] =
            [&all, &whole].map(|of| of.counters.total().traffic.total().levels[1].accesses as f64);
        assert!((of_all / of_whole - 1.0).abs() < 0.02, "{technique}: {of_all} {of_whole}");
        assert_eq!(all.counters.schedule.warps, whole.counters.schedule.warps);
    }
}

#[test]
fn intervals_hold_the_replays_figures_and_what_is_known_is_exact() {
    let traced = Traced::new("atrium", Traversal::BvhStack);
    let frame = frame(&traced);
    let config = common::config("fragment");
    let whole = replay(&frame, &config, Maps::Dropped, &|_, _| {}).expect("valid");
    let whole = estimate(&whole, frame.header(), frame.topology(), &config).expect("solvable");
    let sampler = Sampler::new(&frame, &config).expect("it can be sampled");
    let seeds = 40;
    for (id, least) in [("frame_time_ms", 34), ("alu_operations", 34), ("dram_read_bytes", 34)] {
        let truth = whole.frame.get(id).and_then(|value| value.number()).expect("the frame has it");
        let holds = |&seed: &u64| {
            let sampled = sampler.sample(0.3, seed).expect("valid");
            let [low, high] = sampled.intervals.of_frame(id).expect("it has an interval");
            assert!((low..=high).contains(&number(&sampled, id)));
            (low..=high).contains(&truth)
        };
        let covered = (0..seeds).filter(holds).count();
        assert!(covered >= least, "{id}: {covered} of {seeds}");
    }
    let sampled = sampler.sample(0.3, 1).expect("valid");
    for id in ["fragments", "warps", "structure_bytes"] {
        let truth = whole.frame.get(id).and_then(|value| value.number()).expect("the frame has it");
        assert_eq!(sampled.margin(id), 0.0, "{id}");
        assert_eq!(number(&sampled, id), truth, "{id}");
    }
    assert!(sampled.margin("frame_time_ms") > 0.0);
}

#[test]
fn a_seed_gives_the_same_sample_on_any_number_of_threads_and_another_seed_another() {
    let traced = Traced::new("atrium", Traversal::KdBacktrack);
    let config = common::config("fragment");
    let run = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let frame = frame(&traced);
            let sampled = Sampler::new(&frame, &config).expect("valid").sample(0.3, seed).expect("valid");
            (sampled.replayed.counters, sampled.intervals)
        })
    };
    let one = run(1, 5);
    assert!(one == run(2, 5) && one == run(3, 5));
    assert!(one != run(2, 6));
}

#[test]
fn goals_are_reached_or_the_whole_frame_is_asked_for() {
    let traced = Traced::new("atrium", Traversal::BvhStack);
    let frame = frame(&traced);
    let config = common::config("fragment");
    let sampler = Sampler::new(&frame, &config).expect("valid");
    let within = |tolerance: f64| Goal::Within(vec![("frame_time_ms".to_owned(), tolerance)]);
    match sampler.reach(&within(0.5), 0).expect("valid") {
        Attempt::Sampled(sampled) => assert!(sampled.margin("frame_time_ms") <= 0.5),
        _ => panic!("half of the time is a wide interval"),
    }
    assert!(matches!(sampler.reach(&within(1e-9), 0).expect("valid"), Attempt::Whole(_)));
    let in_time = |seconds: u64| Goal::By(Instant::now() + Duration::from_secs(seconds));
    assert!(matches!(sampler.reach(&in_time(600), 0).expect("valid"), Attempt::Whole(_)));
    assert!(matches!(sampler.reach(&in_time(0), 0).expect("valid"), Attempt::TooLate(_)));
}

#[test]
fn small_frames_and_drawn_geometry_are_not_sampled() {
    let traced = Traced::new("cornell", Traversal::BvhStack);
    let frame = traced.frame();
    let config: ReplayConfig = common::config("fragment");
    let sampler = Sampler::new(&frame, &config).expect("valid");
    assert!(matches!(sampler.reach(&Goal::Part(0.1), 0).expect("valid"), Attempt::Whole(_)));
    assert!(unsampled(&common::config("hybrid").technique).is_some());
    assert!(unsampled(&config.technique).is_none());
}
