//! Is a sample of a frame worth what it says it is?

mod common;

use common::Traced;
use gpumodel::{
    Attempt, Estimate, Goal, Maps, NodeOrder, PrimitiveLayout, Ratio, ReplayConfig, Sampled, Sampler,
    estimate, replay, replay_all, unsampled,
};
use std::time::{Duration, Instant};
use tracer::{FrameTracer, Rays, Tile, TileOutline, TileSource, Topology, TraceHeader, Traversal, View};

const EDGE: u32 = 640;

fn frame(traced: &Traced) -> FrameTracer<'_> {
    let view = View::new(&traced.scene.camera, EDGE, EDGE);
    traced.tracer(Rays::View { view, width: EDGE, height: EDGE }, traced.lights.clone())
}

fn sampler<'a>(frame: &'a FrameTracer<'_>, config: &'a ReplayConfig) -> Sampler<'a, FrameTracer<'a>> {
    Sampler::new(frame, std::slice::from_ref(config)).expect("it can be sampled")
}

fn sample(sampler: &Sampler<'_, FrameTracer<'_>>, part: f64, seed: u64) -> Sampled {
    sampler.sample(part, seed).expect("valid").remove(0)
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
        let all = sample(&sampler(&frame, &config), 1e3, 0).replayed;
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
    let sampler = sampler(&frame, &config);
    let seeds = 40;
    for (id, least) in [("frame_time_ms", 34), ("alu_operations", 34), ("dram_read_bytes", 34)] {
        let truth = whole.frame.get(id).and_then(|value| value.number()).expect("the frame has it");
        let holds = |&seed: &u64| {
            let sampled = sample(&sampler, 0.3, seed);
            let [low, high] = sampled.intervals.of_frame(id).expect("it has an interval");
            assert!((low..=high).contains(&number(&sampled, id)));
            (low..=high).contains(&truth)
        };
        let covered = (0..seeds).filter(holds).count();
        assert!(covered >= least, "{id}: {covered} of {seeds}");
    }
    let sampled = sample(&sampler, 0.3, 1);
    for id in ["fragments", "warps", "structure_bytes"] {
        let truth = whole.frame.get(id).and_then(|value| value.number()).expect("the frame has it");
        assert_eq!(sampled.margin(id), 0.0, "{id}");
        assert_eq!(number(&sampled, id), truth, "{id}");
    }
    assert!(sampled.margin("frame_time_ms") > 0.0);
}

/// The frame as it is, with split primitives, and with nodes in another order.
fn variants() -> [ReplayConfig; 3] {
    let first = common::config("fragment");
    let split = ReplayConfig { primitive_layout: PrimitiveLayout::Split, ..first.clone() };
    let breadth_first = ReplayConfig { node_order: NodeOrder::BreadthFirst, ..first.clone() };
    [first, split, breadth_first]
}

#[test]
fn what_a_change_does_is_known_better_than_what_the_frame_costs() {
    let traced = Traced::new("atrium", Traversal::BvhStack);
    let frame = frame(&traced);
    let configs = variants();
    let wholes = replay_all(&frame, &configs, Maps::Dropped, &|_, _| {}).expect("valid");
    let wholes: Vec<Estimate> = wholes
        .iter()
        .zip(&configs)
        .map(|(whole, config)| estimate(whole, frame.header(), frame.topology(), config).expect("solvable"))
        .collect();
    let truth = |id: &str, variant: usize| {
        let number =
            |of: &Estimate| of.frame.get(id).and_then(|value| value.number()).expect("the frame has it");
        number(&wholes[variant]) / number(&wholes[0])
    };
    let recorded = AsRecorded(&frame);
    // Of recorded tiles, the caches see more of what comes before a block.
    let samplers: [&dyn Fn(u64) -> Vec<Sampled>; 2] =
        [&|seed| Sampler::new(&frame, &configs).expect("valid").sample(0.3, seed).expect("valid"), &|seed| {
            Sampler::new(&recorded, &configs).expect("valid").sample(0.3, seed).expect("valid")
        }];
    let seeds = 20;
    let ids = ["frame_time_ms", "dram_read_bytes", "l2_misses"];
    let mut widths = [[0.0; 3]; 2];
    for (sample, widths) in samplers.into_iter().zip(&mut widths) {
        let (mut covered, mut narrower) = ([[0; 3]; 3], [[0; 3]; 3]);
        for sampled in (0..seeds).map(sample) {
            for (variant, this) in sampled.iter().enumerate().skip(1) {
                let ratios = this.ratios_to(&sampled[0]).expect("of the same blocks");
                for (place, id) in ids.into_iter().enumerate() {
                    let (_, Ratio { ci95: [low, high], .. }) =
                        *ratios.iter().find(|(of, _)| *of == id).expect("it has an interval");
                    let found = number(this, id) / number(&sampled[0], id);
                    assert!((low..=high).contains(&found), "{id}: {found} not in {low}..{high}");
                    covered[place][variant] += u32::from((low..=high).contains(&truth(id, variant)));
                    narrower[place][variant] += u32::from((high - low) / 2.0 < sampled[0].margin(id));
                    widths[place] += high - low;
                }
            }
        }
        for (place, id) in ids.into_iter().enumerate() {
            for variant in [1, 2] {
                let (covered, narrower) = (covered[place][variant], narrower[place][variant]);
                assert!(covered >= 17, "{id} of variant {variant}: {covered} of {seeds}");
                assert!(narrower >= 19, "{id} of variant {variant}: {narrower} of {seeds}");
            }
        }
    }
    assert!(widths[1][1] < 0.7 * widths[0][1] && widths[1][2] < 0.7 * widths[0][2], "{widths:?}");
}

