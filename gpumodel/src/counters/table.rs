//! The one table of counters: reports, lists and documentation are made from it.

/// What a counter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CounterInfo {
    /// Canonical id, the key in reports.
    pub id: &'static str,
    /// Name as a profiler would show it.
    pub name: &'static str,
    /// Group in a profiler's list.
    pub group: &'static str,
    /// Unit of the value.
    pub unit: &'static str,
    /// How it is computed.
    pub formula: &'static str,
    /// What it is per, or a share of; empty for a plain amount.
    pub denominator: &'static str,
}

const fn row(
    id: &'static str,
    name: &'static str,
    group: &'static str,
    unit: &'static str,
    formula: &'static str,
    denominator: &'static str,
) -> CounterInfo {
    CounterInfo { id, name, group, unit, formula, denominator }
}

const GENERAL: &str = "General";
const RAYS: &str = "Ray Tracing";
const SHADERS: &str = "Shader Processing";
const MEMORY: &str = "Memory Stats";
const CACHES: &str = "Caches";
const STALLS: &str = "Stalls";
const ENERGY: &str = "Energy";

/// All counters, in the order of reports.
pub const COUNTERS: &[CounterInfo] = &[
    row(
        "frame_time_ms",
        "Frame Time",
        GENERAL,
        "ms",
        "sum over the phases of the frame of the largest bound of each",
        "",
    ),
    row("fps", "Frames / Second", GENERAL, "1/s", "1 / frame time", "second"),
    row("rays", "Rays", RAYS, "rays", "rays traced, primary and shadow", ""),
    row("mrays_per_second", "Mrays / Second", RAYS, "Mrays/s", "rays / frame time / 10^6", "second"),
    row("structure_nodes", "Structure Nodes", RAYS, "nodes", "nodes of the tree", ""),
    row("structure_bytes", "Structure Bytes", RAYS, "B", "nodes x bytes of a node record", ""),
    row(
        "node_fetches",
        "Node Fetches",
        RAYS,
        "fetches",
        "node records read from their buffer, ancestors read again included",
        "",
    ),
    row("node_fetches_per_ray", "Node Fetches / Ray", RAYS, "fetches", "node fetches / rays", "ray"),
    row(
        "node_fetches_per_pixel",
        "Node Fetches / Pixel",
        RAYS,
        "fetches",
        "node fetches / pixels of the frame",
        "pixel",
    ),
    row("primitive_tests", "Primitive Tests", RAYS, "tests", "ray-triangle tests", ""),
    row("primitive_tests_per_ray", "Primitive Tests / Ray", RAYS, "tests", "primitive tests / rays", "ray"),
    row(
        "restarts",
        "Restarts",
        RAYS,
        "restarts",
        "times that a traversal began again above the node it had reached",
        "",
    ),
    row("fragments", "Fragments", SHADERS, "fragments", "pixels of the frame, or rays of a list", ""),
    row("warps", "Warps", SHADERS, "warps", "warps run, of all passes", ""),
    row(
        "vertices",
        "Vertices",
        SHADERS,
        "vertices",
        "vertices fetched and transformed, for binning and for every bin",
        "",
    ),
    row(
        "alu_operations",
        "ALU Operations",
        SHADERS,
        "ops",
        "full-precision scalar operations of active lanes; EFU excluded",
        "",
    ),
    row(
        "alu_operations_issued",
        "ALU Operations Issued",
        SHADERS,
        "ops",
        "operations of warp instructions x warp width; EFU excluded",
        "",
    ),
    row("efu_operations", "EFU Operations", SHADERS, "ops", "elementary functions of active lanes", ""),
    row(
        "efu_operations_issued",
        "EFU Operations Issued",
        SHADERS,
        "ops",
        "elementary functions of warp instructions x warp width",
        "",
    ),
    row(
        "memory_instructions",
        "Memory Instructions",
        SHADERS,
        "instructions",
        "loads and stores issued by warps",
        "",
    ),
    row(
        "load_store_cycles",
        "Load/Store Cycles",
        SHADERS,
        "cycles",
        "per load or store of a warp the larger of its lines and its bytes / port width, summed over the cores",
        "",
    ),
    row(
        "alu_per_fragment",
        "ALU / Fragment",
        SHADERS,
        "ops",
        "full-precision scalar operations of active lanes / fragments; EFU excluded",
        "fragment",
    ),
    row(
        "alu_issued_per_fragment",
        "ALU Issued / Fragment",
        SHADERS,
        "ops",
        "operations of warp instructions x warp width / fragments; EFU excluded",
        "fragment",
    ),
    row(
        "efu_per_fragment",
        "EFU / Fragment",
        SHADERS,
        "ops",
        "elementary functions of active lanes / fragments",
        "fragment",
    ),
    row(
        "simt_efficiency",
        "SIMT Efficiency",
        SHADERS,
        "ratio",
        "ALU operations of active lanes / ALU operations issued",
        "issued operations",
    ),
    row(
        "occupancy",
        "Wave Context Occupancy",
        SHADERS,
        "ratio",
        "resident warps, mean over ticks of issue / (cores x warp slots)",
        "warp slots",
    ),
    row(
        "sp_memory_read_bytes",
        "SP Memory Read",
        MEMORY,
        "B",
        "bytes that shader loads of buffers and private memory read from memory, past every cache, as UCHE_VBIF_READ_BEATS_SP x 32 (Mesa fd_pps_driver.cc)",
        "",
    ),
    row(
        "sp_memory_read_bytes_per_second",
        "SP Memory Read (Bytes/Second)",
        MEMORY,
        "B/s",
        "SP memory read / frame time",
        "second",
    ),
    row(
        "texture_memory_read_bytes",
        "Texture Memory Read",
        MEMORY,
        "B",
        "bytes that texture reads of images read from memory, past every cache",
        "",
    ),
    row(
        "vertex_memory_read_bytes",
        "Vertex Memory Read",
        MEMORY,
        "B",
        "bytes that vertex fetch, for binning and for every bin, reads from memory, past every cache",
        "",
    ),
    row(
        "dram_read_bytes",
        "Read Total",
        MEMORY,
        "B",
        "SP, texture and vertex memory read + bin lists read",
        "",
    ),
    row(
        "dram_write_bytes",
        "Write Total",
        MEMORY,
        "B",
        "dirty lines written back x line size + tile memory written out (colour, attachments) + bin lists written",
        "",
    ),
    row(
        "l1_accesses",
        "L1 Accesses",
        CACHES,
        "accesses",
        "lines touched by loads and stores at the first level",
        "",
    ),
    row("l1_misses", "L1 Misses", CACHES, "accesses", "those not found", ""),
    row("l2_accesses", "L2 Accesses", CACHES, "accesses", "lines touched at the second level", ""),
    row("l2_misses", "L2 Misses", CACHES, "accesses", "those not found", ""),
    row(
        "load_store_l2_accesses",
        "Load/Store L2 Accesses",
        CACHES,
        "accesses",
        "lines of buffers, private memory and vertices touched at the second level",
        "",
    ),
    row("load_store_l2_misses", "Load/Store L2 Misses", CACHES, "accesses", "those not found", ""),
    row(
        "texture_l2_accesses",
        "Texture L2 Accesses",
        CACHES,
        "accesses",
        "lines of images touched at the second level",
        "",
    ),
    row("texture_l2_misses", "Texture L2 Misses", CACHES, "accesses", "those not found", ""),
    row("l1_miss_ratio", "L1 Miss Ratio", CACHES, "ratio", "L1 misses / L1 accesses", "L1 accesses"),
    row("l2_miss_ratio", "L2 Miss Ratio", CACHES, "ratio", "L2 misses / L2 accesses", "L2 accesses"),
    row(
        "shader_alu_capacity_utilized",
        "Shader ALU Capacity Utilized",
        SHADERS,
        "ratio",
        "ALU operations of active lanes / (cores x ALU lanes x clock x frame time)",
        "ALU capacity of the frame",
    ),
    row(
        "time_alus_working",
        "Time ALUs Working",
        SHADERS,
        "ratio",
        "ALU operations issued / (cores x ALU lanes x clock x frame time)",
        "frame time",
    ),
    row(
        "shaders_busy",
        "Shaders Busy",
        SHADERS,
        "ratio",
        "ticks of issue in which every core had a warp / ticks",
        "ticks of issue",
    ),
    row(
        "stalled_on_system_memory",
        "Stalled on System Memory",
        STALLS,
        "ratio",
        "cycles in which the last cache waits for DRAM / cycles",
        "cycles",
    ),
    row(
        "avg_bytes_per_fragment",
        "Avg Bytes / Fragment",
        MEMORY,
        "B",
        "bytes read from DRAM / fragments",
        "fragment",
    ),
    row("energy_mj", "Energy", ENERGY, "mJ", "counts x energy each + static power x frame time", ""),
    row("power_mw", "Power", ENERGY, "mW", "energy / frame time", "second"),
];
