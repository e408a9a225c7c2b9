//! Hand-written traces for tests.

use crate::config::{EnergyTable, Gpu, ShaderCosts, Technique};
use crate::layout::{NodeOrder, NodeRecords, PrimitiveLayout};
use crate::replay::ReplayConfig;
use tracer::{
    Accel, Frame, LoopStructure, NodeFetch, Op, RaySet, RaySetId, Step, TILE_RAYS, Tile, TileSource,
    Topology, TopologyNode, TraceHeader,
};

/// A trace in memory.
#[derive(Clone)]
pub(crate) struct Recorded {
    pub(crate) header: TraceHeader,
    pub(crate) topology: Topology,
    pub(crate) tiles: Vec<Tile>,
}

impl TileSource for Recorded {
    fn header(&self) -> &TraceHeader {
        &self.header
    }

    fn topology(&self) -> &Topology {
        &self.topology
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), tracer::Error> {
        tile.clone_from(&self.tiles[index as usize]);
        Ok(())
    }

    fn stalls(&self) -> u64 {
        0
    }
}

/// A ray's steps and the triangle that it hits.
pub(crate) type MockRay = (Vec<(Op, u32)>, u32);

impl Recorded {
    /// A list of primary rays through a complete binary tree of `leaves` leaves with one reference each.
    pub(crate) fn list(accel: Accel, traversal: &str, leaves: u32, rays: &[MockRay]) -> Self {
        let header = TraceHeader {
            generator: "mock".to_owned(),
            scene: "mock".to_owned(),
            scene_hash: "0".repeat(16),
            triangles: leaves,
            frame: Frame::List { rays: rays.len() as u32 },
            ray_sets: vec![RaySetId::PRIMARY],
            shadow_query: tracer::Query::Any,
            raster: false,
            normals: true,
            reflections: None,
            forced: Vec::new(),
            alpha: None,
            accel,
            traversal: traversal.to_owned(),
            node_format: None,
            node_fetch: NodeFetch::Single,
            loop_structure: LoopStructure::WhileWhile,
            stack_entries: 0,
            short_stack: 0,
            trail_bits: None,
            sah_costs: [3.0, 1.5],
            depth: leaves.ilog2(),
            remarks: tracer::SceneRemarks::default(),
        };
        let tiles = rays.chunks(TILE_RAYS as usize).map(|rays| Tile {
            ray_sets: vec![ray_set(rays)],
            draws: Vec::new(),
            reflections: Vec::new(),
        });
        Self { header, topology: complete_tree(leaves), tiles: tiles.collect() }
    }
}

pub(crate) fn ray_set(rays: &[MockRay]) -> RaySet {
    let mut set = RaySet::default();
    for (steps, hit) in rays {
        set.steps.extend(steps.iter().map(|&(op, id)| Step::new(op, id)));
        set.end_ray(*hit).expect("a mock tile is small");
    }
    set
}

/// Nodes as a heap: the children of node `n` are `2n + 1` and `2n + 2`; leaf `l` holds reference `l` to triangle `l`.
pub(crate) fn complete_tree(leaves: u32) -> Topology {
    assert!(leaves.is_power_of_two());
    let inner = (0..leaves - 1).map(|node| TopologyNode::Inner { left: 2 * node + 1 });
    let leaf = (0..leaves).map(|first| TopologyNode::Leaf { first, count: 1 });
    Topology {
        nodes: inner.chain(leaf).collect(),
        references: (0..leaves).collect(),
        triangles: leaves,
        ..Topology::default()
    }
}

/// The built-in Adreno 540 with parts of its text replaced.
pub(crate) fn gpu(replacements: &[(&str, &str)]) -> Gpu {
    let mut text = crate::BuiltinGpu::named("adreno-540").expect("it is built in").toml.to_owned();
    for (from, to) in replacements {
        assert!(text.contains(from), "the description has '{from}'");
        text = text.replace(from, to);
    }
    Gpu::parse(&text, "mock.toml").expect("the description stays valid")
}

pub(crate) fn config(gpu: Gpu) -> ReplayConfig {
    ReplayConfig {
        gpu,
        costs: ShaderCosts::builtin().expect("the built-in costs are valid"),
        energy: EnergyTable::builtin().expect("the built-in table is valid"),
        technique: technique("fragment"),
        primitive_layout: PrimitiveLayout::Padded,
        primitive_order: None,
        node_records: NodeRecords::Packed,
        node_order: NodeOrder::AsBuilt,
        fidelity: crate::replay::Fidelity::Replay,
        keeps_misses: false,
    }
}

pub(crate) fn technique(name: &str) -> Technique {
    Technique::builtin(name).expect("it is built in").expect("it is valid")
}
