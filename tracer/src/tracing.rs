//! Tracing a frame on the fly, as a source of tiles.

use crate::accel::{AccelerationStructure, BuildOptions};
use crate::bvh::restart_trail::TrailBits;
use crate::caster::Scene;
use crate::error::Error;
use crate::observe::Silent;
use crate::raster::{Raster, RasterTile};
use crate::ray::{Hit, NOT_CAST, Query, Ray};
use crate::ray_set::RaySetId;
use crate::secondary::{PreparedRays, SecondaryRays, Surface};
use crate::topology::Topology;
use crate::trace::{
    Forced, Frame, Recorder, ReflectionRecord, SceneRemarks, Step, Tile, TileOutline, TileSource, TraceHeader,
};
use crate::view::{RayOffset, View};
use glam::Vec3;
use scenes::Triangle;
use std::sync::atomic::{AtomicU64, Ordering};

/// The primary rays of a frame.
pub enum Rays {
    /// One per pixel of a camera's image.
    View {
        /// The camera.
        view: View,
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Of some pixels of a camera's image, in an order.
    Pixels {
        /// The camera.
        view: View,
        /// Pixels of the image per row.
        width: u32,
        /// The pixels, by their numbers in rows from the top left.
        pixels: Vec<u32>,
        /// Of each, whether another image shows what it hits, so that those rays alone are traced that depend on the view
        /// ([`RayKind::depends_on_view`](crate::RayKind::depends_on_view)).
        known: Vec<bool>,
    },
    /// Given one by one.
    List(Vec<Ray>),
}

/// A primary ray to trace.
struct PrimaryRay {
    /// Of its pixel, in rows of the image; of its place in a list of rays.
    number: u64,
    ray: Ray,
    /// What it hits, another image shows.
    is_known: bool,
}

impl Rays {
    fn frame(&self) -> Frame {
        match self {
            Rays::View { width, height, .. } => Frame::Image { width: *width, height: *height },
            Rays::Pixels { pixels, .. } => Frame::List { rays: pixels.len() as u32 },
            Rays::List(rays) => Frame::List { rays: rays.len() as u32 },
        }
    }

    fn ray(&self, x: u32, y: u32) -> PrimaryRay {
        match self {
            Rays::View { view, width, .. } => {
                let number = u64::from(y) * u64::from(*width) + u64::from(x);
                PrimaryRay { number, ray: view.primary_ray(x, y), is_known: false }
            }
            Rays::Pixels { view, width, pixels, known } => {
                let pixel = pixels[x as usize];
                let ray = view.primary_ray(pixel % width, pixel / width);
                PrimaryRay { number: u64::from(pixel), ray, is_known: known[x as usize] }
            }
            Rays::List(rays) => PrimaryRay { number: u64::from(x), ray: rays[x as usize], is_known: false },
        }
    }

    fn raster<'a>(&self, triangles: &'a [Triangle]) -> Option<Raster<'a>> {
        match self {
            Rays::View { view, width, height } => Some(Raster::new(triangles, view, *width, *height)),
            Rays::Pixels { .. } | Rays::List(_) => None,
        }
    }
}

/// What identifies the scene in the header.
pub struct SceneIdentity {
    /// Its name.
    pub name: String,
    /// Its hash.
    pub hash: u64,
}

/// The header of a frame of these sets of rays.
pub(crate) fn header(
    structure: &AccelerationStructure,
    options: &BuildOptions,
    triangles: &[Triangle],
    scene: SceneIdentity,
    frame: Frame,
    ray_sets: Vec<RaySetId>,
) -> TraceHeader {
    let traversal = structure.traversal();
    TraceHeader {
        generator: concat!("raybudget ", env!("CARGO_PKG_VERSION")).to_owned(),
        scene: scene.name,
        scene_hash: format!("{:016x}", scene.hash),
        triangles: triangles.len() as u32,
        frame,
        ray_sets,
        shadow_query: Query::Any,
        raster: false,
        normals: true,
        reflections: None,
        forced: Vec::new(),
        alpha: structure.alpha().cloned(),
        accel: traversal.accel(),
        traversal: traversal.name().to_owned(),
        node_format: traversal.node_format(),
        node_fetch: traversal.node_fetch(),
        loop_structure: traversal.loop_structure(),
        stack_entries: structure.stack_entries(),
        short_stack: traversal.short_stack(),
        trail_bits: structure.trail_bits().map(TrailBits::count),
        sah_costs: [options.traversal_cost, options.intersection_cost],
        depth: structure.depth(),
        remarks: SceneRemarks::default(),
    }
}

