//! The whole numbers of a frame, by pass, buffer and cache level.

use crate::layout::BufferKind;
use cachesim::{LevelServed, MAX_LEVELS};
use std::ops::AddAssign;

/// Declares a struct of `u64` counters that add up field by field.
macro_rules! counters {
    ($(#[$doc:meta])* pub struct $name:ident { $($(#[$field_doc:meta])* pub $field:ident: $type:ty,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $name { $($(#[$field_doc])* pub $field: $type,)* }

        impl AddAssign for $name {
            fn add_assign(&mut self, other: Self) {
                let Self { $($field),* } = other;
                $(self.$field += $field;)*
            }
        }
    };
}

counters! {
    /// What the lanes and the issue slots of a pass did, before any cache.
    pub struct IssueCounters {
        /// Rays traced.
        pub rays: u64,
        /// Steps of single lanes.
        pub lane_steps: u64,
        /// Steps of whole warps: of one kind, by all lanes whose turn it is.
        pub warp_steps: u64,
        /// Node records read: once or twice per node step (see [`tracer::NodeFetch`]), once per step up.
        pub node_fetches: u64,
        /// Ray-triangle tests.
        pub primitive_tests: u64,
        /// Restarts.
        pub restarts: u64,
        /// Stack entries written.
        pub pushes: u64,
        /// Stack entries taken.
        pub pops: u64,
        /// Hits shaded.
        pub shaded: u64,
        /// ALU operations of the lanes that needed them.
        pub alu_active: u64,
        /// ALU operations of all lanes of every warp that issued them, idle ones included.
        pub alu_issued: u64,
        /// As `alu_active`, of the elementary function unit.
        pub efu_active: u64,
        /// As `alu_issued`, of the elementary function unit.
        pub efu_issued: u64,
        /// Loads and stores issued by warps.
        pub memory_instructions: u64,
        /// Times that a warp waits for loads: those of one record are in flight together.
        pub memory_waits: u64,
        /// Lines touched: the distinct lines of each load and store.
        pub line_accesses: u64,
        /// Those of loads.
        pub lines_read: u64,
        /// Bytes that lanes loaded and stored.
        pub lane_bytes: u64,
        /// Cycles of a core's load/store port: per load or store the larger of its lines and its bytes by the port's width.
        pub load_store_cycles: u64,
        /// Bytes of colour written.
        pub output_bytes: u64,
    }
}

counters! {
    /// How full the cores were. A tick lets every core that has a warp issue the memory step of one.
    pub struct ScheduleCounters {
        /// Ticks.
        pub ticks: u64,
        /// Ticks in which every core had a warp.
        pub full_ticks: u64,
        /// Resident warps, summed over ticks.
        pub warp_ticks: u64,
        /// Warps run.
        pub warps: u64,
    }
}

/// What a buffer's accesses caused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BufferTraffic {
    /// By index into [`Gpu::caches`](crate::Gpu::caches).
    pub levels: [LevelServed; MAX_LEVELS],
    /// Bytes read from memory.
    pub dram_read_bytes: u64,
    /// Bytes written to memory: dirty lines that these accesses evicted, whoever wrote them.
    pub dram_write_bytes: u64,
}

impl AddAssign for BufferTraffic {
    fn add_assign(&mut self, other: Self) {
        let Self { levels, dram_read_bytes, dram_write_bytes } = other;
        for (sum, LevelServed { accesses, misses }) in self.levels.iter_mut().zip(levels) {
            sum.accesses += accesses;
            sum.misses += misses;
        }
        self.dram_read_bytes += dram_read_bytes;
        self.dram_write_bytes += dram_write_bytes;
    }
}

counters! {
    /// Traffic by what the buffer holds.
    pub struct TrafficCounters {
        /// Node records.
        pub node: BufferTraffic,
        /// Triangles, for intersection.
        pub primitive: BufferTraffic,
        /// Index lists of a kd-tree's leaves.
        pub index: BufferTraffic,
        /// Triangles, for shading.
        pub normal: BufferTraffic,
        /// Stacks in memory.
        pub stack: BufferTraffic,
    }
}

impl TrafficCounters {
    /// All buffers together.
    pub fn total(&self) -> BufferTraffic {
        let Self { node, primitive, index, normal, stack } = *self;
        let mut total = BufferTraffic::default();
        [node, primitive, index, normal, stack].into_iter().for_each(|traffic| total += traffic);
        total
    }

    pub(crate) fn of_mut(&mut self, kind: BufferKind) -> &mut BufferTraffic {
        match kind {
            BufferKind::Node => &mut self.node,
            BufferKind::Primitive => &mut self.primitive,
            BufferKind::Index => &mut self.index,
            BufferKind::Normal => &mut self.normal,
            BufferKind::Stack => &mut self.stack,
        }
    }
}

counters! {
    /// One part of the frame's shader.
    pub struct PassCounters {
        /// Before the caches.
        pub issue: IssueCounters,
        /// In the caches and memory.
        pub traffic: TrafficCounters,
    }
}

counters! {
    /// A frame.
    pub struct FrameCounters {
        /// Making and tracing primary rays.
        pub primary: PassCounters,
        /// Making and tracing shadow rays.
        pub shadow: PassCounters,
        /// Shading hits and writing the colour.
        pub output: PassCounters,
        /// Dirty lines written back after the last access.
        pub flush: BufferTraffic,
        /// How full the cores were.
        pub schedule: ScheduleCounters,
        /// Traversals ended by their loop bound.
        pub stalls: u64,
    }
}

impl FrameCounters {
    /// Names of the passes, in the order of [`Self::passes`].
    pub const PASSES: [&'static str; 3] = ["primary rays", "shadow rays", "output"];

    /// The passes, in the order in which a fragment goes through them; shading and output are one.
    pub fn passes(&self) -> [&PassCounters; 3] {
        [&self.primary, &self.shadow, &self.output]
    }

    /// All passes together; the write-back after the last access is the stacks'.
    pub fn total(&self) -> PassCounters {
        let mut total = PassCounters::default();
        self.passes().into_iter().for_each(|pass| total += *pass);
        total.traffic.stack += self.flush;
        total
    }
}

/// A number per pixel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HeatMap {
    /// Pixels per row; for a list of rays their number.
    pub width: u32,
    /// Rows; 1 for a list of rays.
    pub height: u32,
    /// Row by row from the top left.
    pub values: Vec<u32>,
}
