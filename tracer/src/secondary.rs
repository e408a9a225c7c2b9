//! The rays that follow a primary hit besides hard shadow rays: soft shadows, reflections, ambient occlusion, indirect diffuse light,
//! and the shadow rays from what those hit.

use crate::caster::{Caster, Scene, is_direction};
use crate::error::Error;
use crate::ray::{Hit, Query, Ray};
use crate::ray_set::{RayKind, RaySetId};
use crate::sampling::{Points, cosine_weighted, glossy_reflection, mirror_reflection, point_of_sphere};
use crate::trace::{RayLine, RaySet};
use glam::Vec3;

/// Which rays follow each primary hit. Directions depend on the seed, the pixel and the sample alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SecondaryRays {
    /// Start of the random sequence.
    pub seed: u32,
    /// Rays per pixel of each set that is drawn at random, and there per light.
    pub samples: u32,
    /// Rays to points of lights.
    pub soft_shadows: Option<SoftShadows>,
    /// Rays along reflections: those of each triangle.
    pub reflections: Option<Vec<ReflectionRays>>,
    /// Rays into the surroundings, of this length.
    pub ambient_occlusion: Option<f32>,
    /// Rays to what lights a hit.
    pub diffuse: bool,
    /// Where shadow rays go from the hits of reflection and diffuse rays: one from each hit to each light, none from a miss.
    pub lights: Vec<Vec3>,
}

/// Lights that are spheres.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftShadows {
    /// Their middles.
    pub lights: Vec<Vec3>,
    /// Their radius, above 0.
    pub radius: f32,
}

/// The reflection rays of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReflectionRays {
    /// None.
    None,
    /// One along the mirror direction.
    Mirror,
    /// One per sample around it, by this perceptual roughness, above 0.
    Glossy(f32),
}

/// A primary hit, from which other rays start.
pub(crate) struct Surface<'a> {
    pub(crate) hit: &'a Hit,
    /// That of the ray that hit it, of unit length.
    pub(crate) direction: Vec3,
    /// Another image shows it, so that only what depends on the view is cast.
    pub(crate) is_known: bool,
}

impl ReflectionRays {
    /// Where sample `sample` of a pixel goes, from a surface with unit `normal` that `incoming` (unit length) led to; `None` where none is
    /// cast. `points` are those of [`reflection_points`].
    pub(crate) fn direction(
        self,
        sample: u32,
        incoming: Vec3,
        normal: Vec3,
        points: &Points,
    ) -> Option<Vec3> {
        let direction = match self {
            Self::Mirror if sample == 0 => mirror_reflection(incoming, normal),
            Self::Glossy(roughness) => glossy_reflection(incoming, normal, roughness, points.point(sample)),
            Self::None | Self::Mirror => return None,
        };
        is_direction(direction).then_some(direction)
    }
}

/// The points by which the reflection rays of a pixel are drawn.
pub(crate) fn reflection_points(seed: u32, pixel: u64) -> Points {
    points(seed, pixel, RayKind::Reflection, 0)
}

/// The points by which the rays of a kind are drawn, and there to one light.
fn points(seed: u32, pixel: u64, kind: RayKind, light: usize) -> Points {
    Points::new(seed, pixel, (kind as u32) << 24 | light as u32)
}

impl SecondaryRays {
    /// Its ray sets, in the order in which a pixel's shader casts them.
    pub fn ray_sets(&self) -> Vec<RaySetId> {
        let mut sets = Vec::new();
        let mut add = |kind: RayKind, sample: u32, lights: usize| {
            sets.extend((0..lights as u32).map(|light| RaySetId { kind, sample, light }));
        };
        if let Some(SoftShadows { lights, .. }) = &self.soft_shadows {
            (0..self.samples).for_each(|sample| add(RayKind::SoftShadow, sample, lights.len()));
        }
        if self.reflections.is_some() {
            for sample in 0..self.reflection_samples() {
                add(RayKind::Reflection, sample, 1);
                add(RayKind::ReflectionShadow, sample, self.lights.len());
            }
        }
        if self.ambient_occlusion.is_some() {
            (0..self.samples).for_each(|sample| add(RayKind::AmbientOcclusion, sample, 1));
        }
        if self.diffuse {
            for sample in 0..self.samples {
                add(RayKind::Diffuse, sample, 1);
                add(RayKind::DiffuseShadow, sample, self.lights.len());
            }
        }
        sets
    }

    /// A mirror has one direction.
    fn reflection_samples(&self) -> u32 {
        let glossy = |rays: &ReflectionRays| matches!(rays, ReflectionRays::Glossy(_));
        if self.reflections.iter().flatten().any(glossy) { self.samples } else { 1 }
    }
}

