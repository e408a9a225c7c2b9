//! Does a replay of two levels read the records that it should, and lay them out as stated?

mod common;

use common::{Traced, config};

use gpumodel::{Gpu, Maps, NodeRecords, ReplayConfig, Replayed, Value, estimate, replay};
use scenes::{Affine3A, Instance, Triangle, Vec3};
use std::path::Path;
use tracer::wide::NodeFormat;
use tracer::{
    AccelerationStructure, BuildOptions, FrameTracer, Op, Ray, Rays, SceneIdentity, Tile, TileSource,
    TraceFile, Traversal,
};

const RAYS: u64 = 64;

/// One triangle, placed twice far from each other.
struct Pair {
    structure: AccelerationStructure,
    triangles: Vec<Triangle>,
}

impl Pair {
    fn new(format: Option<NodeFormat>) -> Self {
        let mesh = vec![Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] }];
        let moved = |x: f32| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0));
        let instances = [0.0, 10.0].map(|x| Instance { mesh: 0, transform: moved(x) });
        let structure = AccelerationStructure::build_two_level(
            std::slice::from_ref(&mesh),
            &instances,
            Traversal::TwoLevelStack { format },
            &BuildOptions::default(),
        );
        let placed = |at: &Instance| Triangle { v: mesh[0].v.map(|corner| at.transform_point(corner)) };
        Self { structure: structure.expect("valid"), triangles: instances.iter().map(placed).collect() }
    }

    /// Rays that meet the second instance alone.
    fn tracer(&self) -> FrameTracer<'_> {
        let ray = Ray::new(Vec3::new(10.2, 0.2, -5.0), Vec3::Z);
        let identity = SceneIdentity { name: "pair".to_owned(), hash: 0 };
        let rays = Rays::List(vec![ray; RAYS as usize]);
        FrameTracer::new(
            &self.structure,
            &BuildOptions::default(),
            &self.triangles,
            identity,
            rays,
            Vec::new(),
        )
    }

    fn replay(&self, config: &ReplayConfig) -> Replayed {
        replay(&self.tracer(), config, Maps::Dropped, &|_, _| {}).expect("valid")
    }
}

#[test]
fn a_ray_reads_the_records_on_its_way_through_both_levels() {
    // Steps and records in the TLAS: its root and the pair below it, or one wide node. Then the root of the BLAS.
    for (format, (tlas_steps, tlas_records), node_bytes, (instances, instance_read)) in [
        (None, (2, 3), 32, (256, 64)),
        (Some(NodeFormat::Full4), (1, 1), 128, (256, 64)),
        (Some(NodeFormat::Compressed8), (1, 1), 80, (256, 64)),
        // Leaf and descriptor of two instances, 192 bytes each.
        (Some(NodeFormat::Adreno8), (1, 1), 64, (512, 128)),
    ] {
        let pair = Pair::new(format);
        let replayed = pair.replay(&config("fragment"));
        let issue = replayed.counters.total().issue;
        let records = tlas_records + 1;
        assert_eq!((issue.node_steps, issue.node_fetches), ((tlas_steps + 1) * RAYS, records * RAYS));
        assert_eq!((issue.instances, issue.tlas_steps), (RAYS, tlas_steps * RAYS));
        assert_eq!((issue.primitive_tests, issue.shaded), (RAYS, RAYS));
        // The nodes of the TLAS and the instances, each from a multiple of 256 bytes, and one node of the BLAS.
        assert_eq!(replayed.structure_bytes, 256 + instances + node_bytes, "{format:?}");
        // 48 bytes of the triangle for its test, as many to shade it.
        assert_eq!(issue.lane_bytes, RAYS * (records * node_bytes + instance_read + 48 + 48), "{format:?}");

        let costs = config("fragment").costs;
        let node = costs.traversal(pair.tracer().header()).expect("it has costs").node.alu;
        let of_steps = (tlas_steps + 1) * u64::from(node);
        let of_loads = records * node_bytes / 16 * u64::from(costs.shared.address.alu);
        assert_eq!(issue.node_alu, RAYS * (of_steps + of_loads), "{format:?}");
    }
}

