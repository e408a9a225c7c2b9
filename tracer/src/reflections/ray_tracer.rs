//! Tracing the reflection rays that the screen has no answer for, as a source of tiles.

use super::frame::ReflectionRay;
use crate::accel::{AccelerationStructure, BuildOptions};
use crate::caster::{Caster, Scene};
use crate::error::Error;
use crate::ray::Query;
use crate::ray_set::{RayKind, RaySetId};
use crate::topology::Topology;
use crate::trace::{Frame, RaySet, Tile, TileSource, TraceHeader};
use crate::tracing::{SceneIdentity, header};
use crate::view::RayOffset;
use glam::Vec3;
use scenes::Triangle;
use std::sync::atomic::{AtomicU64, Ordering};

/// A place of a list without a ray.
pub const NO_RAY: u32 = u32::MAX;

/// A list of reflection rays, at most one for each pixel of an image.
pub trait ReflectionList: TileSource {
    /// Whose ray is at a place of the frame, if there is one.
    ///
    /// # Panics
    /// When there is no such place.
    fn pixel(&self, place: u32) -> Option<u32>;
}

/// Traces a list of reflection rays in a given order, and from what they hit a shadow ray to each light.
///
/// Its frame is that list, so its sets have no primary rays, and a trace file does not take it.
pub struct ReflectionTracer<'a> {
    scene: Scene<'a>,
    rays: &'a [ReflectionRay],
    /// From a place in the frame to the ray there, or to [`NO_RAY`].
    order: Vec<u32>,
    lights: Vec<Vec3>,
    header: TraceHeader,
    topology: Topology,
    stalls: AtomicU64,
}

impl<'a> ReflectionTracer<'a> {
    /// A tracer of `rays`, at each place of the frame the one that `order` has there, or none at [`NO_RAY`].
    ///
    /// # Errors
    /// When `order` does not have each ray once.
    pub fn new(
        structure: &'a AccelerationStructure,
        options: &BuildOptions,
        triangles: &'a [Triangle],
        scene: SceneIdentity,
        rays: &'a [ReflectionRay],
        order: Vec<u32>,
        lights: Vec<Vec3>,
    ) -> Result<Self, Error> {
        check_order(&order, rays.len())?;
        let set = |kind: RayKind, light: u32| RaySetId { kind, sample: 0, light };
        let shadows = (0..lights.len() as u32).map(|light| set(RayKind::ReflectionShadow, light));
        let ray_sets = std::iter::once(set(RayKind::Reflection, 0)).chain(shadows).collect();
        let frame = Frame::List { rays: order.len() as u32 };
        Ok(Self {
            header: header(structure, options, triangles, scene, frame, ray_sets),
            topology: structure.topology(),
            scene: Scene {
                structure,
                triangles,
                offset: RayOffset::new(triangles),
                shadow_query: Query::Any,
            },
            rays,
            order,
            lights,
            stalls: AtomicU64::new(0),
        })
    }

    /// The same tracer, whose shadow rays ask for that.
    #[must_use]
    pub fn with_shadow_query(mut self, query: Query) -> Self {
        self.scene.shadow_query = query;
        self.header.shadow_query = query;
        self
    }

    /// The same tracer of a frame that shades without normals of triangles.
    #[must_use]
    pub fn without_normals(mut self) -> Self {
        self.header.normals = false;
        self
    }

    fn ray(&self, place: u32) -> Option<&ReflectionRay> {
        let ray = self.order[place as usize];
        (ray != NO_RAY).then(|| &self.rays[ray as usize])
    }
}

impl ReflectionList for ReflectionTracer<'_> {
    fn pixel(&self, place: u32) -> Option<u32> {
        self.ray(place).map(|ray| ray.pixel)
    }
}

/// Says whether `order` has each of `rays` rays once.
pub(super) fn check_order(order: &[u32], rays: usize) -> Result<(), Error> {
    let mut seen = vec![false; rays];
    let mut once = |&ray: &u32| seen.get_mut(ray as usize).is_some_and(|seen| !std::mem::replace(seen, true));
    match order.iter().position(|ray| *ray != NO_RAY && !once(ray)) {
        Some(place) => Err(Error::Options(format!(
            "the order of reflection rays has ray {} at place {place}, which is none of the {rays} rays or one that it had before; \
             give each ray one place",
            order[place]
        ))),
        None => match seen.iter().position(|seen| !seen) {
            Some(ray) => Err(Error::Options(format!(
                "the order of reflection rays lacks ray {ray} of {rays}; give each ray one place"
            ))),
            None => Ok(()),
        },
    }
}

impl TileSource for ReflectionTracer<'_> {
    fn header(&self) -> &TraceHeader {
        &self.header
    }

    fn topology(&self) -> &Topology {
        &self.topology
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), Error> {
        tile.draws.clear();
        tile.reflections.clear();
        tile.ray_sets.resize_with(self.header.ray_sets.len(), Default::default);
        tile.ray_sets.iter_mut().for_each(RaySet::clear);
        let rect = self.header.frame.tile(index);
        for place in rect.x..rect.x + rect.width {
            let mut caster = Caster::new(&self.scene, &mut tile.ray_sets);
            caster.cast_and_light(self.ray(place).map(|ray| ray.ray), &self.lights)?;
            self.stalls.fetch_add(caster.stalls(), Ordering::Relaxed);
        }
        Ok(())
    }

    fn stalls(&self) -> u64 {
        self.stalls.load(Ordering::Relaxed)
    }
}
