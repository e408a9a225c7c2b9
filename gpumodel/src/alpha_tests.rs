//! Do any-hit shaders and micromaps cost what their description says, in shaders and where rays leave a unit?

use crate::config::{Gpu, RayScheduling, ShaderCosts};
use crate::counters::{IssueCounters, Pass, Value};
use crate::estimate::estimate;
use crate::mock::{MockRay, Recorded, config};
use crate::replay::{Fidelity, Maps, ReplayConfig, Replayed, replay};
use proptest::prelude::*;
use tracer::wide::NodeFormat;
use tracer::{
    Accel, AlphaMode, AlphaTests, DECIDED_BY_MICROMAP, MicromapFormat, MicromapStates, NO_HIT, Op,
    TestedTriangles, Topology, TopologyNode,
};

const FORMAT: MicromapFormat = MicromapFormat { level: 4, states: MicromapStates::Four };

/// A trace of a wide BVH whose 64 triangles, all of one node, are alpha-tested from the ninth on.
fn source(mode: AlphaMode, rays: &[MockRay]) -> Recorded {
    let mut source = Recorded::list(Accel::WideBvh, "stack", 64, rays);
    let root = TopologyNode::Wide { first: 1, count: 8, leaves: 0 };
    let below = TopologyNode::Wide { first: 9, count: 0, leaves: 8 };
    let nodes = std::iter::once(root).chain((0..8).map(|_| below)).collect();
    source.topology = Topology { nodes, references: (0..64).collect(), triangles: 64, ..Topology::default() };
    source.header.node_format = Some(NodeFormat::Compressed8);
    let micromap = (mode == AlphaMode::Micromap).then_some(FORMAT);
    let tested = TestedTriangles::Runs(vec![[8, 56]]);
    source.header.alpha = Some(AlphaTests { mode, tested, micromap });
    source
}

fn machine(name: &str) -> ReplayConfig {
    config(Gpu::builtin(name).expect("it is built in").expect("it is valid"))
}

fn run(source: &Recorded, config: &ReplayConfig) -> Replayed {
    replay(source, config, Maps::Dropped, &|_, _| {}).expect("the mock is valid")
}

fn issue(source: &Recorded, config: &ReplayConfig) -> IssueCounters {
    run(source, config).counters.pass(Pass::Primary).issue
}

fn number(source: &Recorded, config: &ReplayConfig, id: &str) -> Option<f64> {
    let estimate = estimate(&run(source, config), &source.header, &source.topology, config);
    estimate.expect("solvable").frame.get(id).and_then(Value::number)
}

/// A ray that tests a triangle and asks about it, `times` over.
fn asks(triangle: u32, times: u32, flags: u32) -> MockRay {
    let ask = (0..times).flat_map(|_| [(Op::Primitive, triangle), (Op::AnyHit, triangle | flags)]);
    (std::iter::once((Op::Node, 0)).chain(ask).collect(), NO_HIT)
}

fn without(source: &Recorded) -> Recorded {
    let rays: Vec<MockRay> = (0..source.tiles[0].ray_sets[0].ends.len())
        .map(|ray| {
            let set = &source.tiles[0].ray_sets[0];
            let steps = set.steps[set.range(ray)].iter().map(|step| (step.op(), step.id()));
            (steps.filter(|&(op, _)| op != Op::AnyHit).collect(), set.hits[ray])
        })
        .collect();
    let mut plain =
        Recorded { tiles: Recorded::list(Accel::WideBvh, "stack", 64, &rays).tiles, ..source.clone() };
    plain.header.alpha = None;
    plain
}