/// Traces the tiles of a frame when they are asked for.
pub struct FrameTracer<'a> {
    scene: Scene<'a>,
    rays: Rays,
    /// The same image rasterised, where that was asked for.
    raster: Option<Raster<'a>>,
    /// One set of shadow rays each.
    lights: Vec<Vec3>,
    /// What else follows a primary hit.
    secondary: PreparedRays,
    header: TraceHeader,
    topology: Topology,
    stalls: AtomicU64,
}

impl<'a> FrameTracer<'a> {
    /// A tracer of `rays` and, for every primary hit, of a shadow ray to each of `lights`.
    pub fn new(
        structure: &'a AccelerationStructure,
        options: &BuildOptions,
        triangles: &'a [Triangle],
        scene: SceneIdentity,
        rays: Rays,
        lights: Vec<Vec3>,
    ) -> Self {
        let shadows = (0..lights.len() as u32).map(RaySetId::shadow);
        let ray_sets = std::iter::once(RaySetId::PRIMARY).chain(shadows).collect();
        let header = header(structure, options, triangles, scene, rays.frame(), ray_sets);
        let topology = structure.topology();
        let offset = RayOffset::new(triangles);
        let scene = Scene { structure, triangles, offset, shadow_query: Query::Any };
        let secondary = SecondaryRays::default().into();
        let stalls = AtomicU64::new(0);
        Self { scene, rays, raster: None, lights, secondary, header, topology, stalls }
    }

    /// The same tracer, which also casts these rays from every primary hit.
    #[must_use]
    pub fn with_secondary(mut self, secondary: SecondaryRays) -> Self {
        self.header.ray_sets.truncate(1 + self.lights.len());
        self.header.ray_sets.extend(secondary.ray_sets());
        self.secondary = secondary.into();
        self
    }

    /// The same tracer, whose shadow rays ask for that.
    #[must_use]
    pub fn with_shadow_query(mut self, query: Query) -> Self {
        self.scene.shadow_query = query;
        self.header.shadow_query = query;
        self
    }

    /// The same tracer, which also lists what a rasteriser draws in each tile; a list of rays stays as it is.
    #[must_use]
    pub fn with_raster(mut self) -> Self {
        self.raster = self.rays.raster(self.scene.triangles);
        self.header.raster = self.raster.is_some();
        self
    }

    /// The same tracer, which also keeps the lines of reflection rays; one that casts none stays as it is.
    #[must_use]
    pub fn with_reflection_record(mut self, record: ReflectionRecord) -> Self {
        self.header.reflections = self.secondary.reflect().then_some(record);
        self
    }

    /// The same tracer of a frame that shades without normals of triangles.
    #[must_use]
    pub fn without_normals(mut self) -> Self {
        self.header.normals = false;
        self
    }

    /// The same tracer, its header saying what was forced.
    #[must_use]
    pub fn with_forced(mut self, forced: Vec<Forced>) -> Self {
        self.header.forced = forced;
        self
    }

    /// The same tracer, its header with these remarks.
    #[must_use]
    pub fn with_remarks(mut self, remarks: SceneRemarks) -> Self {
        self.header.remarks = remarks;
        self
    }

    /// Traces every ray of a tile and rasterises it; `primary_hit` sees each ray's number (row-major over the frame) and its hit.
    ///
    /// # Errors
    /// When the tile takes too many steps.
    pub fn trace_tile(
        &self,
        index: u32,
        tile: &mut Tile,
        mut primary_hit: impl FnMut(u64, &Hit),
    ) -> Result<(), Error> {
        tile.draws.clear();
        if let Some(raster) = &self.raster {
            let mut drawn = RasterTile::default();
            std::mem::swap(&mut drawn.draws, &mut tile.draws);
            raster.tile(index, &mut drawn);
            std::mem::swap(&mut drawn.draws, &mut tile.draws);
        }
        let stalls = self.trace_rays(index, 1, tile, &mut primary_hit)?;
        self.stalls.fetch_add(stalls, Ordering::Relaxed);
        Ok(())
    }