/// Secondary rays with what only a look at every triangle tells.
pub(crate) struct PreparedRays {
    rays: SecondaryRays,
    reflection_samples: u32,
}

impl From<SecondaryRays> for PreparedRays {
    fn from(rays: SecondaryRays) -> Self {
        Self { reflection_samples: rays.reflection_samples(), rays }
    }
}

impl PreparedRays {
    /// Whether reflection rays are among them.
    pub(crate) fn reflect(&self) -> bool {
        self.rays.reflections.is_some()
    }

    /// Casts the rays that follow a primary hit into the sets of [`SecondaryRays::ray_sets`]. `lines` takes the first reflection ray, if there
    /// is one. Returns how many traversals their loop bound ended.
    ///
    /// # Errors
    /// When the tile takes too many steps.
    pub(crate) fn cast(
        &self,
        scene: &Scene<'_>,
        pixel: u64,
        Surface { hit, direction, is_known }: Surface<'_>,
        sets: &mut [RaySet],
        lines: Option<&mut Vec<RayLine>>,
    ) -> Result<u64, Error> {
        if sets.is_empty() {
            return Ok(0);
        }
        if !hit.is_hit() {
            sets.iter_mut().for_each(RaySet::skip_ray);
            return Ok(0);
        }
        let mut caster = Caster::new(scene, sets);
        let from = scene.departure(hit, direction);
        let Self { rays, reflection_samples } = self;
        let points = |kind: RayKind, light: usize| points(rays.seed, pixel, kind, light);
        // What does not depend on the view is known with the hit.
        let new = |ray: Ray| (!is_known).then_some(ray);
        if let Some(SoftShadows { lights, radius }) = &rays.soft_shadows {
            for sample in 0..rays.samples {
                for (light, &middle) in lights.iter().enumerate() {
                    let point = points(RayKind::SoftShadow, light).point(sample);
                    let ray = from.shadow_ray(point_of_sphere(middle, *radius, from.origin, point));
                    caster.cast(new(ray), scene.shadow_query)?;
                }
            }
        }
        if let Some(reflections) = &rays.reflections {
            let points = reflection_points(rays.seed, pixel);
            let surface = reflections[hit.primitive as usize];
            let ray = |sample: u32| {
                let reflected = surface.direction(sample, direction, from.normal, &points);
                reflected.map(|reflected| from.ray(reflected))
            };
            if let (Some(lines), Some(ray)) = (lines, ray(0)) {
                lines.push(RayLine { origin: ray.origin.to_array(), direction: ray.direction.to_array() });
            }
            for sample in 0..*reflection_samples {
                caster.cast_and_light(ray(sample), &rays.lights)?;
            }
        }
        if let Some(radius) = rays.ambient_occlusion {
            let points = points(RayKind::AmbientOcclusion, 0);
            for sample in 0..rays.samples {
                let direction = cosine_weighted(from.normal, points.point(sample));
                let ray = Ray { t_max: radius, ..from.ray(direction) };
                caster.cast(new(ray), Query::Any)?;
            }
        }
        if rays.diffuse {
            let points = points(RayKind::Diffuse, 0);
            for sample in 0..rays.samples {
                let direction = cosine_weighted(from.normal, points.point(sample));
                caster.cast_and_light(new(from.ray(direction)), &rays.lights)?;
            }
        }
        Ok(caster.stalls())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::{NO_HIT, NOT_CAST};
    use crate::view::{Departure, RayOffset};
    use crate::{AccelerationStructure, BuildOptions, PreparedTriangle, Traversal, View};
    use scenes::Triangle;

    fn brute_force(triangles: &[Triangle], ray: &Ray) -> Hit {
        let mut best = Hit::miss(ray.t_max);
        for (primitive, triangle) in (0..).zip(triangles) {
            if let Some((t, u, v)) = PreparedTriangle::from(triangle).intersect(ray, best.t)
                && (t < best.t || primitive < best.primitive)
            {
                best = Hit { t, u, v, primitive };
            }
        }
        best
    }

    /// What each set should hold of one pixel, ray by ray, without any tree.
    struct Expected<'a> {
        triangles: &'a [Triangle],
        offset: RayOffset,
        /// By set: whether anything is hit, and by closest-hit rays what; none where no ray is due.
        answers: Vec<Option<u32>>,
    }

    impl Expected<'_> {
        fn occlusion(&mut self, ray: Option<Ray>) {
            let answer = |ray: Ray| if brute_force(self.triangles, &ray).is_hit() { 0 } else { NO_HIT };
            self.answers.push(ray.map(answer));
        }

