//! Small frames of built-in scenes, for replays.

use gpumodel::{
    EnergyTable, Gpu, NodeOrder, NodeRecords, PrimitiveLayout, ReplayConfig, ShaderCosts, Technique,
};
use scenes::{Light, Scene, Vec3};
use tracer::{AccelerationStructure, BuildOptions, FrameTracer, Rays, SceneIdentity, Traversal, View};

/// Not a multiple of a tile, a warp or a quad.
pub(crate) const SIZE: (u32, u32) = (75, 45);

/// The Adreno 540 with the plainest layouts.
pub(crate) fn config(technique: &str) -> ReplayConfig {
    ReplayConfig {
        gpu: Gpu::builtin("adreno-540").expect("built in").expect("sound"),
        costs: ShaderCosts::builtin().expect("sound"),
        energy: EnergyTable::builtin().expect("sound"),
        technique: Technique::builtin(technique).expect("built in").expect("sound"),
        primitive_layout: PrimitiveLayout::Padded,
        primitive_order: None,
        node_records: NodeRecords::Packed,
        node_order: NodeOrder::DepthFirst,
        fidelity: gpumodel::Fidelity::Replay,
        keeps_misses: false,
    }
}

/// A built-in scene with a structure over it.
pub(crate) struct Traced {
    pub(crate) scene: Scene,
    pub(crate) lights: Vec<Vec3>,
    pub(crate) structure: AccelerationStructure,
    pub(crate) triangles: Vec<scenes::Triangle>,
}

impl Traced {
    pub(crate) fn new(scene: &str, traversal: Traversal) -> Self {
        let scene = scenes::load(scene).expect("built in");
        let lights = scene.lights.iter().map(|Light::Point { position, .. }| *position).collect();
        let triangles = scene.triangles();
        let structure =
            AccelerationStructure::build(&triangles, traversal, &BuildOptions::default()).expect("valid");
        Self { scene, lights, structure, triangles }
    }

    pub(crate) fn view(&self) -> View {
        View::new(&self.scene.camera, SIZE.0, SIZE.1)
    }

    /// A tracer of the camera's image.
    pub(crate) fn frame(&self) -> FrameTracer<'_> {
        self.tracer(Rays::View { view: self.view(), width: SIZE.0, height: SIZE.1 }, self.lights.clone())
    }

    pub(crate) fn tracer(&self, rays: Rays, lights: Vec<Vec3>) -> FrameTracer<'_> {
        let identity = SceneIdentity { name: self.scene.name.clone(), hash: 0 };
        let options = BuildOptions::default();
        FrameTracer::new(&self.structure, &options, &self.triangles, identity, rays, lights)
    }
}
