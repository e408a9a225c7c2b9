//! Scenes with their reflections.

use scenes::{Camera, Triangle};
use tracer::reflections::{GBuffer, March, QueryOrigin, ReflectionSettings};
use tracer::{AccelerationStructure, BuildOptions, ReflectionRays, Traversal, View};

/// A scene seen in a square image.
pub(crate) struct World {
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) camera: Camera,
    pub(crate) structure: AccelerationStructure,
    pub(crate) edge: u32,
}

impl World {
    pub(crate) fn new(triangles: Vec<Triangle>, camera: Camera, edge: u32) -> Self {
        let structure =
            AccelerationStructure::build(&triangles, Traversal::BvhStack, &BuildOptions::default())
                .expect("it builds");
        Self { triangles, camera, structure, edge }
    }

    pub(crate) fn builtin(name: &str, edge: u32) -> Self {
        let scene = scenes::builtin(name).expect("a built-in scene");
        Self::new(scene.triangles(), scene.camera, edge)
    }

    pub(crate) fn view(&self) -> View {
        View::new(&self.camera, self.edge, self.edge)
    }

    pub(crate) fn gbuffer(&self) -> GBuffer<'_> {
        GBuffer::trace(&self.structure, &self.triangles, self.view(), self.edge, self.edge)
    }

    pub(crate) fn mirrors(&self) -> Vec<ReflectionRays> {
        vec![ReflectionRays::Mirror; self.triangles.len()]
    }
}

pub(crate) fn settings(surfaces: &[ReflectionRays], march: Option<March>) -> ReflectionSettings<'_> {
    ReflectionSettings { surfaces, seed: 5, march, origin: QueryOrigin::LastFree }
}
