//! Do pairs of triangles take one record, one fetch and two tests?

use crate::config::Gpu;
use crate::counters::{IssueCounters, Pass};
use crate::layout::{PrimitiveLayout, PrimitiveOrder};
use crate::mock::{MockRay, Recorded, config};
use crate::replay::{Maps, ReplayConfig, Replayed, replay};
use tracer::wide::NodeFormat;
use tracer::{Accel, NO_HIT, Op, Topology, TopologyNode};

const RAYS: u64 = 64;

/// A node with a leaf of three triangles, the first two in a pair.
fn source(format: NodeFormat, rays: &[MockRay]) -> Recorded {
    let mut source = Recorded::list(Accel::WideBvh, "stack", 4, rays);
    source.topology = Topology {
        nodes: vec![TopologyNode::Wide { first: 1, count: 0, leaves: 2 }],
        references: vec![2, 0, 1, 3],
        triangles: 4,
        seconds: if format.has_pairs() { vec![1] } else { Vec::new() },
        ..Topology::default()
    };
    source.header.node_format = Some(format);
    source.header.stack_entries = 8;
    source
}

fn all_at(steps: &[(Op, u32)]) -> Vec<MockRay> {
    vec![(steps.to_vec(), NO_HIT); RAYS as usize]
}

fn run(source: &Recorded, config: &ReplayConfig) -> Replayed {
    replay(source, config, Maps::Dropped, &|_, _| {}).expect("the mock is valid")
}

fn issue(source: &Recorded, config: &ReplayConfig) -> IssueCounters {
    run(source, config).counters.pass(Pass::Primary).issue
}

fn on(gpu: &str) -> ReplayConfig {
    config(Gpu::builtin(gpu).expect("it is built in").expect("it is valid"))
}

#[test]
fn the_second_of_a_pair_is_tested_and_not_fetched() {
    let leaf = [(Op::Node, 0), (Op::Primitive, 0), (Op::Primitive, 1), (Op::Primitive, 2)];
    let config = on("adreno-540");
    let alone = issue(&source(NodeFormat::Compressed8, &all_at(&leaf)), &config);
    let paired = issue(&source(NodeFormat::Compressed8Pairs, &all_at(&leaf)), &config);
    assert_eq!((alone.primitive_tests, paired.primitive_tests), (3 * RAYS, 3 * RAYS));
    assert_eq!(alone.node_fetches, paired.node_fetches);
    // Records of 48 bytes, and of 64.
    assert_eq!(alone.lane_bytes - paired.lane_bytes, RAYS * (3 * 48 - 2 * 64));
    assert_eq!(alone.turns - paired.turns, RAYS / 32, "one for each warp");
    // Nine loads of 16 bytes, and eight.
    let address = u64::from(config.costs.shared.address.alu);
    assert_eq!(alone.alu_active - paired.alu_active, RAYS * address);
    assert_eq!(alone.primitive_alu - paired.primitive_alu, RAYS * address);
}

#[test]
fn lanes_at_a_first_triangle_fetch_while_others_have_theirs() {
    // Even lanes test the pair, odd ones begin at its second triangle: they are told to read nothing, as its first is not theirs to ask for.
    let even = (vec![(Op::Node, 0), (Op::Primitive, 2)], NO_HIT);
    let odd = (vec![(Op::Node, 0), (Op::Primitive, 1)], NO_HIT);
    let rays: Vec<MockRay> =
        (0..RAYS).map(|lane| if lane % 2 == 0 { even.clone() } else { odd.clone() }).collect();
    let config = on("adreno-540");
    let alone = issue(&source(NodeFormat::Compressed8, &rays), &config);
    let paired = issue(&source(NodeFormat::Compressed8Pairs, &rays), &config);
    assert_eq!(alone.turns, paired.turns);
    assert_eq!(alone.lane_bytes - paired.lane_bytes, RAYS * 48 - RAYS / 2 * 64);
}

#[test]
fn a_unit_tests_both_triangles_of_a_pair_and_reads_its_line_once() {
    let leaf = [(Op::Node, 0), (Op::Primitive, 0), (Op::Primitive, 1)];
    for gpu in ["mali-g715", "mali-g1-ultra"] {
        let config = on(gpu);
        let alone = issue(&source(NodeFormat::Compressed8, &all_at(&leaf)), &config);
        let paired = issue(&source(NodeFormat::Compressed8Pairs, &all_at(&leaf)), &config);
        assert_eq!(alone.unit_triangle_places, paired.unit_triangle_places, "{gpu}");
        assert_eq!(alone.unit_triangle_places, 2 * RAYS);
        assert!(paired.line_accesses < alone.line_accesses, "{gpu}");
        assert_eq!(alone.alu_active, paired.alu_active, "the unit walks");
    }
}

#[test]
fn buffers_hold_a_record_for_each_pair_and_normals_apart() {
    let rays = all_at(&[(Op::Node, 0), (Op::Primitive, 3)]);
    for layout in PrimitiveLayout::ALL {
        let config = ReplayConfig { primitive_layout: layout, ..on("adreno-540") };
        let mut source = source(NodeFormat::Compressed8Pairs, &rays);
        let sizes = run(&source, &config).buffers;
        assert_eq!((sizes.primitive, sizes.normal), (3 * 64, 4 * 48), "{layout:?}");
        source.header.normals = false;
        let sizes = run(&source, &config).buffers;
        assert_eq!((sizes.primitive, sizes.normal), (3 * 64, 0), "{layout:?}");
    }
}

#[test]
fn an_index_list_is_refused_with_a_remedy() {
    let source = source(NodeFormat::Compressed8Pairs, &all_at(&[(Op::Node, 0)]));
    let config = ReplayConfig { primitive_order: Some(PrimitiveOrder::Indexed), ..on("adreno-540") };
    let refused = replay(&source, &config, Maps::Dropped, &|_, _| {}).map(|_| ()).expect_err("refused");
    assert!(refused.to_string().contains("use triangles in the order of the leaves"), "{refused}");
}
