//! From a scene's name to a tracer of its frame.

use crate::alpha;
use crate::machine::Machine;
use crate::meter::timed;
use crate::progress::Progress;
use crate::ray_sets::with_forced;
use crate::secondary;
use crate::settings::FrameSettings;
use crate::two_level;
use anyhow::bail;
use gpumodel::TriangleRecords;
use scenes::{Feature, Light, Mesh, Needs, RaySelection, Scene, Triangle};
use tracer::reflections::{ReflectionRay, ReflectionTracer};
use tracer::{
    Accel, AccelerationStructure, Choice, Forced, FrameTracer, Omission, Ray, Rays, ReflectionRays,
    SceneIdentity, SceneRemarks, SecondaryRays, TriangleTest, View,
};

/// What a report says of hits that are not those of the default test.
const WATERTIGHT_NOTE: &str = "hits are those of the watertight triangle test of Woop, Benthin & Wald 2013; no shader of it was compiled, \
                               so the report has the costs of Moeller-Trumbore";

/// What a report says of shadow rays in a scene without a light.
const LIGHT_NOTE: &str = "The scene has no light; for the shadow rays that were forced in, a point light was placed above and behind the camera.";

/// What a report says of hard shadows that are not among the sets of rays.
const OMITTED_SHADOWS: &str = "not asked for: --ray-sets does not name hard-shadows";

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
    rays: RaySelection,
    /// Of a frame with these rays.
    needs: Needs,
    pub(crate) structure: AccelerationStructure,
    /// What a report should say of pairs of triangles and of two levels.
    structure_notes: Vec<String>,
    settings: FrameSettings,
    /// Seconds for building the structure.
    pub(crate) build_s: f64,
}

impl<'a> Frame<'a> {
    /// Builds the structure.
    pub(crate) fn build(scene: &'a LoadedScene, settings: &FrameSettings) -> anyhow::Result<Self> {
        let _progress = Progress::spinner("building the structure");
        let (structure, build_s) = timed(|| built(scene, settings));
        let rays = settings.rays.over(scene.scene.rays);
        let needs = scene.scene.needs_of(&rays);
        let has_alpha = settings.features.has(Feature::AlphaTests, &needs);
        let structure = match settings.alpha.tests(&scene.scene, has_alpha) {
            Some(tests) => structure?.with_alpha(tests)?,
            None => structure?,
        };
        let structure_notes = pair_note(&structure).into_iter().chain(two_level::notes(&structure)).collect();
        Ok(Self { scene, rays, needs, structure, structure_notes, settings: *settings, build_s })
    }

