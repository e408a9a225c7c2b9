//! Colours of surfaces in pictures that this machine's CPU renders.

use crate::frame::Frame;
use reports::image::Rgb;
use scenes::{Scene, Vec3};
use tracer::{AccelerationStructure, Departure, Query, Silent};

/// Light that reaches every surface, so that shadows keep their shapes.
const AMBIENT: f32 = 0.1;

/// Diffuse surfaces under point lights.
pub(crate) struct Shading<'a> {
    structure: &'a AccelerationStructure,
    lights: Vec<Vec3>,
    /// Linear, by triangle.
    colours: Vec<Vec3>,
}

impl<'a> Shading<'a> {
    /// As the scene of `frame` is lit.
    pub(crate) fn new(frame: &'a Frame<'_>) -> Self {
        Self { structure: &frame.structure, lights: frame.lights(), colours: colours(frame.scene()) }
    }

    /// Shadow rays of a hit.
    pub(crate) fn lights(&self) -> u64 {
        self.lights.len() as u64
    }

    /// Linear colour of a hit: the diffuse colour, lit through the angle of the geometric normal by each light that is seen. Without
    /// lights it is lit from where `incoming` came from.
    pub(crate) fn colour(&self, triangle: u32, hit: &Departure, incoming: Vec3) -> Vec3 {
        let angle = |towards: Vec3| hit.normal.dot(towards.normalize_or_zero()).abs();
        let seen = |&light: &Vec3| {
            let shadow = hit.shadow_ray(light);
            let hidden = self.structure.trace(&shadow, Query::Any, &mut Silent).is_hit();
            if hidden { 0.0 } else { angle(shadow.direction) }
        };
        let light = match self.lights.as_slice() {
            [] => angle(incoming),
            lights => lights.iter().map(seen).sum(),
        };
        self.colours[triangle as usize] * (AMBIENT + (1.0 - AMBIENT) * light)
    }
}

/// The diffuse colour of every triangle, in the order of [`Scene::triangles`].
fn colours(scene: &Scene) -> Vec<Vec3> {
    let meshes = scene.instances.iter().map(|instance| &scene.meshes[instance.mesh as usize]);
    let materials = meshes.flat_map(|mesh| &mesh.materials);
    materials.map(|&material| scene.materials[material as usize].diffuse).collect()
}

/// Linear light as sRGB of 8 bits (IEC 61966-2-1); what is brighter than white is white.
pub(crate) fn srgb(linear: Vec3) -> Rgb {
    linear.to_array().map(|value| {
        let value = value.clamp(0.0, 1.0);
        let curve = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
        (curve * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_encoded_by_the_curve_of_srgb() {
        assert_eq!(srgb(Vec3::new(0.0, 1.0, 7.0)), [0, 255, 255]);
        assert_eq!(srgb(Vec3::new(-1.0, 0.215_861, 0.001)), [0, 128, 3]);
    }

    #[test]
    fn every_triangle_has_a_colour() {
        for builtin in scenes::BUILTINS {
            let scene = scenes::load(builtin.name).expect("it is built in");
            assert_eq!(colours(&scene).len(), scene.triangles().len(), "{}", builtin.name);
        }
    }
}