        fn closest(&mut self, from: &Departure, direction: Option<Vec3>, lights: &[Vec3]) {
            let hit =
                direction.map(|direction| brute_force(self.triangles, &Ray::new(from.origin, direction)));
            self.answers.push(hit.map(|hit| hit.primitive));
            for &light in lights {
                let shadow = hit.zip(direction).filter(|(hit, _)| hit.is_hit()).map(|(hit, direction)| {
                    let triangle = &self.triangles[hit.primitive as usize];
                    self.offset.shadow_ray(triangle, hit.u, hit.v, direction, light)
                });
                self.occlusion(shadow);
            }
        }
    }

    #[test]
    fn every_ray_hits_what_brute_force_finds() {
        let cornell = scenes::builtin("cornell").expect("a built-in scene");
        let triangles = cornell.triangles();
        let lights = vec![Vec3::new(278.0, 500.0, 279.5), Vec3::new(100.0, 300.0, 100.0)];
        let surfaces = (0..triangles.len()).map(|triangle| match triangle % 3 {
            0 => ReflectionRays::Mirror,
            1 => ReflectionRays::Glossy(0.35),
            _ => ReflectionRays::None,
        });
        let rays = SecondaryRays {
            seed: 11,
            samples: 2,
            soft_shadows: Some(SoftShadows { lights: lights.clone(), radius: 60.0 }),
            reflections: Some(surfaces.collect()),
            ambient_occlusion: Some(150.0),
            diffuse: true,
            lights: lights.clone(),
        };
        let prepared = PreparedRays::from(rays.clone());
        let structure =
            AccelerationStructure::build(&triangles, Traversal::BvhStack, &BuildOptions::default())
                .expect("it builds");
        let offset = RayOffset::new(&triangles);
        let scene = Scene { structure: &structure, triangles: &triangles, offset, shadow_query: Query::Any };
        let view = View::new(&cornell.camera, 20, 20);
        let (mut hits, mut misses) = (0, 0);
        for pixel in 0..400_u32 {
            let primary = view.primary_ray(pixel % 20, pixel / 20);
            let hit = brute_force(&triangles, &primary);
            let mut sets = vec![RaySet::default(); rays.ray_sets().len()];
            let surface = Surface { hit: &hit, direction: primary.direction, is_known: false };
            prepared.cast(&scene, u64::from(pixel), surface, &mut sets, None).expect("few steps");
            let mut expected = Expected { triangles: &triangles, offset, answers: Vec::new() };
            if hit.is_hit() {
                let from = scene.departure(&hit, primary.direction);
                let point = |kind: RayKind, light: u32, sample: u32| {
                    Points::new(11, u64::from(pixel), (kind as u32) << 24 | light).point(sample)
                };
                for (sample, light) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let point = point(RayKind::SoftShadow, light, sample);
                    let target = point_of_sphere(lights[light as usize], 60.0, from.origin, point);
                    expected.occlusion(Some(from.shadow_ray(target)));
                }
                for sample in [0, 1] {
                    let point = point(RayKind::Reflection, 0, sample);
                    let direction = match (hit.primitive % 3, sample) {
                        (0, 0) => Some(mirror_reflection(primary.direction, from.normal)),
                        (1, _) => Some(glossy_reflection(primary.direction, from.normal, 0.35, point)),
                        _ => None,
                    };
                    expected.closest(&from, direction, &lights);
                }
                for sample in [0, 1] {
                    let point = point(RayKind::AmbientOcclusion, 0, sample);
                    let direction = cosine_weighted(from.normal, point);
                    expected.occlusion(Some(Ray { t_max: 150.0, ..Ray::new(from.origin, direction) }));
                }
                for sample in [0, 1] {
                    let direction = cosine_weighted(from.normal, point(RayKind::Diffuse, 0, sample));
                    expected.closest(&from, Some(direction), &lights);
                }
            } else {
                expected.answers.resize(sets.len(), None);
            }
            assert_eq!(expected.answers.len(), sets.len());
            for ((set, id), expected) in sets.iter().zip(rays.ray_sets()).zip(expected.answers) {
                let [found] = set.hits[..] else { panic!("one ray") };
                assert_eq!(set.range(0).is_empty(), expected.is_none(), "{id:?} of pixel {pixel}");
                let any_hit = !matches!(id.kind, RayKind::Reflection | RayKind::Diffuse);
                match expected {
                    Some(NO_HIT) => assert_eq!(found, NO_HIT, "{id:?} of pixel {pixel}"),
                    Some(expected) if !any_hit => assert_eq!(found, expected, "{id:?} of pixel {pixel}"),
                    Some(_) => assert!(found < NOT_CAST, "{id:?} of pixel {pixel}"),
                    None => assert!(found >= NOT_CAST, "{id:?} of pixel {pixel}"),
                }
                hits += u32::from(found < NOT_CAST);
                misses += u32::from(found == NO_HIT);
            }
        }
        assert!(hits > 1000 && misses > 1000, "{hits} hits and {misses} misses");
    }
}
