//! Does a replay of two levels read the records that it should, and lay them out as stated?

mod common;

use common::{Traced, config};

use gpumodel::{Gpu, Maps, NodeRecords, ReplayConfig, Replayed, Value, estimate, replay};
use scenes::{Affine3A, Instance, Triangle, Vec3};
use tracer::wide::NodeFormat;
use tracer::{
    AccelerationStructure, BuildOptions, FrameTracer, Ray, Rays, SceneIdentity, TileSource, Traversal,
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
            format,
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
    for (format, blas_bytes, blas_box_costs_more) in
        [(None, 32, false), (Some(NodeFormat::Full4), 128, true), (Some(NodeFormat::Adreno8), 64, true)]
    {
        let pair = Pair::new(format);
        let replayed = pair.replay(&config("fragment"));
        let issue = replayed.counters.total().issue;
        // The root of the TLAS, the pair below it, the root of the BLAS.
        assert_eq!((issue.node_steps, issue.node_fetches), (3 * RAYS, 4 * RAYS));
        assert_eq!((issue.instances, issue.tlas_steps), (RAYS, 2 * RAYS));
        assert_eq!((issue.primitive_tests, issue.shaded), (RAYS, RAYS));
        // Three nodes of the TLAS and two instances, each from a multiple of 256 bytes, and one node of the BLAS.
        assert_eq!(replayed.structure_bytes, 256 + 2 * 128 + blas_bytes, "{format:?}");
        // 64 bytes of the instance; 48 of the triangle for its test, as many to shade it.
        let loaded = 3 * 32 + blas_bytes + 64 + 48 + 48;
        assert_eq!(issue.lane_bytes, RAYS * loaded, "{format:?}");

        let bvh = config("fragment").costs;
        let wide = bvh.traversal(pair.tracer().header()).expect("it has costs").node.alu;
        let [binary, address] = [63, bvh.shared.address.alu];
        assert_eq!(wide > binary, blas_box_costs_more);
        // Loads of 16 bytes: two for each record of the TLAS.
        let tlas = u64::from(2 * binary + 3 * 2 * address);
        let blas = u64::from(wide) + blas_bytes / 16 * u64::from(address);
        assert_eq!(issue.node_alu, RAYS * (tlas + blas), "{format:?}");
    }
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
    // Its own box at the root, two at the pair below; the one leaf's box at the root of the BLAS.
    assert_eq!(value("ray_unit_tlas_box_tests"), 3 * RAYS);
    assert_eq!(value("ray_unit_box_tests"), 4 * RAYS);
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
