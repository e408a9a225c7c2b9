//! A trace: what every ray of a frame visited, tile by tile.

use crate::accel::Accel;
use crate::alpha::AlphaTests;
use crate::error::Error;
use crate::observe::{LoopStructure, NodeFetch, Observer, Op};
use crate::raster::TileDraw;
use crate::ray::{NO_HIT, Query};
use crate::ray_set::{self, RaySetId};
use crate::topology::Topology;
use crate::wide::NodeFormat;
use scenes::Feature;
use serde::{Deserialize, Serialize};

/// Edge of an image tile in pixels, and the square root of the rays in a tile of a list: a multiple of every warp's tile.
pub const TILE_EDGE: u32 = 32;

/// Rays in a full tile.
pub const TILE_RAYS: u32 = TILE_EDGE * TILE_EDGE;

/// Most steps that one ray set of a tile may have (256 MiB), so that memory is bounded for any scene.
pub const MAX_TILE_STEPS: usize = 1 << 26;

/// One step of a ray, packed: the [`Op`] in the upper 3 bits, the id in the lower 29.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct Step(u32);

impl Step {
    const ID_BITS: u32 = 29;
    /// Largest id.
    pub const MAX_ID: u32 = (1 << Self::ID_BITS) - 1;

    /// Packs a step.
    #[inline(always)]
    pub fn new(op: Op, id: u32) -> Self {
        debug_assert!(id <= Self::MAX_ID);
        Self((op as u32) << Self::ID_BITS | id)
    }

    /// What was done.
    #[inline(always)]
    pub fn op(self) -> Op {
        Op::ALL[(self.0 >> Self::ID_BITS) as usize]
    }

    /// To what.
    #[inline(always)]
    pub fn id(self) -> u32 {
        self.0 & Self::MAX_ID
    }
}

/// How rays are numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Frame {
    /// One primary ray per pixel; tiles of [`TILE_EDGE`] squared pixels in rows, cut at the right and lower edge; pixels
    /// of a tile in rows.
    Image {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A list of rays, [`TILE_RAYS`] per tile, the last one shorter.
    List {
        /// Number of rays.
        rays: u32,
    },
}

/// A tile's place: for an image in pixels; for a list a row of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileRect {
    /// Left edge; for a list the first ray.
    pub x: u32,
    /// Upper edge; 0 for a list.
    pub y: u32,
    /// Width; for a list the number of rays.
    pub width: u32,
    /// Height; 1 for a list.
    pub height: u32,
}

impl Frame {
    /// Number of rays in a full set.
    pub fn rays(self) -> u64 {
        match self {
            Frame::Image { width, height } => u64::from(width) * u64::from(height),
            Frame::List { rays } => u64::from(rays),
        }
    }

    /// Number of tiles.
    pub fn tiles(self) -> u32 {
        match self {
            Frame::Image { width, height } => width.div_ceil(TILE_EDGE) * height.div_ceil(TILE_EDGE),
            Frame::List { rays } => rays.div_ceil(TILE_RAYS),
        }
    }

    /// Where tile `index` lies; tiles are numbered in rows.
    pub fn tile(self, index: u32) -> TileRect {
        match self {
            Frame::Image { width, height } => {
                let columns = width.div_ceil(TILE_EDGE);
                let (x, y) = (index % columns * TILE_EDGE, index / columns * TILE_EDGE);
                TileRect { x, y, width: TILE_EDGE.min(width - x), height: TILE_EDGE.min(height - y) }
            }
            Frame::List { rays } => {
                let x = index * TILE_RAYS;
                TileRect { x, y: 0, width: TILE_RAYS.min(rays - x), height: 1 }
            }
        }
    }
}

/// The steps of one ray set within a tile.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RaySet {
    /// All steps, ray after ray.
    pub steps: Vec<Step>,
    /// Per ray, where its steps end in `steps`. A ray without steps was not traced.
    pub ends: Vec<u32>,
    /// Per ray, the triangle hit (file order), [`NO_HIT`], or [`NOT_CAST`](crate::NOT_CAST).
    pub hits: Vec<u32>,
}

impl RaySet {
    /// Empties the set, keeping its memory.
    pub fn clear(&mut self) {
        let Self { steps, ends, hits } = self;
        steps.clear();
        ends.clear();
        hits.clear();
    }

    /// Where ray `index`'s steps lie in `steps`.
    #[inline]
    pub fn range(&self, index: usize) -> std::ops::Range<usize> {
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        start as usize..self.ends[index] as usize
    }

    /// Ends a ray whose steps have been pushed.
    ///
    /// # Errors
    /// When the tile holds more than [`MAX_TILE_STEPS`].
    pub fn end_ray(&mut self, hit: u32) -> Result<(), Error> {
        if self.steps.len() > MAX_TILE_STEPS {
            return Err(Error::Options(format!(
                "the rays of one 32x32 tile took more than {MAX_TILE_STEPS} steps: the scene overwhelms this structure (many \
                 overlapping or coincident triangles); try another --accel or --ct/--ci, or remove duplicates"
            )));
        }
        self.ends.push(self.steps.len() as u32);
        self.hits.push(hit);
        Ok(())
    }

    /// Ends a ray that was not traced, as nothing was hit that it would start from.
    pub fn skip_ray(&mut self) {
        self.ends.push(self.steps.len() as u32);
        self.hits.push(NO_HIT);
    }
}

/// Where a ray starts, and where it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayLine {
    /// Its origin.
    pub origin: [f32; 3],
    /// Its direction.
    pub direction: [f32; 3],
}

