//! From a scene's name to a tracer of its frame.

use crate::meter::timed;
use crate::progress::Progress;
use crate::settings::FrameSettings;
use anyhow::bail;
use scenes::{Light, Scene, Triangle};
use tracer::{AccelerationStructure, FrameTracer, Omission, Ray, Rays, SceneIdentity, SceneRemarks, View};

/// A scene with the structure built over it.
pub(crate) struct Frame {
    scene: Scene,
    triangles: Vec<Triangle>,
    structure: AccelerationStructure,
    settings: FrameSettings,
    /// Seconds for loading the scene.
    pub(crate) load_s: f64,
    /// Seconds for building the structure.
    pub(crate) build_s: f64,
}

impl Frame {
    /// Loads the scene and builds its structure.
    pub(crate) fn build(scene: &str, settings: &FrameSettings) -> anyhow::Result<Self> {
        let progress = Progress::spinner("loading the scene");
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
        drop(progress);
        let _progress = Progress::spinner("building the structure");
        let (structure, build_s) =
            timed(|| AccelerationStructure::build(&triangles, settings.traversal, &settings.build));
        Ok(Self { scene, triangles, structure: structure?, settings: *settings, load_s, build_s })
    }

    /// A tracer of the camera's rays and of the shadow rays that the scene asks for; of `rays` alone if they are given.
    pub(crate) fn tracer(&self, rays: Option<Vec<Ray>>) -> FrameTracer<'_> {
        let size = self.settings.size;
        let (rays, lights) = match rays {
            Some(rays) => (Rays::List(rays), Vec::new()),
            None => {
                let view = View::new(&self.scene.camera, size.width, size.height);
                let lights = self.scene.lights.iter().filter(|_| self.scene.rays.shadow);
                let positions = lights.map(|Light::Point { position }| *position).collect();
                (Rays::View { view, width: size.width, height: size.height }, positions)
            }
        };
        let identity = SceneIdentity { name: self.scene.name.clone(), hash: self.scene.hash() };
        FrameTracer::new(&self.structure, &self.settings.build, &self.triangles, identity, rays, lights)
            .with_remarks(self.remarks())
    }

    /// What a report should say of the scene.
    fn remarks(&self) -> SceneRemarks {
        let omission = |entry: scenes::LeftOut| Omission { what: entry.what.to_owned(), why: entry.why };
        SceneRemarks {
            left_out: self.scene.needs().left_out().into_iter().map(omission).collect(),
            notes: self.scene.notes.iter().map(|note| note.text().to_owned()).collect(),
        }
    }
}
