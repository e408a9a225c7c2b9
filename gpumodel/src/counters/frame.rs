//! The whole numbers of a frame, by pass, buffer and cache level.

use crate::layout::BufferKind;
use cachesim::{LevelServed, MAX_LEVELS};
use std::ops::{AddAssign, Sub};
use tracer::RayKind;

/// Whole numbers that add up one by one.
pub(crate) trait Numbers {
    /// Shows each to `visit`, always in the same order.
    fn each(&mut self, visit: &mut dyn FnMut(&mut u64));
}

impl Numbers for u64 {
    fn each(&mut self, visit: &mut dyn FnMut(&mut u64)) {
        visit(self);
    }
}

impl Numbers for LevelServed {
    fn each(&mut self, visit: &mut dyn FnMut(&mut u64)) {
        let Self { accesses, misses } = self;
        visit(accesses);
        visit(misses);
    }
}

impl<T: Numbers, const COUNT: usize> Numbers for [T; COUNT] {
    fn each(&mut self, visit: &mut dyn FnMut(&mut u64)) {
        self.iter_mut().for_each(|numbers| numbers.each(visit));
    }
}

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

        impl Numbers for $name {
            fn each(&mut self, visit: &mut dyn FnMut(&mut u64)) {
                let Self { $($field),* } = self;
                $($field.each(visit);)*
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
        /// Node steps of single lanes: one for a pair of siblings.
        pub node_steps: u64,
        /// Steps of single lanes to an ancestor.
        pub up_steps: u64,
        /// Of `alu_active`, operations of node steps, address arithmetic of their loads among them.
        pub node_alu: u64,
        /// Of `alu_active`, operations of triangle tests.
        pub primitive_alu: u64,
        /// Node records read: once or twice per node step (see [`tracer::NodeFetch`]), once per step up.
        pub node_fetches: u64,
        /// Ray-triangle tests.
        pub primitive_tests: u64,
        /// Hits that the traversal does not decide about: those of triangles that are not marked opaque.
        pub non_opaque_hits: u64,
        /// Of these, those that any-hit shaders decided about.
        pub any_hits: u64,
        /// Times that a ray unit handed a warp back to its shader, for hits to decide about.
        pub unit_returns: u64,
        /// Rays that went on from there.
        pub resumed_rays: u64,
        /// Node steps of single lanes in the TLAS of two levels.
        pub tlas_steps: u64,
        /// Records of instances that single lanes read, to go into the BLAS.
        pub instances: u64,
        /// Restarts.
        pub restarts: u64,
        /// Stack entries written.
        pub pushes: u64,
        /// Stack entries taken.
        pub pops: u64,
        /// Box nodes that a ray unit tested: once for all rays of a warp that are at one together, or for each ray.
        pub box_nodes: u64,
        /// Of these, those with rays in up to a quarter of a warp's lanes.
        pub box_nodes_quarter: u64,
        /// In more lanes, up to half.
        pub box_nodes_half: u64,
        /// In more lanes, up to three quarters.
        pub box_nodes_three_quarters: u64,
        /// In more lanes.
        pub box_nodes_full: u64,
        /// As `box_nodes`, of triangles.
        pub triangle_nodes: u64,
        /// As `box_nodes_quarter`.
        pub triangle_nodes_quarter: u64,
        /// As `box_nodes_half`.
        pub triangle_nodes_half: u64,
        /// As `box_nodes_three_quarters`.
        pub triangle_nodes_three_quarters: u64,
        /// As `box_nodes_full`.
        pub triangle_nodes_full: u64,
        /// Ray-box tests of a ray unit.
        pub unit_box_tests: u64,
        /// Of `unit_box_tests`, those of boxes of a TLAS.
        pub unit_tlas_boxes: u64,
        /// As `unit_box_tests`, with the places for rays that stayed empty.
        pub unit_box_places: u64,
        /// As `unit_box_places`, of triangles.
        pub unit_triangle_places: u64,
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
        /// Turns of warps: each ends in loads and stores, after which the warp waits or lets others go first.
        pub turns: u64,
        /// Loads and stores issued by warps.
        pub memory_instructions: u64,
        /// Times that a warp waits for loads: those of one record are in flight together.
        pub memory_waits: u64,
        /// Lines asked for: the distinct lines of each load and store, loads that touch the same lines once.
        pub line_requests: u64,
        /// Lines touched: the distinct lines of each load and store.
        pub line_accesses: u64,
        /// Bytes that lanes loaded and stored; lines that a ray unit fetches are not among them.
        pub lane_bytes: u64,
        /// Cycles of a core's load/store port: per load or store the larger of its lines and its bytes by the port's width.
        pub load_store_cycles: u64,
        /// Lines through the ports of ray units that have a cache of their own.
        pub unit_port_lines: u64,
        /// Bytes of tile memory written out to DRAM: the colour, and attachments that leave the tile.
        pub output_bytes: u64,
        /// Bytes that kernels load from and store to the GPU's internal memory.
        pub internal_bytes: u64,
        /// Bytes that DMA writes from internal memory to DRAM.
        pub dma_write_bytes: u64,
        /// Bytes that DMA reads from DRAM into internal memory.
        pub dma_read_bytes: u64,
        /// Transfers by which it reads them.
        pub dma_reads: u64,
        /// Vertices fetched and transformed.
        pub vertices: u64,
        /// Triangles that went through triangle setup.
        pub setup_triangles: u64,
        /// Fragments that a rasteriser found covered, hidden ones included.
        pub covered_fragments: u64,
        /// Bytes of bin lists written and read.
        pub bin_list_bytes: u64,
        /// Atomic operations on counters in memory, lane by lane unless a warp joins them.
        pub atomics: u64,
        /// Clocks that these take one after the other, where the cache that all cores share carries them out.
        pub atomic_clocks: u64,
        /// Compute dispatches, those of no workgroup among them.
        pub dispatches: u64,
        /// Shaders of a ray-tracing pipeline that warps called.
        pub shader_calls: u64,
    }
}

