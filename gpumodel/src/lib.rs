//! Replays ray traces through a described mobile GPU: layouts, warps, caches, ALU, time.
//!
//! A trace says *what* every ray visited; here, and only here, a node number becomes an address. [`replay`] runs the
//! lanes of a frame in lockstep through the caches of a [`Gpu`] and counts in whole numbers; [`estimate`] turns the counts
//! into time and into the [`COUNTERS`] of a profiler. The same inputs give the same bytes on any number of threads.

#[cfg(test)]
mod alpha_tests;
#[cfg(test)]
mod closed_forms;
mod config;
mod counters;
mod dispatch;
pub mod energy;
mod engine;
mod error;
mod estimate;
mod geometry;
mod interleave;
pub mod kernel;
mod lanes;
mod layout;
#[cfg(test)]
mod mock;
pub mod ordering;
mod prepared;
pub mod queueing;
mod random;
#[cfg(test)]
mod ray_instruction;
#[cfg(test)]
mod ray_units;
pub mod reflections;
mod replay;
mod sampled;
mod schedule;
pub mod stereo;
mod timed;
#[cfg(test)]
mod triangle_pairs;
mod warp;
mod windows;
mod workshop;

pub use config::{
    Atomics, Attachments, Boundary, BuiltinGpu, BuiltinTechnique, CacheLevel, CacheRole, Clock, Cost, Dram,
    EnergyTable, Family, GBufferFields, GPUS, Gpu, GpuEnergy, HitShading, Identity, InternalMemory, Launch,
    LoadStore, OperatingPoint, Output, Paths, PipelineCosts, Present, Provenance, QueryOrigin, Raster,
    RayPipeline, RayQueryCosts, RayScheduling, RayUnit, ReflectionCosts, ReflectionRegisters, Reflections,
    Registers, Scheduler, ScreenSpace, SecondaryQuery, ShaderCores, ShaderCosts, SharedCosts, Stage, Stereo,
    StereoCosts, StereoLaunch, TECHNIQUES, Tag, Technique, TextureUnit, Tiler, Translation, TraversalCosts,
};
pub use counters::{
    BufferTraffic, COUNTERS, CounterInfo, CounterSet, FrameCounters, HeatMap, HeatMaps, IssueCounters, Pass,
    PassCounters, ScheduleCounters, TrafficCounters, Value, WaitCounters,
};
pub use error::Error;
pub use estimate::{
    Bound, BufferEstimate, Estimate, ForcedCost, LeftOut, LevelTraffic, PassEstimate, StackPart,
    TrafficEstimate, estimate,
};
pub use layout::{
    BufferBytes, Field, NodeLayout, NodeOrder, NodeRecords, PrimitiveLayout, PrimitiveOrder, TriangleRecords,
};
pub use replay::{Fidelity, Maps, ReplayConfig, Replayed, replay, replay_all};
pub use sampled::{Attempt, Goal, Intervals, Ratio, Sampled, Sampler, unsampled};
pub use timed::{MissRequest, TimedFrame, TimedPhase, WarpCycles};
pub use tracer::{Choice, Feature};
pub use windows::{PhaseWindows, Window};