/// A tracer whose tiles are taken to be recorded.
struct AsRecorded<'a>(&'a FrameTracer<'a>);

impl TileSource for AsRecorded<'_> {
    fn header(&self) -> &TraceHeader {
        self.0.header()
    }

    fn topology(&self) -> &Topology {
        self.0.topology()
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), tracer::Error> {
        self.0.tile(index, tile)
    }

    fn outline(&self, index: u32) -> Result<Option<TileOutline>, tracer::Error> {
        self.0.outline(index)
    }

    fn is_recorded(&self) -> bool {
        true
    }

    fn stalls(&self) -> u64 {
        self.0.stalls()
    }
}

#[test]
fn variants_that_fill_the_cores_alike_are_sampled_together_as_they_are_alone() {
    let traced = Traced::new("atrium", Traversal::BvhStack);
    let frame = frame(&traced);
    let configs = variants();
    let together = Sampler::new(&frame, &configs).expect("valid").sample(0.3, 3).expect("valid");
    for (of_all, config) in together.iter().zip(&configs) {
        let alone = sample(&sampler(&frame, config), 0.3, 3);
        assert!(of_all.replayed.counters == alone.replayed.counters && of_all.intervals == alone.intervals);
    }
    let itself = together[1].ratios_to(&together[1]).expect("of the same blocks");
    assert!(!itself.is_empty() && itself.iter().all(|&(_, ratio)| ratio.ci95 == [1.0, 1.0]));
    let elsewhere = sample(&sampler(&frame, &configs[0]), 0.3, 4);
    assert!(together[1].ratios_to(&elsewhere).is_none(), "of other blocks");
}

#[test]
fn changes_are_sampled_until_they_are_known() {
    let traced = Traced::new("atrium", Traversal::BvhStack);
    let frame = frame(&traced);
    let configs = variants();
    let sampler = Sampler::new(&frame, &configs).expect("valid");
    let goal = Goal::Within(vec![("frame_time_ms".to_owned(), 0.02)]);
    let Attempt::Sampled(sampled) = sampler.reach(&goal, 0).expect("valid") else {
        panic!("layouts and orders change little of the time");
    };
    for this in &sampled[1..] {
        let ratios = this.ratios_to(&sampled[0]).expect("of the same blocks");
        let (_, Ratio { ci95: [low, high], .. }) =
            ratios.into_iter().find(|(id, _)| *id == "frame_time_ms").expect("it has an interval");
        let found = number(this, "frame_time_ms") / number(&sampled[0], "frame_time_ms");
        assert!(high - found <= 0.02 && found - low <= 0.02, "{low} {found} {high}");
    }
}

#[test]
fn a_seed_gives_the_same_sample_on_any_number_of_threads_and_another_seed_another() {
    let traced = Traced::new("atrium", Traversal::KdBacktrack);
    let config = common::config("fragment");
    let run = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let frame = frame(&traced);
            let sampled = sample(&sampler(&frame, &config), 0.3, seed);
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
    let sampler = sampler(&frame, &config);
    let within = |tolerance: f64| Goal::Within(vec![("frame_time_ms".to_owned(), tolerance)]);
    match sampler.reach(&within(0.5), 0).expect("valid") {
        Attempt::Sampled(sampled) => assert!(sampled[0].margin("frame_time_ms") <= 0.5),
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
    let sampler = sampler(&frame, &config);
    assert!(matches!(sampler.reach(&Goal::Part(0.1), 0).expect("valid"), Attempt::Whole(_)));
    assert!(unsampled(&common::config("hybrid").technique).is_some());
    assert!(unsampled(&config.technique).is_none());
}