counters! {
    /// How full the cores were. In a tick as many turns are issued as there are cores with warps.
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

impl Numbers for BufferTraffic {
    fn each(&mut self, visit: &mut dyn FnMut(&mut u64)) {
        let Self { levels, dram_read_bytes, dram_write_bytes } = self;
        levels.each(visit);
        visit(dram_read_bytes);
        visit(dram_write_bytes);
    }
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
        /// Triangles, for intersection, and for shading unless normals are apart.
        pub primitive: BufferTraffic,
        /// Index lists of a kd-tree's leaves.
        pub index: BufferTraffic,
        /// Normals in a buffer of their own.
        pub normal: BufferTraffic,
        /// Stacks in memory.
        pub stack: BufferTraffic,
        /// Vertices for rasterisation.
        pub vertex: BufferTraffic,
        /// Images and attachments that one pass writes and another reads.
        pub image: BufferTraffic,
        /// Rays, hits and their orders, which one compute pass lists for another.
        pub record: BufferTraffic,
    }
}

impl TrafficCounters {
    /// All buffers together.
    pub fn total(&self) -> BufferTraffic {
        let Self { node, primitive, index, normal, stack, vertex, image, record } = *self;
        let mut total = BufferTraffic::default();
        [node, primitive, index, normal, stack, vertex, image, record]
            .into_iter()
            .for_each(|traffic| total += traffic);
        total
    }

