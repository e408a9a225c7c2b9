//! A whole scene: geometry, materials, camera, lights, rays, and what had to be assumed.

use crate::{Aabb, Camera, Instance, Light, Material, Mesh, Needs, RaySelection, Triangle};
use crate::{camera, load};
use glam::Vec3;
use serde::Serialize;
use std::fmt;
use xxhash_rust::xxh3::Xxh3Default;

/// Something a user should know about a loaded scene, as one plain sentence.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind", content = "text")]
pub enum Note {
    /// The scene lacks something; it was loaded without.
    Missing(String),
    /// The scene does not say; this was chosen for it.
    Assumed(String),
    /// A property of the scene that results may depend on.
    Found(String),
}

impl Note {
    /// The sentence.
    pub fn text(&self) -> &str {
        let (Note::Missing(text) | Note::Assumed(text) | Note::Found(text)) = self;
        text
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

/// A scene, ready to trace.
///
/// Loaders and generators guarantee: at least one triangle, all indices in range, all coordinates finite, at most
/// [`MAX_TRIANGLES`](crate::MAX_TRIANGLES) flattened triangles, a valid camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Built-in name, or file name without its extensions.
    pub name: String,
    /// The meshes, in file order.
    pub meshes: Vec<Mesh>,
    /// Where the meshes stand, in file order. A mesh without an instance is not in the scene.
    pub instances: Vec<Instance>,
    /// The materials that meshes refer to.
    pub materials: Vec<Material>,
    /// Where the scene is seen from.
    pub camera: Camera,
    /// The lights that shadow rays go to.
    pub lights: Vec<Light>,
    /// Which rays the scene asks for.
    pub rays: RaySelection,
    /// What was missing, assumed or noticed.
    pub notes: Vec<Note>,
}

impl Scene {
    /// What the scene requires of a renderer.
    pub fn needs(&self) -> Needs {
        Needs::of(self, &self.rays)
    }

    /// As [`Self::needs`], of a frame with these rays.
    pub fn needs_of(&self, rays: &RaySelection) -> Needs {
        Needs::of(self, rays)
    }

    /// Radius of the sphere around the scene's box.
    pub fn radius(&self) -> f64 {
        camera::bounding_sphere(self.bounds()).1
    }

    /// The material of every triangle, in the order of [`Scene::triangles`].
    pub fn triangle_materials(&self) -> impl Iterator<Item = &Material> {
        let meshes = self.instances.iter().map(|instance| &self.meshes[instance.mesh as usize]);
        meshes.flat_map(|mesh| &mesh.materials).map(|&material| &self.materials[material as usize])
    }

    /// The light that a scene without one is given: above and behind the camera.
    pub fn default_light(&self) -> Light {
        load::default_light(&self.camera, self.bounds())
    }

    /// All triangles in world space, instance after instance, each in file order.
    ///
    /// The position in this list is the primitive's id everywhere. Degenerate triangles are kept, so that ids
    /// never shift.
    pub fn triangles(&self) -> Vec<Triangle> {
        let mut all = Vec::with_capacity(self.triangle_count());
        for instance in &self.instances {
            let mesh = &self.meshes[instance.mesh as usize];
            let world: Vec<Vec3> = mesh.positions.iter().map(|&p| instance.transform_point(p)).collect();
            all.extend(mesh.triangles.iter().map(|t| Triangle { v: t.map(|i| world[i as usize]) }));
        }
        all
    }

    /// For each of [`Self::triangles`], whether its material is alpha-tested.
    pub fn alpha_tested(&self) -> impl Iterator<Item = bool> + '_ {
        let meshes = self.instances.iter().map(|instance| &self.meshes[instance.mesh as usize]);
        meshes.flat_map(|mesh| &mesh.materials).map(|&id| self.materials[id as usize].alpha_tested)
    }

    /// How many triangles [`Scene::triangles`] returns.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|i| self.meshes[i.mesh as usize].triangles.len()).sum()
    }

    /// The box around all triangles. Vertices that no triangle uses do not count.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.triangles().into_iter().flat_map(|t| t.v))
    }

    /// Xxh3 (64 bits) of the bits of all world-space triangles, the camera and the lights.
    ///
    /// The same scene has the same hash on every platform. Names, materials, normals, ray selection and notes do
    /// not count.
    pub fn hash(&self) -> u64 {
        let mut hasher = Hasher { xxh3: Xxh3Default::new(), pending: Vec::with_capacity(Hasher::BLOCK) };
        let triangles = self.triangles();
        hasher.bytes(&(triangles.len() as u64).to_le_bytes());
        for corner in triangles.iter().flat_map(|t| &t.v) {
            hasher.point(*corner);
        }
        hasher.point(self.camera.eye);
        hasher.point(self.camera.target);
        hasher.point(self.camera.up);
        hasher.bytes(&self.camera.vertical_fov_degrees.to_bits().to_le_bytes());
        for light in &self.lights {
            match light {
                Light::Point { position } => hasher.point(*position),
            }
        }
        hasher.finish()
    }
}

/// Feeds xxh3 in blocks: its update is slow for a few bytes at a time.
struct Hasher {
    xxh3: Xxh3Default,
    pending: Vec<u8>,
}

impl Hasher {
    const BLOCK: usize = 1 << 16;

    fn bytes(&mut self, bytes: &[u8]) {
        if self.pending.len() + bytes.len() > Self::BLOCK {
            self.xxh3.update(&self.pending);
            self.pending.clear();
        }
        self.pending.extend_from_slice(bytes);
    }

    fn point(&mut self, p: Vec3) {
        let mut bytes = [0; 12];
        for (slot, value) in bytes.chunks_exact_mut(4).zip(p.to_array()) {
            slot.copy_from_slice(&value.to_bits().to_le_bytes());
        }
        self.bytes(&bytes);
    }

    fn finish(mut self) -> u64 {
        self.xxh3.update(&self.pending);
        self.xxh3.digest()
    }
}
