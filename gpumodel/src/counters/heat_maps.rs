//! What each pixel of a frame cost.

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

/// What each pixel of a frame cost.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HeatMaps {
    /// Node records read, by all rays of the pixel.
    pub node_fetches: HeatMap,
    /// Bytes of node records and triangles that the pixel's rays loaded while they were traced.
    pub loaded_bytes: HeatMap,
    /// Lines read from DRAM by the pixel's warp: the same for all pixels of a warp, which share their lines.
    pub warp_misses: HeatMap,
    /// Of the slots of the lanes of the pixel's warp, steps times lanes with a ray, those in which a lane waited for others, in per cent, all its rays
    /// together: 0 where all go the same way, or none is traced. No map where a ray unit takes each ray by itself, and none of reflections, which
    /// have [`ReflectionMaps::lane_slots`](crate::reflections::ReflectionMaps::lane_slots).
    pub wasted_slots: Option<HeatMap>,
}
