//! What is a unit's and what a shader's where the unit is an instruction that tests one node?

use crate::config::{Gpu, ShaderCosts};
use crate::counters::{Pass, Value};
use crate::estimate::estimate;
use crate::mock::{MockRay, Recorded, config};
use crate::prepared::registers;
use crate::replay::{Fidelity, Maps, ReplayConfig, Replayed, replay};
use tracer::wide::NodeFormat;
use tracer::{Accel, LoopStructure, NO_HIT, Op, Topology, TopologyNode};

const GPUS_WITH_ONE: [&str; 4] = ["adreno-740", "adreno-750", "adreno-830", "adreno-x1-85"];

/// A root with eight inner nodes, each with eight leaves of one triangle.
fn source(traversal: &str, format: NodeFormat, rays: &[MockRay]) -> Recorded {
    let mut source = Recorded::list(Accel::WideBvh, traversal, 64, rays);
    let root = TopologyNode::Wide { first: 1, count: 8, leaves: 0 };
    let below = TopologyNode::Wide { first: 9, count: 0, leaves: 8 };
    let nodes = std::iter::once(root).chain((0..8).map(|_| below)).collect();
    source.topology = Topology { nodes, references: (0..64).collect(), triangles: 64, ..Topology::default() };
    source.header.node_format = Some(format);
    source.header.short_stack = 8;
    source.header.loop_structure = LoopStructure::IfIf;
    source
}

fn gpu(name: &str, with_unit: bool) -> Gpu {
    let mut gpu = Gpu::builtin(name).expect("it is built in").expect("it is valid");
    gpu.ray_unit = gpu.ray_unit.filter(|_| with_unit);
    gpu
}

fn run(source: &Recorded, config: &ReplayConfig) -> Replayed {
    replay(source, config, Maps::Dropped, &|_, _| {}).expect("the mock is valid")
}

fn steps() -> Vec<(Op, u32)> {
    vec![
        (Op::Node, 0),
        (Op::Push, 0),
        (Op::Node, 1),
        (Op::Primitive, 0),
        (Op::Pop, 0),
        (Op::Node, 2),
        (Op::Restart, 0),
        (Op::Node, 0),
    ]
}

#[test]
fn the_shader_pays_for_its_loop_and_the_unit_for_the_tests() {
    let source = source("short-stack", NodeFormat::Adreno8, &vec![(steps(), NO_HIT); 64]);
    for name in GPUS_WITH_ONE {
        let config = config(gpu(name, true));
        let pass = *run(&source, &config).counters.pass(Pass::Primary);
        let around = config.costs.of_shader(&source.header, &config.gpu).expect("the table has them");
        let shared = &config.costs.shared;
        // Five trips: to node 0; to node 1; its triangle; node 2; node 0 again.
        let per_ray = shared.camera_ray.alu
            + around.start.alu
            + 4 * around.node.alu
            + around.push.alu
            + around.pop.alu
            + around.restart.alu
            + around.primitive.alu
            + 5 * shared.trip.alu;
        assert_eq!(pass.issue.alu_active, 64 * u64::from(per_ray), "{name}");
        assert_eq!(
            (pass.issue.box_nodes, pass.issue.unit_box_tests),
            (64 * 4, 64 * 4 * 8),
            "each ray by itself"
        );
        assert_eq!(pass.issue.unit_box_places, pass.issue.unit_box_tests);
        assert_eq!(pass.issue.unit_triangle_places, 64);
        assert_eq!((pass.issue.restarts, pass.issue.rays), (64, 64));
        assert_eq!(pass.traffic.stack, Default::default(), "it is in registers");
        let estimate = estimate(&run(&source, &config), &source.header, &source.topology, &config);
        let restarts = estimate.expect("solvable").frame.get("restarts").and_then(Value::number);
        assert_eq!(restarts, Some(64.0));
        // A line for each node and triangle of each warp, as all its rays go together.
        let warps = 64 / u64::from(config.gpu.cores.warp_width);
        let lines_of_triangle = pass.issue.line_accesses / warps.max(1) - 4;
        assert!((1..=2).contains(&lines_of_triangle), "{name}: {lines_of_triangle}");
    }
}