#[test]
fn a_shader_costs_its_operations_its_attributes_and_a_texel() {
    let source = source(AlphaMode::AnyHit, &vec![asks(9, 1, 0); 32]);
    for name in ["adreno-540", "mali-g78", "mali-g715", "mali-g1-ultra", "adreno-750"] {
        let config = machine(name);
        let (with, plain) = (issue(&source, &config), issue(&without(&source), &config));
        let costs = config.costs.alpha(&source.header).expect("the table has them");
        let unit = config.gpu.ray_unit_for(&source.header);
        let loads = 3;
        let mut alu = costs.any_hit.alu + loads * config.costs.shared.address.alu;
        alu += if unit.is_some() { costs.resume.alu } else { 0 };
        assert_eq!(with.alu_active - plain.alu_active, 32 * u64::from(alu), "{name}");
        assert_eq!((with.any_hits, with.non_opaque_hits, plain.any_hits), (32, 32, 0), "{name}");
        let warps = 32 / u64::from(config.gpu.cores.warp_width).min(32);
        assert_eq!(with.turns - plain.turns, 2 * warps, "attributes and then the texel, {name}");
        let bytes = with.lane_bytes - plain.lane_bytes;
        assert_eq!(bytes, 32 * u64::from(loads * 16 + 1), "{name}");
        let image = run(&source, &config).counters.pass(Pass::Primary).traffic.image;
        assert!(image.levels.iter().any(|level| level.accesses > 0), "{name} reads the mask");
    }
}

#[test]
fn warps_leave_a_unit_that_walks_once_for_all_of_their_rays_that_wait() {
    // Half of a warp asks twice, the other half three times.
    let rays: Vec<MockRay> = (0..16).map(|lane| asks(9, 2 + lane % 2, 0)).collect();
    let source = source(AlphaMode::AnyHit, &rays);
    for name in ["mali-g715", "mali-g1-ultra"] {
        let issue = issue(&source, &machine(name));
        assert_eq!((issue.unit_returns, issue.resumed_rays), (3, 40), "{name}");
    }
    let by_shader = issue(&source, &machine("mali-g78"));
    assert_eq!((by_shader.unit_returns, by_shader.resumed_rays, by_shader.any_hits), (0, 0, 40));
}

#[test]
fn a_ray_whose_any_hit_answers_the_query_does_not_go_on() {
    let mut source = source(AlphaMode::AnyHit, &vec![(asks(9, 1, 0).0, 9); 16]);
    let config = machine("mali-g715");
    assert_eq!(issue(&source, &config).resumed_rays, 16, "a closest hit may lie behind");
    source.header.ray_sets = vec![tracer::RaySetId::PRIMARY, tracer::RaySetId::shadow(0)];
    let shadows = source.tiles[0].ray_sets[0].clone();
    source.tiles[0].ray_sets.push(shadows);
    let shadow = run(&source, &config).counters.pass(Pass::Shadow).issue;
    assert_eq!((shadow.any_hits, shadow.resumed_rays), (16, 0));
}

#[test]
fn the_way_to_the_shader_and_back_takes_time() {
    let rays: Vec<MockRay> = (0..16 * 64).map(|ray| asks(8 + ray % 56, 3, 0)).collect();
    let source = source(AlphaMode::AnyHit, &rays);
    let times = [0.0, 40.0, 4000.0, 400_000.0].map(|cycles| {
        let mut config = machine("mali-g715");
        config.gpu.ray_unit.as_mut().expect("it has one").return_cycles = Some(cycles);
        number(&source, &config, "frame_time_ms").expect("a time")
    });
    assert!(times.is_sorted() && times[3] > times[0], "{times:?}");
    // Three returns of a warp, one after the other, whatever else is at work.
    let least = 3.0 * 400_000.0 / 888e3;
    assert!(times[3] >= least && times[3] < 1.2 * (least + times[0]), "{times:?}, {least} expected");
}

#[test]
fn micromaps_take_a_word_of_their_own_and_spare_the_rest() {
    let config = machine("mali-g715");
    let rays = |flags| vec![asks(9, 1, flags); 16];
    let known = source(AlphaMode::Micromap, &rays(DECIDED_BY_MICROMAP));
    let unknown = source(AlphaMode::Micromap, &rays(0));
    let tested = source(AlphaMode::AnyHit, &rays(0));
    let [known, unknown, tested] = [known, unknown, tested].map(|source| (issue(&source, &config), source));
    assert_eq!((known.0.any_hits, known.0.non_opaque_hits), (0, 16));
    assert_eq!(known.0.unit_returns, tested.0.unit_returns, "the unit does not read them");
    let costs = config.costs.alpha(&tested.1.header).expect("the table has them");
    let look_up = 16 * u64::from(costs.micromap.alu + config.costs.shared.address.alu);
    assert_eq!(unknown.0.alu_active - tested.0.alu_active, look_up);
    assert_eq!(unknown.0.lane_bytes - tested.0.lane_bytes, 16 * 4);
    assert!(known.0.alu_active < unknown.0.alu_active && known.0.turns < unknown.0.turns);
    let bytes = run(&known.1, &config).buffers;
    assert_eq!((bytes.micromap, bytes.mask), (56 * 64, u64::from(costs.mask_bytes)));
}

