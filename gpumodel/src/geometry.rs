//! Rasterising the geometry: what binning and the geometry pass fetch, transform, list and write.
//!
//! A binning tiler transforms the positions of all vertices once to learn which triangles touch which bin, then, bin by bin,
//! fetches and transforms the vertices of the triangles in it again, and rasterises them into tile memory. A frame that fits into one
//! bin needs no binning pass. Vertices come through the caches; bin lists are streams that are written to DRAM and read back once.
//!
//! The draws are in the tiles of a trace, so these passes are replayed after the tiles. They share no line with the passes that
//! the GPU runs after them: either way round they find none of their lines in the caches.

use crate::config::{Attachments, Gpu, Raster, Tiler};
use crate::counters::Pass;
use crate::error::Error;
use crate::layout::{BufferKind, CORNERS, PIXEL_BYTES};
use crate::replay::ReplayConfig;
use crate::warp::{Emitter, Program, TileStreams, TreeTurns};
use std::collections::BTreeMap;
use tracer::{Frame, TILE_EDGE, TileDraw, TraceHeader};

/// Warps whose lines are handed on together.
const BATCH_WARPS: usize = 1024;

/// Width and height of a bin, by the rule of Mesa's `freedreno_gmem.c`: the larger side of the bin is divided once more, and aligned, until
/// its pixels fit into tile memory.
pub(crate) fn bin_size(width: u32, height: u32, pixel_bytes: u32, tiler: &Tiler) -> [u32; 2] {
    let [align_x, align_y] = tiler.bin_alignment;
    let (mut columns, mut rows) = (1, 1);
    let (mut bin_width, mut bin_height) = (width.next_multiple_of(align_x), height.next_multiple_of(align_y));
    let bytes = |w: u32, h: u32| u64::from(w) * u64::from(h) * u64::from(pixel_bytes);
    while bytes(bin_width, bin_height) > u64::from(tiler.tile_memory_bytes) {
        if bin_width > bin_height && bin_width > align_x {
            columns += 1;
            bin_width = width.div_ceil(columns).next_multiple_of(align_x);
        } else if bin_height > align_y {
            rows += 1;
            bin_height = height.div_ceil(rows).next_multiple_of(align_y);
        } else {
            // The smallest bin: tile memory that is smaller still is taken to hold it.
            break;
        }
    }
    [bin_width, bin_height]
}

/// What the tiles of one bin draw.
#[derive(Default)]
struct Bin {
    /// In file order, each once.
    triangles: Vec<u32>,
    covered: u64,
    passed: u64,
    quads: u64,
}

/// Size of the image that a rasteriser draws.
///
/// # Errors
/// When the trace does not say what it draws.
pub(crate) fn check(header: &TraceHeader) -> Result<[u32; 2], Error> {
    match header.frame {
        Frame::Image { width, height } if header.raster => Ok([width, height]),
        _ => Err(Error::Trace {
            scene: header.scene.clone(),
            problem: "it does not say which triangles a rasteriser draws where".to_owned(),
            remedy: "record a camera's image with this version, or use a technique that traces primary rays"
                .to_owned(),
        }),
    }
}

