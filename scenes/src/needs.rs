//! What a scene requires of a renderer, and what a frame leaves out: what is not needed, and what is needed and not modelled.

use crate::{Gloss, RaySelection, Reflection, Scene};
use serde::{Deserialize, Serialize};

/// What a scene requires. Each flag follows from the scene's own data, never from its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Needs {
    /// The scene carries shading normals.
    pub normals: bool,
    /// The scene has at least one light, and asks for shadow rays.
    pub shadow_rays: bool,
    /// The scene has at least one light, and asks for soft shadows.
    pub soft_shadows: bool,
    /// A triangle is smooth enough for a mirror ray, and the scene asks for these.
    pub mirror: bool,
    /// A triangle is rougher than that and smooth enough for glossy rays, and the scene asks for these.
    pub glossy: bool,
    /// The scene asks for ambient occlusion.
    pub ambient_occlusion: bool,
    /// The scene asks for indirect diffuse light.
    pub diffuse: bool,
    /// A triangle has a mirror or glass material.
    pub reflections: bool,
    /// A triangle has a material whose mask decides whether a hit counts.
    pub alpha_tests: bool,
    /// The scene places meshes by more than one instance, or moves one.
    pub instances: bool,
    /// A triangle has a material that reads images.
    pub textures: bool,
    /// The triangles use more than one material.
    pub several_materials: bool,
    #[serde(skip)]
    rays: RaySelection,
    #[serde(skip)]
    evidence: Evidence,
}

/// The counts behind the flags, for the sentences of [`Needs::left_out`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Evidence {
    lights: usize,
    triangles: u64,
    instances: usize,
    materials: usize,
    reflective_triangles: u64,
    glass_triangles: u64,
    /// By the roughness gates of the rays.
    mirror_triangles: u64,
    glossy_triangles: u64,
    alpha_tested_triangles: u64,
    textured_triangles: u64,
    triangles_with_normals: u64,
}

/// What a frame has only where its scene needs it, unless it is forced in or out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feature {
    /// A pass of rays from hits to lights.
    ShadowRays,
    /// Shading normals in the records of triangles and vertices.
    Normals,
    /// Rays from hits to points of the spheres that lights are.
    SoftShadows,
    /// Mirror reflection rays.
    Mirror,
    /// Glossy reflection rays.
    Glossy,
    /// Rays of ambient occlusion.
    AmbientOcclusion,
    /// Rays to what lights a hit indirectly.
    Diffuse,
    /// Masks that decide per hit whether a surface is there.
    AlphaTests,
}

impl Feature {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::ShadowRays,
        Self::Normals,
        Self::SoftShadows,
        Self::Mirror,
        Self::Glossy,
        Self::AmbientOcclusion,
        Self::Diffuse,
        Self::AlphaTests,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::ShadowRays => "shadow-rays",
            Self::Normals => "normals",
            Self::SoftShadows => "soft-shadows",
            Self::Mirror => "mirror",
            Self::Glossy => "glossy",
            Self::AmbientOcclusion => "ao",
            Self::Diffuse => "diffuse",
            Self::AlphaTests => "alpha-tests",
        }
    }

    /// Whether it is a set of rays.
    pub fn is_rays(self) -> bool {
        !matches!(self, Self::Normals | Self::AlphaTests)
    }

    /// The feature of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|feature| feature.name() == name)
    }

    /// The entry of [`Needs::left_out`] that it belongs to.
    pub fn what(self) -> &'static str {
        match self {
            Self::ShadowRays => "shadow_rays",
            Self::Normals => "normals",
            Self::SoftShadows => "soft_shadows",
            Self::Mirror => "mirror",
            Self::Glossy => "glossy",
            Self::AmbientOcclusion => "ambient_occlusion",
            Self::Diffuse => "diffuse",
            Self::AlphaTests => "alpha_tests",
        }
    }
}

/// One thing that a frame leaves out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// The field of [`Needs`] it belongs to.
    pub what: &'static str,
    /// Why it is left out and how much of the scene it touches, in one sentence.
    pub why: String,
}