#[test]
fn triangles_without_a_micromap_cannot_be_looked_up() {
    let source = source(AlphaMode::Micromap, &vec![asks(7, 1, 0); 16]);
    let refused = replay(&source, &machine("mali-g715"), Maps::Dropped, &|_, _| {}).expect_err("it is wrong");
    assert!(refused.to_string().contains("opacity micromap of primitive 7"), "{refused}");
}

#[test]
fn rays_that_ask_no_shader_pay_for_none() {
    let rays = vec![(vec![(Op::Node, 0), (Op::Primitive, 9)], 9); 64];
    for mode in [AlphaMode::Opaque, AlphaMode::Cull] {
        let source = source(mode, &rays);
        for name in ["adreno-540", "mali-g1-ultra"] {
            let (with, plain) = (run(&source, &machine(name)), run(&without(&source), &machine(name)));
            assert_eq!((with.counters, with.buffers), (plain.counters, plain.buffers), "{name}");
            assert_eq!(number(&source, &machine(name), "any_hits"), None);
        }
    }
}

#[test]
fn registers_of_the_any_hit_shader_decide_how_many_warps_are_resident() {
    let source = source(AlphaMode::AnyHit, &vec![asks(9, 1, 0); 16]);
    let table = include_str!("../../configs/costs.toml");
    let resident = |registers: u32| {
        let text = table.replace(
            "[alpha]\nregisters = { value = 6",
            &format!("[alpha]\nregisters = {{ value = {registers}"),
        );
        let costs = ShaderCosts::parse(&text, "costs.toml").expect("it is valid");
        let config = ReplayConfig { costs, ..machine("mali-g715") };
        run(&source, &config).resident_warps[Pass::Primary as usize]
    };
    assert_eq!(resident(8), 2 * resident(9));
}

#[test]
fn shaders_that_walk_test_on_the_timed_rung_too() {
    let rays: Vec<MockRay> = (0..320).map(|ray| asks(8 + ray % 56, 2, 0)).collect();
    let source = source(AlphaMode::AnyHit, &rays);
    let timed = ReplayConfig { fidelity: Fidelity::Timed, ..machine("adreno-540") };
    let (with, plain) = (
        number(&source, &timed, "frame_time_ms").expect("a time"),
        number(&without(&source), &timed, "frame_time_ms").expect("a time"),
    );
    assert!(with > plain, "{with} and {plain}");
    let counters = |config: &ReplayConfig| issue(&source, config);
    assert_eq!(counters(&timed), counters(&machine("adreno-540")), "rungs count the same");
}

proptest! {
    #[test]
    fn what_is_asked_is_counted_whatever_the_scheduling(times in prop::collection::vec((0_u32..4, 8_u32..64), 1..100)) {
        let rays: Vec<MockRay> = times.iter().map(|&(times, triangle)| asks(triangle, times, 0)).collect();
        let source = source(AlphaMode::AnyHit, &rays);
        let asked: u64 = times.iter().map(|&(times, _)| u64::from(times)).sum();
        for scheduling in RayScheduling::ALL {
            let mut config = machine("mali-g715");
            config.gpu.ray_unit.as_mut().expect("it has one").scheduling = scheduling;
            let issue = issue(&source, &config);
            prop_assert_eq!((issue.any_hits, issue.non_opaque_hits), (asked, asked));
            if scheduling != RayScheduling::Instruction {
                let rounds = times.chunks(16).map(|warp| warp.iter().map(|&(times, _)| u64::from(times)).max());
                prop_assert_eq!(issue.unit_returns, rounds.flatten().sum::<u64>());
                prop_assert_eq!(issue.resumed_rays, asked);
            }
        }
    }
}
