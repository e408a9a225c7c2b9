//! From a scene's name to a tracer of its frame.

use crate::machine::Machine;
use crate::meter::timed;
use crate::progress::Progress;
use crate::settings::FrameSettings;
use anyhow::bail;
use scenes::{Light, Scene, Triangle};
use tracer::{
    AccelerationStructure, FrameTracer, Omission, Ray, Rays, SceneIdentity, SceneRemarks, TriangleTest, View,
};

/// What a report says of hits that are not those of the default test.
const WATERTIGHT_NOTE: &str = "hits are those of the watertight triangle test of Woop, Benthin & Wald 2013; no shader of it was compiled, \
                               so the report has the costs of Moeller-Trumbore";

/// A scene whose primary rays can be traced.
pub(crate) struct LoadedScene {
    pub(crate) scene: Scene,
    pub(crate) triangles: Vec<Triangle>,
    /// Seconds for loading it.
    pub(crate) load_s: f64,
}

impl LoadedScene {
    pub(crate) fn load(scene: &str) -> anyhow::Result<Self> {
        let _progress = Progress::spinner("loading the scene");
        let (loaded, load_s) = timed(|| {
            scenes::load(scene).map(|scene| {
                let triangles = scene.triangles();
                (scene, triangles)
            })
        });
        let (scene, triangles) = loaded?;
        if !scene.rays.primary {
            bail!(
                "{}: rays.primary is false, and every other ray starts at a primary hit; set it to true",
                scene.name
            );
        }
        Ok(Self { scene, triangles, load_s })
    }
}

/// A scene with a structure built over it.
pub(crate) struct Frame<'a> {
    scene: &'a LoadedScene,
    pub(crate) structure: AccelerationStructure,
    settings: FrameSettings,
    /// Seconds for building the structure.
    pub(crate) build_s: f64,
}

impl<'a> Frame<'a> {
    /// Builds the structure.
    pub(crate) fn build(scene: &'a LoadedScene, settings: &FrameSettings) -> anyhow::Result<Self> {
        let _progress = Progress::spinner("building the structure");
        let (structure, build_s) =
            timed(|| AccelerationStructure::build(&scene.triangles, settings.traversal, &settings.build));
        Ok(Self { scene, structure: structure?, settings: *settings, build_s })
    }

    /// A tracer of what `machines` replay: the camera's rays, the shadow rays that the scene asks for, and what a rasteriser draws where
    /// one of them rasterises.
    pub(crate) fn tracer_for(&self, machines: &[Machine]) -> FrameTracer<'_> {
        let tracer = self.tracer(None);
        let rasterises = machines.iter().any(|machine| machine.config.technique.raster.is_some());
        if rasterises { tracer.with_raster() } else { tracer }
    }

    /// A tracer of the camera's rays and of the shadow rays that the scene asks for; of `rays` alone if they are given.
    pub(crate) fn tracer(&self, rays: Option<Vec<Ray>>) -> FrameTracer<'_> {
        let (rays, lights) = match rays {
            Some(rays) => (Rays::List(rays), Vec::new()),
            None => {
                let size = self.settings.size;
                (Rays::View { view: self.view(), width: size.width, height: size.height }, self.lights())
            }
        };
        let LoadedScene { scene, triangles, .. } = self.scene;
        let identity = SceneIdentity { name: scene.name.clone(), hash: scene.hash() };
        FrameTracer::new(&self.structure, &self.settings.build, triangles, identity, rays, lights)
            .with_remarks(self.remarks())
    }

    /// The camera, for this size of image.
    pub(crate) fn view(&self) -> View {
        let size = self.settings.size;
        View::new(&self.scene.scene.camera, size.width, size.height)
    }

    /// The scene's triangles, in file order.
    pub(crate) fn triangles(&self) -> &[Triangle] {
        &self.scene.triangles
    }

    /// Where shadow rays go.
    pub(crate) fn lights(&self) -> Vec<scenes::Vec3> {
        let Scene { lights, rays, .. } = &self.scene.scene;
        lights.iter().filter(|_| rays.shadow).map(|Light::Point { position }| *position).collect()
    }

    /// What a report should say of the scene.
    fn remarks(&self) -> SceneRemarks {
        let scene = &self.scene.scene;
        let omission = |entry: scenes::LeftOut| Omission { what: entry.what.to_owned(), why: entry.why };
        let scene_notes = scene.notes.iter().map(|note| note.text());
        let test_notes = match self.settings.build.triangle_test {
            TriangleTest::MoellerTrumbore => None,
            TriangleTest::Watertight => Some(WATERTIGHT_NOTE),
        };
        SceneRemarks {
            left_out: scene.needs().left_out().into_iter().map(omission).collect(),
            notes: scene_notes.chain(test_notes).map(str::to_owned).collect(),
        }
    }
}
