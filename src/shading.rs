//! Colours of surfaces in pictures that this machine's CPU renders.

use crate::frame::Frame;
use reports::image::Rgb;
use scenes::{Material, Scene, Vec3};
use tracer::{Departure, Query, RayOffset, ReflectionRays, Silent};

/// Light that reaches every surface, so that shadows keep their shapes.
const AMBIENT: f32 = 0.1;

/// Reflectance of a dielectric that is looked at along its normal, for surfaces whose material names none: that of glass, of index 1.5.
const DIELECTRIC: f32 = 0.04;

/// Diffuse surfaces under point lights.
pub(crate) struct Shading<'a> {
    frame: &'a Frame<'a>,
    lights: Vec<Vec3>,
    /// Linear, by triangle.
    colours: Vec<Vec3>,
}

/// Surfaces that reflect besides, those whose frame sends reflection rays from them: one each, as if they were smooth.
pub(crate) struct Mirrors {
    offset: RayOffset,
    /// By triangle, the reflectance along its normal, if it reflects.
    reflectances: Vec<Option<Vec3>>,
}

impl Mirrors {
    /// Those of a scene, if it has any.
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let scene = frame.scene();
        let reflectance = |(rays, material): (ReflectionRays, &Material)| {
            let named = material.specular.max_element() > 0.0;
            let along_normal = if named { material.specular } else { Vec3::splat(DIELECTRIC) };
            (rays != ReflectionRays::None).then_some(along_normal)
        };
        let reflecting = frame.reflecting()?;
        let reflectances = reflecting.into_iter().zip(scene.triangle_materials()).map(reflectance);
        Some(Self { offset: RayOffset::new(frame.triangles()), reflectances: reflectances.collect() })
    }

    /// Linear light that a hit throws back towards where `incoming`, of unit length, comes from: by the Fresnel term of Schlick 1994.
    pub(crate) fn reflected(
        &self,
        shading: &Shading<'_>,
        triangle: u32,
        hit: &Departure,
        incoming: Vec3,
    ) -> Vec3 {
        let Some(along_normal) = self.reflectances[triangle as usize] else { return Vec3::ZERO };
        let ray = hit.ray(incoming.reflect(hit.normal));
        let seen = shading.frame.structure.trace(&ray, Query::Closest, &mut Silent);
        if !seen.is_hit() {
            return Vec3::ZERO;
        }
        let triangle = &shading.frame.triangles()[seen.primitive as usize];
        let departure = self.offset.departure(triangle, seen.u, seen.v, ray.direction);
        let grazing = (1.0 - hit.normal.dot(incoming).abs()).clamp(0.0, 1.0).powi(5);
        let reflectance = along_normal + (Vec3::ONE - along_normal) * grazing;
        reflectance * shading.colour(seen.primitive, &departure, ray.direction)
    }
}

impl<'a> Shading<'a> {
    /// As the scene of `frame` is lit.
    pub(crate) fn new(frame: &'a Frame<'a>) -> Self {
        Self { frame, lights: frame.lights(), colours: colours(frame.scene()) }
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
            let hidden = self.frame.structure.trace(&shadow, Query::Any, &mut Silent).is_hit();
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
    scene.triangle_materials().map(|material| material.diffuse).collect()
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