    /// What reports call the kinds of buffers, and the traffic of each.
    pub(crate) fn named(&self) -> [(&'static str, BufferTraffic); 8] {
        let Self { node, primitive, index, normal, stack, vertex, image, record } = *self;
        [
            ("nodes", node),
            ("triangles", primitive),
            ("triangle indices", index),
            ("normals", normal),
            ("stacks", stack),
            ("vertices", vertex),
            ("images", image),
            ("records", record),
        ]
    }

    pub(crate) fn each_buffer(&mut self, visit: impl FnMut(&mut BufferTraffic)) {
        let Self { node, primitive, index, normal, stack, vertex, image, record } = self;
        [node, primitive, index, normal, stack, vertex, image, record].into_iter().for_each(visit);
    }

    pub(crate) fn of_mut(&mut self, kind: BufferKind) -> &mut BufferTraffic {
        match kind {
            BufferKind::Node => &mut self.node,
            BufferKind::Primitive => &mut self.primitive,
            BufferKind::Index => &mut self.index,
            BufferKind::Normal => &mut self.normal,
            BufferKind::Stack => &mut self.stack,
            BufferKind::Vertex => &mut self.vertex,
            BufferKind::Image | BufferKind::Attachment => &mut self.image,
            BufferKind::Record | BufferKind::Counter => &mut self.record,
        }
    }
}

/// Where turns found their lines. A sample of turns, evenly spread over the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WaitCounters {
    /// Turns that wait for loads, by index into [`Gpu::caches`](crate::Gpu::caches) of the cache that had the farthest of their lines;
    /// the last one is memory.
    pub from: [u64; MAX_LEVELS + 1],
    /// Turns that were looked at.
    pub turns: u64,
    /// Lines that they had on their way to the core: those that no cache of its own had.
    pub lines: u64,
    /// Squares of these, turn by turn.
    pub squares: u64,
}

impl AddAssign for WaitCounters {
    fn add_assign(&mut self, other: Self) {
        let Self { from, turns, lines, squares } = other;
        self.from.iter_mut().zip(from).for_each(|(sum, from)| *sum += from);
        self.turns += turns;
        self.lines += lines;
        self.squares += squares;
    }
}

impl Numbers for WaitCounters {
    fn each(&mut self, visit: &mut dyn FnMut(&mut u64)) {
        let Self { from, turns, lines, squares } = self;
        from.each(visit);
        [turns, lines, squares].into_iter().for_each(visit);
    }
}

impl Sub for WaitCounters {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        let Self { from, turns, lines, squares } = other;
        Self {
            from: std::array::from_fn(|level| self.from[level] - from[level]),
            turns: self.turns - turns,
            lines: self.lines - lines,
            squares: self.squares - squares,
        }
    }
}

counters! {
    /// One pass of the frame.
    pub struct PassCounters {
        /// Before the caches.
        pub issue: IssueCounters,
        /// In the caches and memory.
        pub traffic: TrafficCounters,
    }
}

/// A pass, or the part of one that belongs to one kind of ray. Which of them a frame has is its
/// [`Technique`](crate::Technique)'s to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Pass {
    /// Positions of all vertices, to sort triangles into bins.
    Binning = 0,
    /// Rasterising the geometry, bin by bin.
    Geometry = 1,
    /// Finding which pixels of the right eye's image the left one answers.
    ErrorDetection = 2,
    /// Making and tracing primary rays.
    Primary = 3,
    /// Making and tracing shadow rays.
    Shadow = 4,
    /// Making and tracing rays to points of lights.
    SoftShadow = 5,
    /// Marching reflection rays through the depth buffer, and listing those that are left.
    ScreenSpace = 6,
    /// Making and tracing reflection rays, and shading what they hit where no pass of its own does.
    Reflection = 7,
    /// Counting the hits of each material.
    BucketCount = 8,
    /// Finding where the hits of each material begin.
    BucketOffset = 9,
    /// Listing hits by material.
    BucketCopy = 10,
    /// Shading hits material by material.
    HitShading = 11,
    /// Making and tracing shadow rays from what reflection rays hit.
    ReflectionShadow = 12,
    /// Making and tracing rays of ambient occlusion.
    AmbientOcclusion = 13,
    /// Making and tracing diffuse rays, and shading what they hit.
    Diffuse = 14,
    /// Making and tracing shadow rays from what those hit.
    DiffuseShadow = 15,
    /// Shading primary hits, those that another eye's image answers among them, and writing the colour.
    Output = 16,
    /// Finding where the right eye sees what the left one has hit.
    Reprojection = 17,
    /// Drawing the image of a compute pass onto the screen.
    Present = 18,
}

