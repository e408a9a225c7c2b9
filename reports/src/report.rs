//! What a report says. The field names and their nesting are the JSON form, schema 1.

use crate::counters::{Counters, Fidelity};
use crate::sustained::Sustained;
use crate::vendor::VendorView;
use crate::within::Within;
use serde::{Deserialize, Serialize};

/// Version of the JSON form. It changes when a field changes its meaning or goes; new fields keep it.
pub const SCHEMA: u32 = 1;

/// The cost of one frame on one GPU, and how it was found.
///
/// Everything but [`Report::run`] follows from the inputs alone: the same inputs give the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Program and version.
    pub tool: String,
    /// What was asked.
    pub inputs: Inputs,
    /// What the figures do not contain: what is not needed, and what is not modelled.
    pub left_out: Vec<LeftOut>,
    /// What the answer cost to find.
    pub run: Run,
    /// The whole frame.
    pub counters: Counters,
    /// The passes, in the order in which the GPU would run them.
    pub passes: Vec<Pass>,
    /// The counters as the profiler of the GPU's maker names them, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vendor: Option<VendorView>,
    /// What the frame time is made of: its parts add up to it.
    #[serde(default)]
    pub stack: Vec<TimePart>,
    /// Lower bounds of the frame time, one for each resource.
    #[serde(default)]
    pub bounds: Vec<Bound>,
    /// Name of the bound that decides the frame time.
    #[serde(default)]
    pub deciding_bound: Option<String>,
    /// What the frame's energy is made of; none where the GPU's description names no process.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<Energy>,
    /// What each kind of buffer takes and moves.
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    /// What each pass asks of each level of the memory system for each kind of buffer. The bytes to and from DRAM add up to the frame's.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub traffic: Vec<Traffic>,
    /// Which figures are estimates and what was assumed for them, in sentences.
    #[serde(default)]
    pub assumptions: Vec<String>,
    /// What was missing, assumed or noticed when the scene was loaded, in sentences.
    #[serde(default)]
    pub notes: Vec<String>,
    /// What was forced in or out against what the scene needs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forced: Vec<Forced>,
    /// What becomes of the frame rate on a phone that warms, where that was asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sustained: Option<Sustained>,
}

/// What was asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Scene.
    pub scene: String,
    /// GPU.
    pub gpu: String,
    /// Kind of acceleration structure.
    pub accel: String,
    /// Traversal.
    pub traversal: String,
    /// Primitive layout.
    pub layout: String,
    /// Technique.
    pub technique: String,
    /// Order of the triangles in memory.
    #[serde(default)]
    pub primitive_order: String,
    /// What node records hold.
    #[serde(default)]
    pub node_records: String,
    /// Order of the nodes in memory.
    #[serde(default)]
    pub node_order: String,
    /// How the ray unit that walks the structure schedules its rays; none where shaders walk it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ray_unit: Option<String>,
    /// Pixels per row; none for a list of rays.
    pub width: Option<u32>,
    /// Rows of pixels; none for a list of rays.
    pub height: Option<u32>,
    /// Start of the random sequence; none where nothing is random.
    pub seed: Option<u64>,
    /// Hashes of what the names above stand for.
    pub hashes: Hashes,
    /// Triangles of the scene.
    pub triangles: u32,
    /// Ray sets, in the order in which a pixel casts them.
    pub ray_sets: Vec<String>,
    /// Rays of a pixel in each set that is drawn at random, where it has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples_per_pixel: Option<u32>,
    /// What shadow rays ask for, where it is not any hit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shadow_query: Option<String>,
    /// SAH costs Ct and Ci of the build.
    pub sah_costs: [f64; 2],
    /// Entries of a short stack in registers; 0 without one.
    pub short_stack: u32,
    /// Bits of the restart trail, where there is one.
    pub trail_bits: Option<u32>,
    /// What the nodes of a wide BVH hold; none for any other structure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node_format: Option<String>,
}

/// Xxh3 hashes (64 bits, 16 hexadecimal digits).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hashes {
    /// Of the scene's triangles, camera and lights.
    pub scene: String,
    /// Of the text of the GPU's description.
    pub gpu: String,
    /// Of the text of the table of shader costs.
    pub costs: String,
    /// Of the text of the table of energies; nothing in reports of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<String>,
}

/// One thing that the figures do not contain.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOut {
    /// What.
    pub what: String,
    /// Why, and how much it touches.
    pub why: String,
}

