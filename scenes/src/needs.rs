//! What a scene requires of a renderer, and what is left out when only its triangles are traced.

use crate::{Reflection, Scene};
use serde::Serialize;

/// What a scene requires. Each flag follows from the scene's own data, never from its name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Needs {
    /// The scene carries shading normals.
    pub normals: bool,
    /// The scene has at least one light.
    pub shadow_rays: bool,
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
    evidence: Evidence,
}

/// The counts behind the flags, for the sentences of [`Needs::left_out`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Evidence {
    shadow_rays_wanted: bool,
    triangles: u64,
    instances: usize,
    materials: usize,
    reflective_triangles: u64,
    alpha_tested_triangles: u64,
    textured_triangles: u64,
    triangles_with_normals: u64,
}

/// One thing a scene requires that tracing its bare triangles does not do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// The field of [`Needs`] it belongs to.
    pub what: &'static str,
    /// Why it is left out and how much of the scene it touches, in one sentence.
    pub why: String,
}

impl Needs {
    pub(crate) fn of(scene: &Scene) -> Needs {
        let mut used = vec![false; scene.materials.len()];
        let mut e = Evidence {
            shadow_rays_wanted: scene.rays.shadow,
            instances: scene.instances.len(),
            ..Evidence::default()
        };
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
                e.alpha_tested_triangles += u64::from(material.alpha_tested);
                e.textured_triangles += u64::from(material.textured);
            }
        }
        e.materials = used.iter().filter(|&&u| u).count();
        let moved = scene.instances.iter().any(|i| i.transform != glam::Affine3A::IDENTITY);
        Needs {
            normals: e.triangles_with_normals > 0,
            shadow_rays: !scene.lights.is_empty(),
            reflections: e.reflective_triangles > 0,
            alpha_tests: e.alpha_tested_triangles > 0,
            instances: moved || e.instances > scene.meshes.len(),
            textures: e.textured_triangles > 0,
            several_materials: e.materials > 1,
            evidence: e,
        }
    }

    /// What tracing primary and shadow rays against the bare triangles leaves out of this scene.
    ///
    /// A caller that does model one of these drops the entry with that `what`.
    pub fn left_out(&self) -> Vec<LeftOut> {
        let e = &self.evidence;
        let all = e.triangles;
        let entries = [
            (
                self.normals,
                "normals",
                format!(
                    "{} of {all} triangles have shading normals; the flat normal of the triangle is used",
                    e.triangles_with_normals
                ),
            ),
            (
                self.shadow_rays && !e.shadow_rays_wanted,
                "shadow_rays",
                "the scene has lights, but its file turns shadow rays off".to_owned(),
            ),
            (
                self.reflections,
                "reflections",
                format!(
                    "{} of {all} triangles are mirror or glass; no reflected or refracted ray is traced",
                    e.reflective_triangles
                ),
            ),
            (
                self.alpha_tests,
                "alpha_tests",
                format!(
                    "{} of {all} triangles carry an alpha mask; images are not read, so these triangles count as opaque",
                    e.alpha_tested_triangles
                ),
            ),
            (
                self.instances,
                "instances",
                format!("the {} instances are flattened into one list of {all} triangles", e.instances),
            ),
            (
                self.textures,
                "textures",
                format!(
                    "{} of {all} triangles are textured; images are not read and texture traffic is not counted",
                    e.textured_triangles
                ),
            ),
            (
                self.several_materials,
                "several_materials",
                format!("the triangles use {} materials; all are shaded alike", e.materials),
            ),
        ];
        entries
            .into_iter()
            .filter(|(needed, ..)| *needed)
            .map(|(_, what, why)| LeftOut { what, why })
            .collect()
    }
}
