//! Do ray units count and cost what their description says?

use crate::config::{Gpu, RayScheduling};
use crate::counters::{FrameCounters, IssueCounters, Pass, Value};
use crate::estimate::estimate;
use crate::mock::{MockRay, Recorded, config};
use crate::replay::{Fidelity, Maps, ReplayConfig, Replayed, replay};
use proptest::prelude::*;
use tracer::wide::NodeFormat;
use tracer::{Accel, NO_HIT, Op, Topology, TopologyNode};

/// A root with `children` inner nodes, each with `leaves` leaves, none of them below another.
fn tree(children: u32, leaves: u32) -> Topology {
    let root = TopologyNode::Wide { first: 1, count: children, leaves: 0 };
    let below = TopologyNode::Wide { first: children + 1, count: 0, leaves };
    let nodes = std::iter::once(root).chain((0..children).map(|_| below)).collect();
    let references = children * leaves;
    Topology { nodes, references: (0..references).collect(), triangles: references, ..Topology::default() }
}

fn source(format: NodeFormat, rays: &[MockRay]) -> Recorded {
    let mut source = Recorded::list(Accel::WideBvh, "stack", 64, rays);
    source.topology = tree(8, 8);
    source.header.node_format = Some(format);
    source.header.stack_entries = 16;
    source
}

/// The Immortalis-G715 with its unit as described, or another way of scheduling.
fn machine(scheduling: Option<RayScheduling>) -> Gpu {
    let mut gpu = Gpu::builtin("mali-g715").expect("it is built in").expect("it is valid");
    match (scheduling, &mut gpu.ray_unit) {
        (Some(scheduling), Some(unit)) => unit.scheduling = scheduling,
        _ => gpu.ray_unit = None,
    }
    gpu
}

fn run(source: &Recorded, config: &ReplayConfig) -> Replayed {
    replay(source, config, Maps::Dropped, &|_, _| {}).expect("the mock is valid")
}

fn issue(source: &Recorded, scheduling: Option<RayScheduling>) -> IssueCounters {
    let counters: FrameCounters = run(source, &config(machine(scheduling))).counters;
    counters.pass(Pass::Primary).issue
}

/// A ray that tests the root and child `child`, then `triangles` of its triangles.
fn ray(child: u32, triangles: u32) -> MockRay {
    let mut steps = vec![(Op::Node, 0), (Op::Node, 1 + child)];
    steps.extend((0..triangles).map(|triangle| (Op::Primitive, child * 8 + triangle)));
    (steps, NO_HIT)
}

fn bins(issue: &IssueCounters) -> [u64; 4] {
    [issue.box_nodes_quarter, issue.box_nodes_half, issue.box_nodes_three_quarters, issue.box_nodes_full]
}

#[test]
fn rays_that_go_together_share_a_test_of_a_warp_and_not_of_single_rays() {
    let rays = vec![ray(3, 2); 16];
    let source = source(NodeFormat::Adreno8, &rays);
    let warp = issue(&source, Some(RayScheduling::Warp));
    assert_eq!((warp.box_nodes, bins(&warp)), (2, [0, 0, 0, 2]));
    assert_eq!((warp.unit_box_tests, warp.unit_box_places), (16 * 16, 16 * 16));
    assert_eq!((warp.triangle_nodes, warp.unit_triangle_places), (2, 32));
    let ray = issue(&source, Some(RayScheduling::Ray));
    assert_eq!((ray.box_nodes, bins(&ray)), (32, [32, 0, 0, 0]));
    assert_eq!((ray.unit_box_tests, ray.unit_box_places), (16 * 16, 16 * 16));
    assert_eq!((ray.triangle_nodes, ray.unit_triangle_places), (32, 32));
}

#[test]
fn places_of_a_warps_test_stay_empty_where_its_rays_part() {
    // Two rays at each of the eight children.
    let rays: Vec<MockRay> = (0..16).map(|lane| ray(lane / 2, 0)).collect();
    let source = source(NodeFormat::Adreno8, &rays);
    let warp = issue(&source, Some(RayScheduling::Warp));
    assert_eq!((warp.box_nodes, bins(&warp)), (1 + 8, [8, 0, 0, 1]));
    assert_eq!(warp.unit_box_tests, 16 * 8 + 16 * 8);
    assert_eq!(warp.unit_box_places, 16 * 8 + 8 * 4 * 8);
    let ray = issue(&source, Some(RayScheduling::Ray));
    assert_eq!(ray.unit_box_places, ray.unit_box_tests);
    assert_eq!(ray.unit_box_tests, warp.unit_box_tests);
}