/// Emits binning and the geometry pass, stream by stream, each with the pass that it belongs to; `draws` are those of each tile.
///
/// # Errors
/// As [`check`].
pub(crate) fn run(
    header: &TraceHeader,
    draws: &[Vec<TileDraw>],
    config: &ReplayConfig,
    raster: Raster,
    program: &Program,
    emit: &mut dyn FnMut(Pass, TileStreams),
) -> Result<(), Error> {
    let [width, height] = check(header)?;
    let ReplayConfig { gpu, costs, .. } = config;
    // Normal and depth, and the colour where the same bin is shaded from tile memory.
    let attachments = Raster::ATTACHMENTS.len() as u32 * PIXEL_BYTES as u32;
    let pixel_bytes = match raster.attachments {
        Attachments::Tile => attachments + gpu.output.bytes_per_pixel,
        Attachments::Memory => attachments,
    };
    let bins = bins(width, height, bin_size(width, height, pixel_bytes, &gpu.tiler), draws);
    let triangles = u64::from(header.triangles);
    let list_bytes = |bin: &Bin| {
        let bits = triangles * u64::from(gpu.tiler.list_bits_per_triangle);
        bits.div_ceil(8) + bin.triangles.len() as u64 * u64::from(gpu.tiler.list_bytes_per_entry)
    };

    let mut pass = Vertices { gpu, program, emitter: Emitter::new(TreeTurns::Joined), emit };
    if bins.len() > 1 {
        let all = 0..header.triangles;
        pass.run(Pass::Binning, all, crate::config::VECTOR_BYTES, costs.shared.vertex_position);
        let issue = pass.emitter.issue(Pass::Binning);
        issue.bin_list_bytes += bins.iter().map(list_bytes).sum::<u64>();
        pass.hand_on(Pass::Binning);
    }
    let width = u64::from(gpu.cores.warp_width);
    for bin in &bins {
        pass.run(
            Pass::Geometry,
            bin.triangles.iter().copied(),
            program.buffers.vertex_stride,
            costs.shared.vertex,
        );
        let issue = pass.emitter.issue(Pass::Geometry);
        issue.covered_fragments += bin.covered;
        issue.bin_list_bytes += if bins.len() > 1 { list_bytes(bin) } else { 0 };
        let fragment_warps = (bin.quads * 4).div_ceil(width);
        program.spend(costs.shared.geometry, fragment_warps, bin.passed, issue);
        if program.keeps_turns {
            for _ in 0..fragment_warps {
                pass.emitter.spend(costs.shared.geometry);
                pass.emitter.end_warp(program);
            }
        }
        pass.hand_on(Pass::Geometry);
    }
    if raster.attachments == Attachments::Memory {
        let issue = pass.emitter.issue(Pass::Geometry);
        issue.output_bytes += header.frame.rays() * u64::from(attachments);
        pass.hand_on(Pass::Geometry);
    }
    Ok(())
}

/// Gathers the draws of tiles by the bin that the tile lies in.
fn bins(width: u32, height: u32, [bin_width, bin_height]: [u32; 2], draws: &[Vec<TileDraw>]) -> Vec<Bin> {
    let frame = Frame::Image { width, height };
    let mut bins: BTreeMap<(u32, u32), Bin> = BTreeMap::new();
    for (index, draws) in (0..).zip(draws) {
        let rect = frame.tile(index);
        debug_assert!(bin_width.is_multiple_of(TILE_EDGE) && bin_height.is_multiple_of(TILE_EDGE));
        let bin = bins.entry((rect.y / bin_height, rect.x / bin_width)).or_default();
        for draw in draws {
            bin.triangles.push(draw.triangle);
            bin.covered += u64::from(draw.covered);
            bin.passed += u64::from(draw.passed);
            bin.quads += u64::from(draw.quads);
        }
    }
    let mut bins: Vec<Bin> = bins.into_values().collect();
    for bin in &mut bins {
        bin.triangles.sort_unstable();
        bin.triangles.dedup();
    }
    bins
}

/// Fetches and transforms vertices in warps.
struct Vertices<'a> {
    gpu: &'a Gpu,
    program: &'a Program,
    emitter: Emitter,
    emit: &'a mut dyn FnMut(Pass, TileStreams),
}