/// Two instances, below one node, of a mesh of one node with eight triangles.
fn two_levels(rays: &[MockRay]) -> Recorded {
    let tree = |leaves: u32| Topology {
        nodes: vec![TopologyNode::Wide { first: 1, count: 0, leaves }],
        references: (0..leaves).collect(),
        triangles: leaves,
        ..Topology::default()
    };
    let mut source = source("short-stack", NodeFormat::Adreno8, rays);
    source.header.accel = Accel::TwoLevel;
    source.topology = Topology::of_two_levels(tree(2), vec![tree(8)], vec![0, 0]).expect("valid");
    source.header.triangles = source.topology.triangles;
    source
}

#[test]
fn entering_an_instance_is_the_shaders_work_and_a_test_of_its_box() {
    // The root of the BLAS is node 2, as trees begin at even numbers.
    let steps = vec![
        (Op::Node, 0),
        (Op::Push, 0),
        (Op::Instance, 1),
        (Op::Node, 2),
        (Op::Primitive, 7),
        (Op::Pop, 0),
    ];
    let source = two_levels(&vec![(steps, NO_HIT); 64]);
    for name in GPUS_WITH_ONE {
        let config = config(gpu(name, true));
        let replayed = run(&source, &config);
        let issue = replayed.counters.pass(Pass::Primary).issue;
        let around = config.costs.of_shader(&source.header, &config.gpu).expect("the table has them");
        let levels = config.costs.two_level(&source.header, &config.gpu).expect("it has these too");
        let levels = levels.expect("two levels");
        let instance = levels.instance;
        let shared = &config.costs.shared;
        // Four trips: to node 0, and from there into the instance; to its root; the triangle; what is popped.
        let per_ray = shared.camera_ray.alu
            + around.start.alu
            + 2 * around.node.alu
            + around.push.alu
            + instance.alu
            + around.primitive.alu
            + around.pop.alu
            + 4 * shared.trip.alu;
        assert_eq!(issue.alu_active, 64 * u64::from(per_ray), "{name}");
        assert_eq!((issue.instances, issue.tlas_steps), (64, 64));
        // Both boxes of the TLAS, then that of the instance in its leaf; eight in the BLAS.
        assert_eq!((issue.unit_tlas_boxes, issue.unit_box_tests), (64 * 3, 64 * (2 + 1 + 8)));
        assert_eq!((issue.box_nodes, issue.unit_triangle_places), (64 * 3, 64));
        // A node of 64 bytes, two instances of 192, each from a multiple of 256 bytes, and a node.
        assert_eq!(replayed.structure_bytes, 256 + 512 + 64);
        let one_level = tracer::TraceHeader { accel: Accel::WideBvh, ..source.header.clone() };
        let [one, two] = [&one_level, &source.header]
            .map(|header| registers(header, &config).expect("the table has them"));
        assert_eq!(two, one + levels.registers, "{name}");
    }
}

#[test]
fn a_shader_without_the_instruction_pays_for_instances_as_with_a_full_stack() {
    let steps = vec![(Op::Node, 0), (Op::Instance, 0), (Op::Node, 2), (Op::Primitive, 3)];
    let source = two_levels(&vec![(steps, NO_HIT); 64]);
    let config = config(gpu("adreno-750", false));
    let issue = run(&source, &config).counters.pass(Pass::Primary).issue;
    let mut full = source.header.clone();
    full.traversal = "stack".to_owned();
    let costs =
        |header| config.costs.two_level(header, &config.gpu).expect("known").expect("two levels").instance;
    assert_eq!((costs(&source.header).alu, costs(&source.header).efu), (costs(&full).alu, costs(&full).efu));
    assert!(costs(&full).efu > 0, "reciprocals, which the instruction makes itself");
    assert_eq!((issue.instances, issue.box_nodes, issue.unit_box_tests), (64, 0, 0));
}

#[test]
fn the_instruction_knows_one_format_and_gives_no_distances() {
    let rays = vec![(steps(), NO_HIT); 64];
    for (traversal, format, has_part) in [
        ("short-stack", NodeFormat::Adreno8, true),
        ("short-stack", NodeFormat::Compressed8, false),
        ("stack", NodeFormat::Adreno8, false),
    ] {
        let mut source = source(traversal, format, &rays);
        source.header.stack_entries = if traversal == "stack" { 8 } else { 0 };
        let [with, without] =
            [true, false].map(|with_unit| run(&source, &config(gpu("adreno-750", with_unit))).counters);
        assert_eq!(with != without, has_part, "{traversal} {format:?}");
        assert_eq!(with.pass(Pass::Primary).issue.box_nodes > 0, has_part);
    }
    let binary = Recorded::list(Accel::Bvh, "stack", 64, &[(vec![(Op::Node, 0)], NO_HIT)]);
    let [with, without] =
        [true, false].map(|with_unit| run(&binary, &config(gpu("adreno-750", with_unit))).counters);
    assert_eq!(with, without);
}