/// One tile of a trace: a ray set for each entry of [`TraceHeader::ray_sets`], each with a ray per pixel of the tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tile {
    /// In the order of the header.
    pub ray_sets: Vec<RaySet>,
    /// What a rasteriser draws in this tile from the same camera, in file order; empty unless [`TraceHeader::raster`].
    pub draws: Vec<TileDraw>,
    /// Of each pixel with a reflection ray that was cast, in rows, that of the first sample; empty unless [`TraceHeader::reflections`].
    pub reflections: Vec<RayLine>,
}

/// Records steps into a set.
pub struct Recorder<'a> {
    steps: &'a mut Vec<Step>,
    stalls: u64,
}

impl<'a> Recorder<'a> {
    /// Appends to `set`.
    pub fn new(set: &'a mut RaySet) -> Self {
        Self { steps: &mut set.steps, stalls: 0 }
    }

    /// Traversals ended by their loop bound.
    pub fn stalls(&self) -> u64 {
        self.stalls
    }
}

impl Observer for Recorder<'_> {
    #[inline(always)]
    fn step(&mut self, op: Op, id: u32) {
        self.steps.push(Step::new(op, id));
    }

    #[inline(always)]
    fn stall(&mut self) {
        self.stalls += 1;
    }
}

/// What a report should say of a scene although its steps do not show it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneRemarks {
    /// What the scene needs and the traced rays do not do.
    pub left_out: Vec<Omission>,
    /// What was missing, assumed or noticed when the scene was loaded, in sentences.
    pub notes: Vec<String>,
}

/// One thing that the traced rays do not do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Omission {
    /// What.
    pub what: String,
    /// Why, and how much of the scene it touches.
    pub why: String,
}

/// A feature that a frame has although its scene does not need it, or does not have although its scene does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Forced {
    /// Which.
    pub feature: Feature,
    /// Which way.
    pub choice: Choice,
}

/// Whether a frame has a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Choice {
    /// It does.
    In,
    /// It does not.
    Out,
}

/// What is known of a frame's reflections besides what their rays visit, so that a replay can sort these rays and what they hit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReflectionRecord {
    /// The scene's box: its least and its largest coordinates.
    pub bounds: [[f32; 3]; 2],
    /// What a report should say of the shaders of triangles, in a sentence.
    pub shaders: String,
}

fn any_hit() -> Query {
    Query::Any
}

fn is_any_hit(query: &Query) -> bool {
    *query == Query::Any
}

fn yes() -> bool {
    true
}

fn is_yes(flag: &bool) -> bool {
    *flag
}

/// What a trace is a trace of, and how its steps are to be read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraceHeader {
    /// Program that wrote it.
    pub generator: String,
    /// Name of the scene.
    pub scene: String,
    /// Hash of the scene's geometry, camera and lights, 16 hex digits.
    pub scene_hash: String,
    /// Triangles of the scene.
    pub triangles: u32,
    /// Numbering of the rays.
    pub frame: Frame,
    /// The sets of rays, in the order in which a pixel's shader casts them.
    #[serde(with = "ray_set")]
    pub ray_sets: Vec<RaySetId>,
    /// What shadow rays ask for: they need any hit, and some renderers search the closest one.
    #[serde(default = "any_hit", skip_serializing_if = "is_any_hit")]
    pub shadow_query: Query,
    /// Whether tiles list the triangles that a rasteriser draws; never for a list of rays.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub raster: bool,
    /// Whether shading reads normals of triangles; without them a hit has the flat normal of its vertices.
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub normals: bool,
    /// Where tiles also hold the lines of reflection rays, and the trace the shader of each triangle; only with an image of such rays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reflections: Option<ReflectionRecord>,
    /// What was forced in or out, against what the scene needs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forced: Vec<Forced>,
    /// Which triangles are alpha-tested, and how; `None` where all are opaque and marked so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alpha: Option<AlphaTests>,
    /// Structure.
    pub accel: Accel,
    /// Traversal, by name.
    pub traversal: String,
    /// What the nodes of a wide BVH hold; `None` for any other structure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node_format: Option<NodeFormat>,
    /// Whether its nodes are fetched in pairs.
    pub node_fetch: NodeFetch,
    /// Its loops.
    pub loop_structure: LoopStructure,
    /// Entries of a stack in memory; 0 without one.
    pub stack_entries: u32,
    /// Entries of a short stack in registers; 0 without one.
    pub short_stack: u32,
    /// Bits of a restart trail, if there is one.
    pub trail_bits: Option<u32>,
    /// SAH costs Ct and Ci of the build.
    pub sah_costs: [f64; 2],
    /// Longest path from the root, in edges.
    pub depth: u32,
    /// What a report should say of the scene.
    #[serde(default)]
    pub remarks: SceneRemarks,
}

/// Where tiles come from: a traversal at work, or a file. Tiles can be asked for in any order, from any thread.
pub trait TileSource: Sync {
    /// The header.
    fn header(&self) -> &TraceHeader;
    /// The tree's shape.
    fn topology(&self) -> &Topology;
    /// Puts tile `index` into `tile`, whose memory is reused.
    ///
    /// # Errors
    /// When the tile cannot be read or is too large.
    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), Error>;
    /// What is known of tile `index` without making it; `None` where nothing is.
    ///
    /// # Errors
    /// When the tile cannot be looked at.
    fn outline(&self, _index: u32) -> Result<Option<TileOutline>, Error> {
        Ok(None)
    }
    /// Whether tiles are read, not traced, which takes several times as long.
    fn is_recorded(&self) -> bool {
        false
    }
    /// Traversals so far that their loop bound ended.
    fn stalls(&self) -> u64;
}

/// What is known of a tile before it is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileOutline {
    /// Bytes that its rays take in a trace: nearly proportional to their steps.
    pub bytes: u64,
    /// Bytes that are left of these when what repeats is left out: the more, the less its rays have in common.
    pub compressed_bytes: u64,
}