#[test]
fn shaders_take_no_step_that_a_unit_takes_and_no_stack_is_in_memory() {
    let steps =
        vec![(Op::Node, 0), (Op::Push, 0), (Op::Node, 1), (Op::Primitive, 0), (Op::Pop, 0), (Op::Node, 2)];
    let source = source(NodeFormat::Compressed8, &vec![(steps, NO_HIT); 32]);
    for scheduling in [RayScheduling::Warp, RayScheduling::Ray] {
        let config = config(machine(Some(scheduling)));
        let replayed = run(&source, &config);
        let pass = replayed.counters.pass(Pass::Primary);
        let costs = &config.costs;
        let per_ray = costs.shared.camera_ray.alu + costs.ray_query.start.alu;
        assert_eq!(pass.issue.alu_active, 32 * u64::from(per_ray));
        assert_eq!(pass.traffic.stack, Default::default());
        assert_eq!(replayed.buffers.stack, 0);
        assert_eq!((pass.issue.pushes, pass.issue.pops), (32, 32));
    }
    let by_shader = run(&source, &config(machine(None)));
    let pass = by_shader.counters.pass(Pass::Primary);
    assert!(pass.traffic.stack.levels[0].accesses > 0 && by_shader.buffers.stack > 0);
    assert_eq!((pass.issue.box_nodes, pass.issue.unit_box_tests), (0, 0));
}

#[test]
fn lanes_pay_for_what_they_load_themselves_and_not_for_lines_of_their_unit() {
    // No ray hits, so nothing is shaded: only the walk loads.
    let source = source(NodeFormat::Adreno8, &vec![ray(3, 2); 16]);
    let loads = |scheduling| {
        let config = config(machine(scheduling));
        let replayed = run(&source, &config);
        let issue = replayed.counters.pass(Pass::Primary).issue;
        let energy = estimate(&replayed, &source.header, &source.topology, &config).expect("solvable").energy;
        let energy = energy.expect("the GPU has a process");
        let joules =
            |name: &str| energy.causes.iter().find(|cause| cause.cause == name).map(|cause| cause.joules);
        assert!(issue.line_accesses > 0);
        (issue.lane_bytes, joules("loads and stores").is_some(), joules("ray unit: boxes").is_some())
    };
    assert_eq!(loads(Some(RayScheduling::Warp)), (0, false, true));
    assert_eq!(loads(Some(RayScheduling::Ray)), (0, false, true));
    let (bytes, paid, unit) = loads(None);
    assert!(bytes > 0 && paid && !unit);
}

#[test]
fn a_unit_reads_each_line_of_a_record_once() {
    for (format, lines) in [(NodeFormat::Adreno8, 1), (NodeFormat::Full4, 2), (NodeFormat::Full8, 4)] {
        let source = source(format, &vec![(vec![(Op::Node, 5)], NO_HIT); 16]);
        assert_eq!(issue(&source, Some(RayScheduling::Warp)).line_accesses, lines, "{format:?}");
        // A load of 16 bytes each.
        assert_eq!(issue(&source, None).line_accesses, 4 * lines, "{format:?}");
    }
}

/// A frame in which every record of the tree is one of two lines, on the G1-Ultra with a unit whose cache is so wide, in bytes per clock.
fn behind_its_own_port(bytes_per_clock: f64) -> (IssueCounters, [f64; 2]) {
    let rays: Vec<MockRay> = (0..24 * 12 * 16).map(|lane| ray(lane % 8, 0)).collect();
    let source = source(NodeFormat::Full4, &rays);
    let mut gpu = Gpu::builtin("mali-g1-ultra").expect("it is built in").expect("it is valid");
    let own = gpu.ray_unit.as_ref().expect("it has one").path[0];
    gpu.caches[own].bytes_per_clock = bytes_per_clock;
    let config = config(gpu);
    let replayed = run(&source, &config);
    let estimate = estimate(&replayed, &source.header, &source.topology, &config).expect("solvable");
    let issue = replayed.counters.pass(Pass::Primary).issue;
    let number = |id: &str| estimate.frame.get(id).and_then(Value::number).expect("a number");
    (issue, [number("ray_unit_port_cycles"), number("frame_time_ms")])
}

