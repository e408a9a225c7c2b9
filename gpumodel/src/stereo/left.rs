//! The left eye: it is traced, its G-buffer kept, and its pixels are reprojected.

use super::Kernels;
use super::buffers::{POSITION, SPAN_BYTES};
use super::eye::Eye;
use crate::config::Stage;
use crate::counters::Pass;
use crate::dispatch::{Bench, Running};
use crate::error::Error;
use crate::lanes::Lanes;
use crate::replay::Replayed;
use crate::schedule::HELPER;
use crate::warp::{Emitter, TileStreams};
use tracer::{TILE_RAYS, TileRect, TileSource};

pub(super) fn replay<S: TileSource>(
    (eye, mut running): (Eye<'_, S>, Running),
    kernels: &Kernels<'_>,
) -> Result<Replayed, Error> {
    let tiles = eye.source.header().frame.tiles();
    let trace = |index: u32| eye.benches.with(|bench| Ok((traced(&eye, kernels, bench, index)?, ())));
    running.dispatch(&eye.tracing_passes(), eye.tracing_warps, tiles, trace, |()| {})?;

    let Stage::Compute { workgroup } = kernels.config.technique.stage else {
        unreachable!("a technique of two eyes has a compute stage")
    };
    let [width, height] = kernels.known.size();
    let lanes = Lanes::new((width, height), workgroup, kernels.config.gpu.cores.warp_width);
    let piece = lanes.group * (TILE_RAYS as usize).div_ceil(lanes.group);
    let pieces = lanes.pixels.len().div_ceil(piece) as u32;
    let reproject = |index: u32| {
        eye.benches.with(|bench| {
            let start = index as usize * piece;
            let end = lanes.pixels.len().min(start + piece);
            for warp in lanes.pixels[start..end].chunks(lanes.warp) {
                reprojected(&eye, kernels, &mut bench.emitter, warp);
            }
            Ok((bench.emitter.take(&eye.program, &Default::default(), None), ()))
        })
    };
    running.dispatch(&[Pass::Reprojection], eye.kernel_warps, pieces, reproject, |()| {})?;
    Ok(eye.finish(running))
}

/// The warps of a tile: what they trace and shade, and the G-buffer that they write.
fn traced<S: TileSource>(
    eye: &Eye<'_, S>,
    kernels: &Kernels<'_>,
    bench: &mut Bench,
    index: u32,
) -> Result<TileStreams, Error> {
    let [width, _] = kernels.known.size();
    eye.tile(bench, index, |emitter, warp, TileRect { x, y, width: across, .. }| {
        emitter.trace_rays(&eye.program, warp)?;
        let inside = warp.rays.iter().copied().filter(|&ray| ray != HELPER);
        let pixels = inside.map(|ray| (y + ray / across) * width + x + ray % across);
        keep_gbuffer(eye, kernels, emitter, &pixels);
        emitter.end_warp(&eye.program);
        Ok(())
    })
}

fn keep_gbuffer<S: TileSource>(
    eye: &Eye<'_, S>,
    kernels: &Kernels<'_>,
    emitter: &mut Emitter,
    pixels: &(impl Iterator<Item = u32> + Clone),
) {
    const PASS: Pass = Pass::Output;
    if kernels.in_tiles() {
        let lanes = pixels.clone().count() as u64;
        for bytes in kernels.stereo.fields.all() {
            eye.internal(emitter, PASS, lanes, u64::from(bytes));
        }
        return;
    }
    for (field, bytes) in kernels.stereo.fields.all().into_iter().enumerate() {
        let at = pixels.clone().map(|pixel| eye.buffers.gbuffer(pixel)[field]);
        eye.records(emitter, PASS, (true, u64::from(bytes)), &at);
    }
    emitter.end_turn(&eye.program, PASS, false);
}

/// Where the right eye sees the pixels of a warp.
fn reprojected<S: TileSource>(eye: &Eye<'_, S>, kernels: &Kernels<'_>, emitter: &mut Emitter, warp: &[u32]) {
    const PASS: Pass = Pass::Reprojection;
    let pixels = warp.iter().copied().filter(|&pixel| pixel != HELPER);
    let lanes = pixels.clone().count() as u64;
    if lanes == 0 {
        return;
    }
    let position = u64::from(kernels.stereo.fields.position);
    if kernels.in_tiles() {
        eye.internal(emitter, PASS, lanes, position);
        eye.internal(emitter, PASS, lanes, SPAN_BYTES);
        emitter.issue(PASS).dma_write_bytes += lanes * SPAN_BYTES;
    } else {
        let at = pixels.clone().map(|pixel| eye.buffers.gbuffer(pixel)[POSITION]);
        eye.records(emitter, PASS, (false, position), &at);
        emitter.end_turn(&eye.program, PASS, true);
        eye.records(emitter, PASS, (true, SPAN_BYTES), &pixels.map(|pixel| eye.buffers.span(pixel)));
        emitter.end_turn(&eye.program, PASS, false);
    }
    eye.program.spend(kernels.costs.reproject, 1, lanes, emitter.issue(PASS));
    emitter.end_warp(&eye.program);
}
