//! Acceleration structures and instrumented traversals that record what each ray visits.
//!
//! This crate knows no address, cache or clock: a trace says *what* was visited, never where it lay in memory.

mod aabb;
mod accel;
mod alpha;
pub mod audit;
pub mod bvh;
mod caster;
mod error;
pub mod grid;
pub mod kd;
mod leaf;
mod observe;
mod plane_ray;
mod raster;
mod ray;
mod ray_file;
mod ray_sample;
mod ray_set;
pub mod reflections;
mod sampling;
mod secondary;
pub mod stereo;
mod topology;
mod trace;
mod trace_file;
mod tracing;
mod tree;
mod triangle;
pub mod two_level;
mod view;
pub mod wide;

pub use aabb::{Aabb, PlaneSlack, SlabRay};
pub use accel::{Accel, AccelerationStructure, BuildOptions, LeafCounts, StackUse, Traversal};
pub use alpha::{
    AlphaMode, AlphaTests, Micromap, MicromapFormat, MicromapStates, RayQuery, TestedTriangles, fence,
};
pub use error::Error;
pub use observe::{DECIDED_BY_MICROMAP, LoopStructure, NodeFetch, Observer, Op, Silent, Work, WorkCounter};
pub use raster::{Raster, RasterTile, TileDraw};
pub use ray::{Hit, NO_HIT, NOT_CAST, Query, Ray};
pub use ray_file::{RAY_BYTES, read_rays};
pub use ray_sample::{RaySample, SampledRay, Sampling};
pub use ray_set::{MAX_RAY_SETS, RayKind, RaySetId};
pub use scenes::Feature;
pub use secondary::{ReflectionRays, SecondaryRays, SoftShadows};
pub use topology::{Topology, TopologyNode};
pub use trace::{
    Choice, Forced, Frame, MAX_TILE_STEPS, Omission, RayLine, RaySet, Recorder, ReflectionRecord,
    SceneRemarks, Step, TILE_EDGE, TILE_RAYS, Tile, TileOutline, TileRect, TileSource, TraceHeader,
};
pub use trace_file::{EncodedTile, MOST_SHADERS, TraceFile, TraceWriter};
pub use tracing::{FrameTracer, Rays, SceneIdentity};
pub use triangle::{PreparedTriangle, RayTriangle, TriangleTest, WatertightTriangle};
pub use view::{Departure, RayOffset, View};