impl Pass {
    /// Number of passes.
    pub const COUNT: usize = 19;

    /// All passes, in the order in which the GPU runs them.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Binning,
        Self::Geometry,
        Self::ErrorDetection,
        Self::Primary,
        Self::Shadow,
        Self::SoftShadow,
        Self::ScreenSpace,
        Self::Reflection,
        Self::BucketCount,
        Self::BucketOffset,
        Self::BucketCopy,
        Self::HitShading,
        Self::ReflectionShadow,
        Self::AmbientOcclusion,
        Self::Diffuse,
        Self::DiffuseShadow,
        Self::Output,
        Self::Reprojection,
        Self::Present,
    ];

    /// The pass that rays of a kind belong to.
    pub fn of(kind: RayKind) -> Self {
        match kind {
            RayKind::Primary => Self::Primary,
            RayKind::Shadow => Self::Shadow,
            RayKind::SoftShadow => Self::SoftShadow,
            RayKind::Reflection => Self::Reflection,
            RayKind::ReflectionShadow => Self::ReflectionShadow,
            RayKind::AmbientOcclusion => Self::AmbientOcclusion,
            RayKind::Diffuse => Self::Diffuse,
            RayKind::DiffuseShadow => Self::DiffuseShadow,
        }
    }

    /// The kind of ray that it traces.
    pub fn rays(self) -> Option<RayKind> {
        RayKind::ALL.into_iter().find(|&kind| Self::of(kind) == self)
    }

    /// Whether its rays walk the acceleration structure.
    pub fn traces(self) -> bool {
        match self {
            Self::Primary
            | Self::Shadow
            | Self::SoftShadow
            | Self::Reflection
            | Self::ReflectionShadow
            | Self::AmbientOcclusion
            | Self::Diffuse
            | Self::DiffuseShadow => true,
            Self::Binning
            | Self::Geometry
            | Self::ErrorDetection
            | Self::ScreenSpace
            | Self::BucketCount
            | Self::BucketOffset
            | Self::BucketCopy
            | Self::HitShading
            | Self::Output
            | Self::Reprojection
            | Self::Present => false,
        }
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Binning => "binning",
            Self::Geometry => "geometry",
            Self::ErrorDetection => "reprojection errors",
            Self::Primary => "primary rays",
            Self::Shadow => "shadow rays",
            Self::SoftShadow => "soft shadow rays",
            Self::ScreenSpace => "screen-space march",
            Self::Reflection => "reflection rays",
            Self::BucketCount => "bucket count",
            Self::BucketOffset => "bucket offset",
            Self::BucketCopy => "bucket copy",
            Self::HitShading => "hit shading",
            Self::ReflectionShadow => "reflection shadow rays",
            Self::AmbientOcclusion => "ambient occlusion rays",
            Self::Diffuse => "diffuse rays",
            Self::DiffuseShadow => "diffuse shadow rays",
            Self::Output => "output",
            Self::Reprojection => "reprojection",
            Self::Present => "present",
        }
    }
}

/// A frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameCounters {
    /// By [`Pass`]; those that the frame does not have are zero.
    pub passes: [PassCounters; Pass::COUNT],
    /// Dirty lines written back after the last access.
    pub flush: BufferTraffic,
    /// How full the cores were.
    pub schedule: ScheduleCounters,
    /// Traversals ended by their loop bound.
    pub stalls: u64,
    /// Shaders of the scene's materials, hit or not, in a frame of reflections; 0 in others.
    pub materials: u32,
}

impl FrameCounters {
    /// One pass.
    pub fn pass(&self, pass: Pass) -> &PassCounters {
        &self.passes[pass as usize]
    }

    /// All passes together; the write-back after the last access is the stacks'.
    pub fn total(&self) -> PassCounters {
        let mut total = PassCounters::default();
        self.passes.into_iter().for_each(|pass| total += pass);
        total.traffic.stack += self.flush;
        total
    }
}