    /// A tracer of what `machines` replay: the camera's rays, the shadow rays that the frame has, and what a rasteriser draws where
    /// one of them rasterises.
    pub(crate) fn tracer_for(&self, machines: &[Machine]) -> FrameTracer<'_> {
        let tracer = self.tracer(None);
        let rasterises = machines.iter().any(|machine| machine.config.technique.raster.is_some());
        if rasterises { tracer.with_raster() } else { tracer }
    }

    /// A tracer of the camera's rays and of those that follow them; of `rays` alone if they are given.
    pub(crate) fn tracer(&self, rays: Option<Vec<Ray>>) -> FrameTracer<'_> {
        match rays {
            Some(rays) => self.tracer_of(Rays::List(rays), Vec::new(), SecondaryRays::default()),
            None => self.tracer_from(self.view()),
        }
    }

    /// A tracer of the rays of `view`, which is over an image of this size, and of those that follow them.
    pub(crate) fn tracer_from(&self, view: View) -> FrameTracer<'_> {
        let [width, height] = self.size();
        self.tracer_of(Rays::View { view, width, height }, self.lights(), self.secondary())
    }

    /// A tracer of chosen pixels of `view`, see [`Rays::Pixels`].
    pub(crate) fn tracer_of_pixels(&self, view: View, pixels: Vec<u32>, known: Vec<bool>) -> FrameTracer<'_> {
        let [width, _] = self.size();
        self.tracer_of(Rays::Pixels { view, width, pixels, known }, self.lights(), self.secondary())
    }

    fn tracer_of(&self, rays: Rays, lights: Vec<scenes::Vec3>, secondary: SecondaryRays) -> FrameTracer<'_> {
        let remarks = self.remarks(matches!(rays, Rays::List(_)));
        let LoadedScene { scene, triangles, .. } = self.scene;
        let identity = SceneIdentity { name: scene.name.clone(), hash: scene.hash() };
        let tracer =
            FrameTracer::new(&self.structure, &self.settings.build, triangles, identity, rays, lights)
                .with_secondary(secondary)
                .with_shadow_query(self.settings.shadow_query)
                .with_remarks(remarks)
                .with_forced(self.settings.features.forced(&self.needs));
        if self.has(Feature::Normals) { tracer } else { tracer.without_normals() }
    }

    /// The scene.
    pub(crate) fn scene(&self) -> &Scene {
        &self.scene.scene
    }

    /// Pixels per row, and rows.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.settings.size.width, self.settings.size.height]
    }

    /// The reflection rays of each triangle, where any has one.
    pub(crate) fn reflecting(&self) -> Option<Vec<ReflectionRays>> {
        let reflections = self.secondary().reflections?;
        let reflects = reflections.iter().any(|rays| *rays != ReflectionRays::None);
        reflects.then_some(reflections)
    }

    /// Start of the random sequence of glossy rays.
    pub(crate) fn reflection_seed(&self) -> u32 {
        self.rays.seed
    }

    /// Where shadow rays go from what reflection rays hit.
    pub(crate) fn hit_lights(&self) -> Vec<scenes::Vec3> {
        self.secondary().lights
    }

    /// A tracer of reflection rays in an order.
    ///
    /// # Errors
    /// When the order does not have each ray once.
    pub(crate) fn reflection_tracer<'b>(
        &'b self,
        rays: &'b [ReflectionRay],
        order: Vec<u32>,
        lights: Vec<scenes::Vec3>,
    ) -> Result<ReflectionTracer<'b>, tracer::Error> {
        let LoadedScene { scene, triangles, .. } = self.scene;
        let identity = SceneIdentity { name: scene.name.clone(), hash: scene.hash() };
        let build = &self.settings.build;
        let tracer = ReflectionTracer::new(&self.structure, build, triangles, identity, rays, order, lights)?
            .with_shadow_query(self.settings.shadow_query);
        Ok(if self.has(Feature::Normals) { tracer } else { tracer.without_normals() })
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

    /// Where hard shadow rays go from primary hits.
    pub(crate) fn lights(&self) -> Vec<scenes::Vec3> {
        if self.has(Feature::ShadowRays) { self.all_lights() } else { Vec::new() }
    }

    /// The scene's lights; one by default where shadow rays are forced into a scene without.
    fn all_lights(&self) -> Vec<scenes::Vec3> {
        let scene = &self.scene.scene;
        let position = |&Light::Point { position }: &Light| position;
        if self.assumes_light() {
            return vec![position(&scene.default_light())];
        }
        scene.lights.iter().map(position).collect()
    }

    fn assumes_light(&self) -> bool {
        let shadows = self.has(Feature::ShadowRays) || self.has(Feature::SoftShadows);
        shadows && self.scene.scene.lights.is_empty()
    }

    /// What follows a primary hit besides hard shadow rays. What it hits is lit by all lights, unless shadow rays are left out.
    fn secondary(&self) -> SecondaryRays {
        let unlit = self.settings.features.choice(Feature::ShadowRays) == Some(Choice::Out);
        let hit_lights = if unlit { Vec::new() } else { self.all_lights() };
        secondary::rays(
            &self.scene.scene,
            &self.rays,
            |feature| self.has(feature),
            (self.all_lights(), hit_lights),
        )
    }

    fn has(&self, feature: Feature) -> bool {
        self.settings.features.has(feature, &self.needs)
    }

    /// What a report should say of the scene, whose camera's rays are traced or a list of rays.
    pub(crate) fn remarks(&self, of_list: bool) -> SceneRemarks {
        let scene = &self.scene.scene;
        let asked = with_forced(self.rays, self.settings.features);
        let mut left_out: Vec<Omission> =
            scene.needs_of(&asked).left_out().into_iter().map(omission).collect();
        if self.settings.rays.omits_hard_shadows() && !scene.lights.is_empty() {
            let of_shadows = left_out.iter_mut().filter(|entry| entry.what == Feature::ShadowRays.what());
            of_shadows.for_each(|entry| entry.why = OMITTED_SHADOWS.to_owned());
        }
        for Forced { feature, choice } in self.settings.features.forced(&self.needs) {
            left_out.retain(|entry| entry.what != feature.what());
            if choice == Choice::Out {
                let why = format!("the scene needs it; --leave-out {}", feature.name());
                left_out.push(Omission { what: feature.what().to_owned(), why });
            }
        }
        if of_list {
            let rays = Feature::ALL.into_iter().filter(|feature| feature.is_rays());
            for feature in rays.filter(|&feature| feature == Feature::ShadowRays || self.has(feature)) {
                let what = feature.what();
                left_out.retain(|entry| entry.what != what);
                let why = "a list of rays is traced for its closest hits alone".to_owned();
                left_out.push(Omission { what: what.to_owned(), why });
            }
        }
        if let Some(why) = self.structure.alpha().and_then(alpha::omission) {
            left_out.push(Omission { what: Feature::AlphaTests.what().to_owned(), why });
        }
        let scene_notes = scene.notes.iter().map(|note| note.text());
        let light_note = self.assumes_light().then_some(LIGHT_NOTE);
        let ray_notes = if of_list {
            Vec::new()
        } else {
            secondary::notes(scene, &self.rays, &self.needs, |feature| self.has(feature))
        };
        let alpha_note =
            self.structure.alpha().map(|tests| alpha::note(tests, self.scene.triangles.len() as u32));
        let test_notes = match self.settings.build.triangle_test {
            TriangleTest::MoellerTrumbore => None,
            TriangleTest::Watertight => Some(WATERTIGHT_NOTE),
        };
        SceneRemarks {
            left_out,
            notes: scene_notes
                .chain(light_note)
                .chain(test_notes)
                .map(str::to_owned)
                .chain(ray_notes)
                .chain(alpha_note)
                .chain(self.structure_notes.iter().cloned())
                .collect(),
        }
    }
}