#[test]
fn the_unit_spares_the_shader_most_of_its_work() {
    let source = source("short-stack", NodeFormat::Adreno8, &vec![(steps(), NO_HIT); 64]);
    let [with, without] = [true, false].map(|with_unit| {
        run(&source, &config(gpu("adreno-750", with_unit))).counters.pass(Pass::Primary).issue
    });
    assert!(with.alu_active * 3 < without.alu_active, "{} and {}", with.alu_active, without.alu_active);
    assert_eq!((with.node_fetches, with.primitive_tests), (without.node_fetches, without.primitive_tests));
}

#[test]
fn a_faster_unit_makes_no_frame_slower() {
    let ray = |lane: u32| (vec![(Op::Node, 0), (Op::Node, 1 + lane % 8), (Op::Primitive, lane % 64)], NO_HIT);
    let source = source("short-stack", NodeFormat::Adreno8, &(0..64 * 200).map(ray).collect::<Vec<_>>());
    let times = [0.001, 0.1, 1.0, 8.0, 1000.0].map(|rate| {
        let mut gpu = gpu("adreno-830", true);
        let unit = gpu.ray_unit.as_mut().expect("it has one");
        (unit.boxes_per_clock, unit.triangles_per_clock) = (rate, rate);
        let config = config(gpu);
        let estimate =
            estimate(&run(&source, &config), &source.header, &source.topology, &config).expect("solvable");
        estimate.frame.get("frame_time_ms").and_then(Value::number).expect("a number")
    });
    assert!(times.windows(2).all(|pair| pair[1] <= pair[0] * (1.0 + 1e-9)), "{times:?}");
    // 12 cores, two nodes of eight boxes for each ray.
    let slowest = 64.0 * 200.0 * 2.0 * 8.0 / 0.001 / 12.0 / 1100e3;
    assert!((times[0] / slowest - 1.0).abs() < 0.05, "{times:?}, {slowest} expected");
}

#[test]
fn tables_without_the_instruction_say_what_to_add() {
    let table = include_str!("../../configs/costs.toml");
    let (before, rest) = table.split_once("[ray-intersection]").expect("it has one");
    let after = rest.split_once("\n[").expect("another follows").1;
    let old = ShaderCosts::parse(&format!("{before}\n[{after}"), "old.toml").expect("older tables are sound");
    let source = source("short-stack", NodeFormat::Adreno8, &[(steps(), NO_HIT)]);
    let config = ReplayConfig { costs: old, ..config(gpu("adreno-750", true)) };
    let refused = replay(&source, &config, Maps::Dropped, &|_, _| {}).expect_err("it has none").to_string();
    assert!(refused.contains("[ray-intersection]"), "{refused}");
}

#[test]
fn tables_without_instances_around_the_instruction_say_what_to_add() {
    let table = include_str!("../../configs/costs.toml");
    let (before, rest) = table.split_once("[ray-intersection-two-level]").expect("it has one");
    let after = rest.split_once("\n[").expect("another follows").1;
    let old = ShaderCosts::parse(&format!("{before}\n[{after}"), "old.toml").expect("older tables are sound");
    let source = two_levels(&[(vec![(Op::Node, 0)], NO_HIT)]);
    let with = |with_unit| ReplayConfig { costs: old.clone(), ..config(gpu("adreno-750", with_unit)) };
    let refused =
        replay(&source, &with(true), Maps::Dropped, &|_, _| {}).expect_err("it has none").to_string();
    assert!(refused.contains("[ray-intersection-two-level]"), "{refused}");
    replay(&source, &with(false), Maps::Dropped, &|_, _| {}).expect("shaders need none");
}

#[test]
fn an_instruction_is_not_simulated_event_by_event() {
    let source = source("short-stack", NodeFormat::Adreno8, &[(steps(), NO_HIT)]);
    let timed = ReplayConfig { fidelity: Fidelity::Timed, ..config(gpu("adreno-750", true)) };
    let refused = replay(&source, &timed, Maps::Dropped, &|_, _| {}).expect_err("it is not").to_string();
    assert!(refused.contains("--ray-unit none"), "{refused}");
}