/// A trace from before a TLAS could be wide, with BLASes of full-4.
#[test]
fn a_binary_tlas_over_wide_blases_costs_what_each_kind_of_node_costs() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus/trace_file/binary_tlas.rbt");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("binary_tlas.rbt");
    // Its first byte tells the fuzzer that a file follows.
    let bytes = std::fs::read(kept).expect("a file of the repository").split_off(1);
    std::fs::write(&path, bytes).expect("it is written");
    let file = TraceFile::open(&path).expect("it is sound");
    let levels = file.topology().levels.as_ref().expect("two levels");
    let (mut tile, mut roots, mut pairs, mut wide) = (Tile::default(), 0, 0, 0);
    for index in 0..file.header().frame.tiles() {
        file.tile(index, &mut tile).expect("it is sound");
        let steps = tile.ray_sets.iter().flat_map(|set| &set.steps);
        for step in steps.filter(|step| step.op() == Op::Node) {
            match step.id() {
                0 => roots += 1,
                id if id < levels.tlas_nodes => pairs += 1,
                _ => wide += 1,
            }
        }
    }
    assert!(roots > 0 && pairs > 0 && wide > 0);
    let config = config("fragment");
    let replayed = replay(&file, &config, Maps::Dropped, &|_, _| {}).expect("valid");
    let issue = replayed.counters.total().issue;
    assert_eq!((issue.node_steps, issue.tlas_steps), (roots + pairs + wide, roots + pairs));
    assert_eq!(issue.node_fetches, roots + 2 * pairs + wide);
    // Nine instances below 17 nodes, the one node of a tetrahedron's BLAS.
    assert_eq!(replayed.structure_bytes, 768 + (9 * 128_u64).next_multiple_of(256) + 128);
    let costs = &config.costs;
    let [binary, address] = [63, u64::from(costs.shared.address.alu)];
    let wide_node = u64::from(costs.traversal(file.header()).expect("it has costs").node.alu);
    let of_tlas = binary * (roots + pairs) + 2 * address * (roots + 2 * pairs);
    assert_eq!(issue.node_alu, of_tlas + (wide_node + 8 * address) * wide);
}

#[test]
fn both_instances_of_a_mesh_shade_the_same_record() {
    let pair = Pair::new(None);
    let sizes = pair.replay(&config("fragment")).buffers;
    assert_eq!(sizes.primitive, 96, "one triangle is stored");
}

#[test]
fn a_ray_unit_counts_boxes_of_the_tlas_and_instances() {
    let gpu = Gpu::builtin("mali-g1-ultra").expect("built in").expect("sound");
    let config = ReplayConfig { gpu, ..config("fragment") };
    let pair = Pair::new(Some(NodeFormat::Adreno8));
    let replayed = pair.replay(&config);
    let tracer = pair.tracer();
    let estimate = estimate(&replayed, tracer.header(), tracer.topology(), &config).expect("solvable");
    let value = |id: &str| match estimate.frame.get(id) {
        Some(Value::Count(count)) => *count,
        other => panic!("{id}: {other:?}"),
    };
    // Those of the two instances; the one leaf's box at the root of the BLAS.
    assert_eq!(value("ray_unit_tlas_box_tests"), 2 * RAYS);
    assert_eq!(value("ray_unit_box_tests"), 3 * RAYS);
    assert_eq!((value("ray_unit_instances"), value("instances")), (RAYS, RAYS));
}

#[test]
fn boxes_of_children_in_their_parent_are_refused_with_a_remedy() {
    let pair = Pair::new(None);
    let config = ReplayConfig { node_records: NodeRecords::ChildBoxes, ..config("fragment") };
    let refusal =
        replay(&pair.tracer(), &config, Maps::Dropped, &|_, _| {}).map(|_| ()).expect_err("refused");
    assert!(refusal.to_string().contains("use packed or padded node records"), "{refusal}");
}

/// A scene in one mesh that is placed once is the BVH of its triangles, below a TLAS of one node.
#[test]
fn one_instance_costs_its_record_and_its_box_more_than_no_instance() {
    let [flat, levels] = [Traversal::BvhStack, Traversal::TwoLevelStack { format: None }].map(|traversal| {
        let traced = Traced::new("cornell", traversal);
        let replayed =
            replay(&traced.frame(), &config("fragment"), Maps::Dropped, &|_, _| {}).expect("valid");
        (replayed.structure_bytes, replayed.counters.total().issue)
    });
    let (rays, entered) = (levels.1.rays, levels.1.instances);
    assert!(0 < entered && entered <= rays);
    assert_eq!(
        levels.1.node_fetches - flat.1.node_fetches,
        entered,
        "the root of the TLAS beside that of the BLAS"
    );
    assert_eq!(levels.1.primitive_tests, flat.1.primitive_tests);
    assert_eq!(levels.0 - flat.0, 256 + 256, "a node and a record, each rounded up");
}