    /// Traces one of `stride` rays of a tile in each direction, and says how many traversals their loop bound ended.
    fn trace_rays(
        &self,
        index: u32,
        stride: u32,
        tile: &mut Tile,
        primary_hit: &mut impl FnMut(u64, &Hit),
    ) -> Result<u64, Error> {
        let rect = self.header.frame.tile(index);
        tile.ray_sets.resize_with(self.header.ray_sets.len(), Default::default);
        tile.ray_sets.iter_mut().for_each(crate::trace::RaySet::clear);
        tile.reflections.clear();
        let mut lines = self.header.reflections.is_some().then_some(&mut tile.reflections);
        let (primary_set, other_sets) =
            tile.ray_sets.split_first_mut().expect("the primary rays are always there");
        let (shadow_sets, secondary_sets) = other_sets.split_at_mut(self.lights.len());
        let Scene { structure, triangles, offset, shadow_query } = &self.scene;
        let mut stalls = 0;
        let every = |start: u32, length: u32| (start..start + length).step_by(stride as usize);
        for y in every(rect.y, rect.height) {
            for x in every(rect.x, rect.width) {
                let PrimaryRay { number, ray, is_known } = self.rays.ray(x, y);
                let hit = if is_known {
                    primary_set.end_ray(NOT_CAST)?;
                    structure.trace(&ray, Query::Closest, &mut Silent)
                } else {
                    let mut recorder = Recorder::new(primary_set);
                    let hit = structure.trace(&ray, Query::Closest, &mut recorder);
                    stalls += recorder.stalls();
                    primary_set.end_ray(hit.primitive)?;
                    hit
                };
                primary_hit(number, &hit);
                for (set, &light) in shadow_sets.iter_mut().zip(&self.lights) {
                    if is_known || !hit.is_hit() {
                        set.skip_ray();
                        continue;
                    }
                    let triangle = &triangles[hit.primitive as usize];
                    let shadow = offset.shadow_ray(triangle, hit.u, hit.v, ray.direction, light);
                    let mut recorder = Recorder::new(set);
                    let occluder = structure.trace(&shadow, *shadow_query, &mut recorder);
                    stalls += recorder.stalls();
                    set.end_ray(occluder.primitive)?;
                }
                let lines = lines.as_deref_mut();
                let from = Surface { hit: &hit, direction: ray.direction, is_known };
                stalls += self.secondary.cast(&self.scene, number, from, secondary_sets, lines)?;
            }
        }
        Ok(stalls)
    }
}

/// Of so many rays in each direction, one is traced to see how much work a tile is.
const OUTLINE_STRIDE: u32 = 8;

impl TileSource for FrameTracer<'_> {
    fn header(&self) -> &TraceHeader {
        &self.header
    }

    fn topology(&self) -> &Topology {
        &self.topology
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), Error> {
        self.trace_tile(index, tile, |_, _| {})
    }

    /// From a few of its rays: their steps, and how many of these differ.
    fn outline(&self, index: u32) -> Result<Option<TileOutline>, Error> {
        let mut tile = Tile::default();
        self.trace_rays(index, OUTLINE_STRIDE, &mut tile, &mut |_, _| {})?;
        let rect = self.header.frame.tile(index);
        let traced = tile.ray_sets[0].ends.len() as u64;
        let of_all = u64::from(rect.width * rect.height) * size_of::<Step>() as u64;
        let mut steps: Vec<Step> = tile.ray_sets.iter().flat_map(|set| &set.steps).copied().collect();
        let all = steps.len() as u64;
        steps.sort_unstable();
        steps.dedup();
        let bytes = |steps: u64| steps * of_all / traced.max(1);
        Ok(Some(TileOutline { bytes: bytes(all), compressed_bytes: bytes(steps.len() as u64) }))
    }

    fn stalls(&self) -> u64 {
        self.stalls.load(Ordering::Relaxed)
    }
}