/// A feature that was forced in or out, and what it costs or saves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Forced {
    /// Which.
    pub what: String,
    /// Which way: `in` or `out`.
    pub choice: String,
    /// Time of the frame that it takes, or about would take; none where one run does not tell.
    pub frame_time_ms: Option<f64>,
    /// Bytes that it takes, or would take, in buffers.
    pub buffer_bytes: u64,
    /// Bytes that it reads from memory; none where one run does not tell.
    pub dram_read_bytes: Option<u64>,
    /// The same in a sentence.
    pub cost: String,
}

/// What the answer cost to find. The only part of a report that differs from run to run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Wall time of the whole run, in seconds.
    pub wall_s: f64,
    /// Most memory that the process held, where the system tells.
    pub peak_rss_bytes: Option<u64>,
    /// Rung of the ladder of fidelity.
    pub fidelity: Fidelity,
    /// Part of the tiles that was replayed, those among them that only filled cores and caches; from 0 to 1.
    pub sampled_fraction: f64,
    /// Worker threads.
    pub threads: u32,
    /// Wall time for loading the scene or opening the trace, in seconds.
    #[serde(default)]
    pub load_s: f64,
    /// Wall time for building the structure, in seconds; none for a replay of a file.
    #[serde(default)]
    pub build_s: Option<f64>,
    /// Wall time for tracing and replaying together, in seconds.
    #[serde(default)]
    pub replay_s: f64,
    /// How far the figures may be from those of a more faithful rung; nothing in reports of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Within>,
}

/// One pass of the frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// Its name.
    pub name: String,
    /// Its counters.
    pub counters: Counters,
}

/// What the buffers of one kind take and move in the whole frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Buffer {
    /// What they hold.
    pub name: String,
    /// Bytes that they take.
    pub bytes: u64,
    /// Lines touched in the first cache of their path.
    pub line_accesses: u64,
    /// Lines not found in the last one.
    pub line_misses: u64,
    /// Bytes read from memory.
    pub dram_read_bytes: u64,
    /// Bytes written to memory by lines that these accesses drove out.
    pub dram_write_bytes: u64,
}

/// What one pass moves for one kind of buffer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Traffic {
    /// The pass.
    pub pass: String,
    /// What the buffers hold.
    pub buffer: String,
    /// The caches that were asked, from the cores to memory.
    pub levels: Vec<LevelTraffic>,
    /// Bytes read from memory.
    pub dram_read_bytes: u64,
    /// Bytes written to memory by lines that these accesses drove out, whoever wrote them.
    pub dram_write_bytes: u64,
}

/// What was asked of one cache.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LevelTraffic {
    /// The cache.
    pub name: String,
    /// What counters call it: `l1`, `cluster`, `l2` or `slc`; nothing in reports of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// Lines asked for.
    pub lines: u64,
    /// Of these, lines that it did not have.
    pub missed: u64,
    /// Bytes of the lines asked for.
    pub bytes: u64,
}

/// A part of the frame time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimePart {
    /// What warps use or wait for.
    pub name: String,
    /// The time, in seconds.
    pub seconds: f64,
}

/// What the frame's energy is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Process of the chip.
    pub process: String,
    /// Supply voltage of the GPU at which the figures hold.
    pub volts: f64,
    /// Where that is from: the GPU's `operating points`, or its `process` where it has none with a voltage.
    pub volts_from: String,
    /// Temperature of the chip at which its leakage holds, in degrees Celsius.
    pub celsius: f64,
    /// What takes it; their energies add up to the frame's.
    pub causes: Vec<EnergyCause>,
}

/// What one cause takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnergyCause {
    /// What takes it.
    pub cause: String,
    /// Its energy in millijoules.
    pub mj: f64,
    /// Its part of the frame's, from 0 to 1.
    pub share: f64,
    /// Whose supply it comes from: that of the GPU, the system cache, the DRAM, or leakage of the GPU.
    pub domain: String,
    /// What is inside of the figure.
    pub boundary: String,
    /// How far the figure can be trusted.
    pub tag: String,
}

/// The least time that one resource needs for the frame's work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// The resource.
    pub name: String,
    /// The time, in seconds.
    pub seconds: f64,
}

impl Report {
    /// Whether its figures are of a sample of the frame.
    pub fn is_sampled(&self) -> bool {
        self.run.fidelity == Fidelity::Sampled
    }

    /// The pass called `name`.
    pub fn pass(&self, name: &str) -> Option<&Pass> {
        self.passes.iter().find(|pass| pass.name == name)
    }
}
