//! Casting the rays that follow a hit into their sets.

use crate::accel::AccelerationStructure;
use crate::error::Error;
use crate::ray::{Hit, NOT_CAST, Query, Ray};
use crate::trace::{RaySet, Recorder};
use crate::view::{Departure, RayOffset};
use glam::Vec3;
use scenes::Triangle;

/// What rays are cast at.
pub(crate) struct Scene<'a> {
    pub(crate) structure: &'a AccelerationStructure,
    pub(crate) triangles: &'a [Triangle],
    pub(crate) offset: RayOffset,
    /// Of rays to lights.
    pub(crate) shadow_query: Query,
}

impl Scene<'_> {
    /// Where rays leave a hit that `direction` led to.
    pub(crate) fn departure(&self, hit: &Hit, direction: Vec3) -> Departure {
        self.offset.departure(&self.triangles[hit.primitive as usize], hit.u, hit.v, direction)
    }
}

/// A ray to a light has none where the light is where it starts or too far away.
pub(crate) fn is_direction(direction: Vec3) -> bool {
    direction.is_finite() && direction != Vec3::ZERO
}

/// Casts one ray into each set in turn.
pub(crate) struct Caster<'a, 'b> {
    scene: &'a Scene<'a>,
    sets: std::slice::IterMut<'b, RaySet>,
    stalls: u64,
}

impl<'a, 'b> Caster<'a, 'b> {
    /// A caster into these sets.
    pub(crate) fn new(scene: &'a Scene<'a>, sets: &'b mut [RaySet]) -> Self {
        Self { scene, sets: sets.iter_mut(), stalls: 0 }
    }

    /// Traversals ended by their loop bound.
    pub(crate) fn stalls(&self) -> u64 {
        self.stalls
    }

    /// Without a ray, or with one that has no direction, none is cast.
    pub(crate) fn cast(&mut self, ray: Option<Ray>, query: Query) -> Result<Hit, Error> {
        let set = self.sets.next().expect("every set is cast once");
        let Some(ray) = ray.filter(|ray| is_direction(ray.direction)) else {
            set.end_ray(NOT_CAST)?;
            return Ok(Hit::miss(0.0));
        };
        let mut recorder = Recorder::new(set);
        let hit = self.scene.structure.trace(&ray, query, &mut recorder);
        self.stalls += recorder.stalls();
        set.end_ray(hit.primitive)?;
        Ok(hit)
    }

    /// A ray for its closest hit, and from there a shadow ray to each light.
    pub(crate) fn cast_and_light(&mut self, ray: Option<Ray>, lights: &[Vec3]) -> Result<(), Error> {
        let hit = self.cast(ray, Query::Closest)?;
        let next = ray.filter(|_| hit.is_hit()).map(|ray| self.scene.departure(&hit, ray.direction));
        for &light in lights {
            match &next {
                Some(next) => self.cast(Some(next.shadow_ray(light)), self.scene.shadow_query).map(drop)?,
                None => self.sets.next().expect("every set is cast once").skip_ray(),
            }
        }
        Ok(())
    }
}