impl Needs {
    pub(crate) fn of(scene: &Scene, rays: &RaySelection) -> Needs {
        let mut used = vec![false; scene.materials.len()];
        let mut e =
            Evidence { lights: scene.lights.len(), instances: scene.instances.len(), ..Evidence::default() };
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh as usize];
            e.triangles += mesh.triangles.len() as u64;
            if let Some(normals) = &mesh.normals {
                e.triangles_with_normals += normals.triangles.iter().flatten().count() as u64;
            }
            for &id in &mesh.materials {
                let material = &scene.materials[id as usize];
                used[id as usize] = true;
                e.reflective_triangles += u64::from(material.reflection != Reflection::None);
                e.glass_triangles += u64::from(material.reflection == Reflection::Glass);
                match rays.roughness.gloss(material.reflected_roughness()) {
                    Gloss::Mirror => e.mirror_triangles += 1,
                    Gloss::Glossy => e.glossy_triangles += 1,
                    Gloss::Rough => {}
                }
                e.alpha_tested_triangles += u64::from(material.alpha_tested);
                e.textured_triangles += u64::from(material.textured);
            }
        }
        e.materials = used.iter().filter(|&&u| u).count();
        let moved = scene.instances.iter().any(|i| i.transform != glam::Affine3A::IDENTITY);
        Needs {
            normals: e.triangles_with_normals > 0,
            shadow_rays: rays.shadow && !scene.lights.is_empty(),
            soft_shadows: rays.soft_shadows && !scene.lights.is_empty(),
            mirror: rays.mirror && e.mirror_triangles > 0,
            glossy: rays.glossy && e.glossy_triangles > 0,
            ambient_occlusion: rays.ambient_occlusion,
            diffuse: rays.diffuse,
            reflections: e.reflective_triangles > 0,
            alpha_tests: e.alpha_tested_triangles > 0,
            instances: moved || e.instances > scene.meshes.len(),
            textures: e.textured_triangles > 0,
            several_materials: e.materials > 1,
            rays: *rays,
            evidence: e,
        }
    }

    /// Whether a triangle passes the roughness gate of mirror or glossy rays, whether these are asked for or not; true for other features.
    pub fn smooth_enough(&self, feature: Feature) -> bool {
        match feature {
            Feature::Mirror => self.evidence.mirror_triangles > 0,
            Feature::Glossy => self.evidence.glossy_triangles > 0,
            _ => true,
        }
    }

    /// Whether the scene needs `feature`.
    pub fn has(&self, feature: Feature) -> bool {
        match feature {
            Feature::ShadowRays => self.shadow_rays,
            Feature::Normals => self.normals,
            Feature::SoftShadows => self.soft_shadows,
            Feature::Mirror => self.mirror,
            Feature::Glossy => self.glossy,
            Feature::AmbientOcclusion => self.ambient_occlusion,
            Feature::Diffuse => self.diffuse,
            Feature::AlphaTests => self.alpha_tests,
        }
    }

    /// What a frame leaves out that has what the scene needs: in the order of the fields, what the scene does not need, and what it
    /// needs and is not modelled.
    pub fn left_out(&self) -> Vec<LeftOut> {
        let e = &self.evidence;
        let all = e.triangles;
        let not_modelled = |what, why: String| Some(LeftOut { what, why });
        let not_needed = |what, why: &str| Some(LeftOut { what, why: format!("not needed: {why}") });
        let normals = if self.normals {
            let count = e.triangles_with_normals;
            not_modelled(
                "normals",
                format!(
                    "{count} of {all} triangles have shading normals, whose bytes are counted; rays leave by the flat normal"
                ),
            )
        } else {
            not_needed(
                "normals",
                "no triangle has shading normals; the shader makes the flat one from the vertices",
            )
        };
        let shadow_rays = match (self.shadow_rays, e.lights) {
            (true, _) => None,
            (false, 0) => not_needed("shadow_rays", "the scene has no light"),
            (false, _) => {
                not_needed("shadow_rays", "the scene has lights, but its file turns shadow rays off")
            }
        };
        let soft_shadows = match (self.rays.soft_shadows, e.lights) {
            (true, 0) => not_needed("soft_shadows", "the scene has no light"),
            _ => None,
        };
        let traced = self.rays.mirror || self.rays.glossy;
        let reflections = if traced {
            None
        } else if self.reflections {
            let count = e.reflective_triangles;
            not_modelled(
                "reflections",
                format!(
                    "{count} of {all} triangles are mirror or glass; no reflected or refracted ray is traced"
                ),
            )
        } else {
            let why = "no triangle is mirror or glass: no reflected ray, no screen-space march, no binning or sorting of rays";
            not_needed("reflections", why)
        };
        let [mirror, glossy, refractions] =
            if traced { self.reflections_left_out() } else { [None, None, None] };
        let alpha_tests = if self.alpha_tests {
            None
        } else {
            not_needed("alpha_tests", "no triangle carries an alpha mask: no any-hit shader")
        };
        let instances = if self.instances {
            let count = e.instances;
            not_modelled(
                "instances",
                format!("the {count} instances are flattened into one list of {all} triangles"),
            )
        } else {
            not_needed("instances", "every mesh is placed once, as it is: no top-level structure")
        };
        let textures = if self.textures {
            let count = e.textured_triangles;
            not_modelled(
                "textures",
                format!(
                    "{count} of {all} triangles are textured; images are not read and texture traffic is not counted"
                ),
            )
        } else {
            not_needed("textures", "no triangle is textured")
        };
        let several_materials = if self.several_materials {
            let count = e.materials;
            not_modelled(
                "several_materials",
                format!("the triangles use {count} materials; all are shaded alike"),
            )
        } else {
            not_needed("several_materials", "all triangles use one material: hits are not sorted")
        };
        [
            normals,
            shadow_rays,
            soft_shadows,
            reflections,
            mirror,
            glossy,
            refractions,
            alpha_tests,
            instances,
            textures,
            several_materials,
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Of a frame with reflection rays: mirror rays, glossy rays and refracted rays, as far as it has none.
    fn reflections_left_out(&self) -> [Option<LeftOut>; 3] {
        let e = &self.evidence;
        let gates = self.rays.roughness;
        let gate = |what, asked: bool, count: u64, range: String| match (asked, count) {
            (true, 1..) => None,
            (_, 0) => Some(LeftOut {
                what,
                why: format!("not needed: no triangle that reflects has a roughness {range}"),
            }),
            (false, count) => {
                let all = e.triangles;
                let why = format!(
                    "not asked for: {count} of {all} triangles reflect with a roughness {range} and send no ray"
                );
                Some(LeftOut { what, why })
            }
        };
        let refractions = (e.glass_triangles > 0).then(|| LeftOut {
            what: "refractions",
            why: format!(
                "{} of {} triangles are glass; no refracted ray is traced",
                e.glass_triangles, e.triangles
            ),
        });
        [
            gate("mirror", self.rays.mirror, e.mirror_triangles, format!("of at most {}", gates.mirror)),
            gate(
                "glossy",
                self.rays.glossy,
                e.glossy_triangles,
                format!("above {} and of at most {}", gates.mirror, gates.glossy),
            ),
            refractions,
        ]
    }
}