impl Vertices<'_> {
    /// The vertices of `triangles`, of which `bytes` are read each.
    fn run(&mut self, pass: Pass, triangles: impl Iterator<Item = u32>, bytes: u32, cost: crate::Cost) {
        let gpu = self.gpu;
        let shift = gpu.caches[gpu.paths.vertex[0]].line_bytes.ilog2();
        let stride = u64::from(self.program.buffers.vertex_stride);
        let mut lines: Vec<u32> = Vec::new();
        let (mut lanes, mut warps_in_batch) = (0, 0);
        let mut total = 0_u64;
        for triangle in triangles.map(|triangle| self.program.buffers.stored(triangle)) {
            for corner in 0..CORNERS {
                let first =
                    self.program.buffers.vertex_base + (u64::from(triangle) * CORNERS + corner) * stride;
                let last = first + u64::from(bytes) - 1;
                for line in first >> shift..=last >> shift {
                    if lines.last() != Some(&(line as u32)) {
                        lines.push(line as u32);
                    }
                }
                lanes += 1;
                total += 1;
                if lanes == gpu.cores.warp_width {
                    self.warp(pass, cost, &mut lines);
                    lanes = 0;
                    warps_in_batch += 1;
                }
            }
            if warps_in_batch >= BATCH_WARPS {
                warps_in_batch = 0;
                self.hand_on(pass);
            }
        }
        if lanes > 0 {
            self.warp(pass, cost, &mut lines);
        }
        let issue = self.emitter.issue(pass);
        issue.vertices += total;
        issue.setup_triangles += total / CORNERS;
        let warps = total.div_ceil(u64::from(gpu.cores.warp_width));
        self.program.spend(cost, warps, total, issue);
    }

    /// One warp's vertices, in as many runs as their lines need.
    fn warp(&mut self, pass: Pass, cost: crate::Cost, lines: &mut Vec<u32>) {
        self.emitter.spend(cost);
        for run in lines.chunks(64) {
            self.emitter.fetch(self.program, pass, BufferKind::Vertex, run);
        }
        self.emitter.end_warp(self.program);
        lines.clear();
    }

    fn hand_on(&mut self, of: Pass) {
        (self.emit)(of, self.emitter.take(self.program, &Default::default(), None));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock::gpu;

    #[test]
    fn bins_are_the_largest_that_fit_and_cover_the_image() {
        let tiler = gpu(&[]).tiler;
        // 12 bytes per pixel in 1 MiB: 87,381 pixels; 512x352, 384x352 and 256x352 are tried before.
        assert_eq!(bin_size(1024, 1024, 12, &tiler), [256, 256]);
        assert_eq!(bin_size(256, 256, 12, &tiler), [256, 256], "a small frame is one bin");
        for (width, height) in [(1, 1), (1920, 1080), (2220, 1080), (16384, 16384), (16384, 1), (37, 4000)] {
            for pixel_bytes in [4, 8, 12, 64] {
                let [w, h] = bin_size(width, height, pixel_bytes, &tiler);
                assert!(w.is_multiple_of(64) && h.is_multiple_of(32), "{width}x{height}: {w}x{h}");
                assert!(w * h * pixel_bytes <= tiler.tile_memory_bytes, "{width}x{height}: {w}x{h}");
            }
        }
    }

    #[test]
    fn tile_memory_below_the_smallest_bin_still_ends() {
        let tiler = Tiler { tile_memory_bytes: 1, ..gpu(&[]).tiler };
        assert_eq!(bin_size(1000, 1000, 12, &tiler), [64, 32]);
    }

    #[test]
    fn a_triangle_in_two_tiles_of_a_bin_is_listed_once_there() {
        let draw = |triangle| TileDraw { triangle, covered: 3, passed: 2, quads: 1 };
        let draws = vec![vec![draw(5), draw(9)], vec![draw(5)], vec![draw(2), draw(9)], vec![]];
        let all = bins(64, 64, [64, 32], &draws);
        assert_eq!(all.len(), 2);
        assert_eq!((all[0].triangles.as_slice(), all[0].covered, all[0].quads), (&[5, 9][..], 9, 3));
        assert_eq!((all[1].triangles.as_slice(), all[1].passed), (&[2, 9][..], 4));
    }
}