/// How many triangles share a record, where the structure has pairs.
fn pair_note(structure: &AccelerationStructure) -> Option<String> {
    structure.traversal().node_format().filter(|format| format.has_pairs())?;
    let topology = structure.topology();
    let (pairs, triangles) = (topology.seconds.len(), topology.references.len());
    let share = 100.0 * 2.0 * pairs as f64 / triangles.max(1) as f64;
    Some(format!(
        "Pairs: {pairs} of triangles of a leaf that share an edge, {share:.0} % of the {triangles} triangles; a record of {} bytes holds a pair or a \
         triangle alone, and normals lie apart.",
        TriangleRecords::PAIR_BYTES
    ))
}

fn built(scene: &LoadedScene, settings: &FrameSettings) -> Result<AccelerationStructure, tracer::Error> {
    let traversal = settings.traversal;
    if traversal.accel() != Accel::TwoLevel {
        return AccelerationStructure::build(&scene.triangles, traversal, &settings.build);
    }
    let triangles = |mesh: &Mesh| (0..mesh.triangles.len()).map(|index| mesh.triangle(index)).collect();
    let meshes: Vec<_> = scene.scene.meshes.iter().map(triangles).collect();
    AccelerationStructure::build_two_level(&meshes, &scene.scene.instances, traversal, &settings.build)
}

fn omission(entry: scenes::LeftOut) -> Omission {
    Omission { what: entry.what.to_owned(), why: entry.why }
}