#[test]
fn a_unit_with_a_cache_of_its_own_has_a_port_of_that_width_and_leaves_the_load_store_port_alone() {
    // 24 warps on each of 12 cores read the root, and then the eight children that their rays went to.
    let lines = 24 * 12 * (2 + 8 * 2);
    for bytes_per_clock in [0.001, 32.0, 64.0, 128.0] {
        let (issue, [cycles, _]) = behind_its_own_port(bytes_per_clock);
        assert_eq!((issue.unit_port_lines, issue.load_store_cycles), (lines, 0), "{bytes_per_clock}");
        assert_eq!(cycles, lines as f64 * 64.0 / bytes_per_clock);
    }
    // A narrow one decides.
    let (_, [cycles, milliseconds]) = behind_its_own_port(0.001);
    let expected = cycles / 12.0 / 1e6;
    assert!((milliseconds / expected - 1.0).abs() < 0.01, "{milliseconds} ms, {expected} expected");
}

#[test]
fn a_unit_behind_the_load_store_cache_shares_its_port() {
    let source = source(NodeFormat::Full4, &vec![ray(3, 0); 16]);
    let issue = issue(&source, Some(RayScheduling::Warp));
    assert_eq!((issue.unit_port_lines, issue.load_store_cycles), (0, 4));
}

#[test]
fn units_leave_other_structures_to_shaders() {
    let rays = vec![(vec![(Op::Node, 0), (Op::Primitive, 0)], NO_HIT); 32];
    let source = Recorded::list(Accel::Bvh, "stack", 64, &rays);
    let with_unit = config(machine(Some(RayScheduling::Warp)));
    let without = config(machine(None));
    assert_eq!(run(&source, &with_unit).counters, run(&source, &without).counters);
}

#[test]
fn a_unit_is_not_simulated_event_by_event() {
    let source = source(NodeFormat::Adreno8, &[ray(0, 1)]);
    let timed = ReplayConfig { fidelity: Fidelity::Timed, ..config(machine(Some(RayScheduling::Ray))) };
    let refused = replay(&source, &timed, Maps::Dropped, &|_, _| {}).expect_err("it is not").to_string();
    assert!(refused.contains("--ray-unit none"), "{refused}");
}

/// Seconds of a frame, and the utilization of its unit.
fn time(source: &Recorded, boxes_per_clock: f64) -> (f64, f64) {
    let mut gpu = machine(Some(RayScheduling::Warp));
    gpu.ray_unit.as_mut().expect("it has one").boxes_per_clock = boxes_per_clock;
    let config = config(gpu);
    let estimate =
        estimate(&run(source, &config), &source.header, &source.topology, &config).expect("solvable");
    let number = |id: &str| estimate.frame.get(id).and_then(Value::number).expect("a number");
    (number("frame_time_ms"), number("ray_unit_utilization"))
}

#[test]
fn a_slow_unit_decides_the_time() {
    let rays: Vec<MockRay> = (0..24 * 11 * 16).map(|lane| ray(lane % 8, 0)).collect();
    let source = source(NodeFormat::Adreno8, &rays);
    let (slow, busy) = time(&source, 0.001);
    // 24 warps for each core, each with 16 rays at the root and two at each child, in tests of four places and eight boxes.
    let cycles = 24.0 * (16.0 + 8.0 * 4.0) * 8.0 / 0.001;
    assert!((slow / (cycles / 888e3) - 1.0).abs() < 1e-3, "{slow} ms, {} expected", cycles / 888e3);
    assert!((busy - 1.0).abs() < 1e-3, "{busy}");
    let times = [0.001, 0.01, 0.1, 1.0, 10.0, 1000.0].map(|rate| time(&source, rate).0);
    assert!(times.windows(2).all(|pair| pair[1] <= pair[0] * (1.0 + 1e-9)), "{times:?}");
}

proptest! {
    #[test]
    fn tests_are_those_of_the_rays_whatever_the_scheduling(children in prop::collection::vec(0_u32..8, 1..100)) {
        let rays: Vec<MockRay> = children.iter().map(|&child| ray(child, child % 3)).collect();
        let source = source(NodeFormat::Compressed8, &rays);
        let [warp, ray] = [RayScheduling::Warp, RayScheduling::Ray].map(|scheduling| issue(&source, Some(scheduling)));
        prop_assert_eq!(warp.unit_box_tests, 16 * children.len() as u64);
        prop_assert_eq!(ray.unit_box_tests, warp.unit_box_tests);
        prop_assert_eq!(ray.unit_box_places, ray.unit_box_tests);
        prop_assert!(warp.unit_box_places >= warp.unit_box_tests);
        prop_assert!(warp.unit_box_places < 4 * warp.unit_box_tests + 1);
        prop_assert!(warp.box_nodes <= ray.box_nodes);
        prop_assert_eq!(bins(&warp).iter().sum::<u64>(), warp.box_nodes);
        prop_assert_eq!(warp.primitive_tests, ray.unit_triangle_places);
    }
}
