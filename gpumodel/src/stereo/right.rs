//! The right eye: errors are detected, then one dispatch takes the pixels that are traced and those that the left eye answers.

use super::buffers::ENTRY_BYTES;
use super::eye::Eye;
use super::{Kernels, PixelOrder, error_detection};
use crate::counters::Pass;
use crate::dispatch::{Bench, Running};
use crate::error::Error;
use crate::replay::Replayed;
use crate::schedule::HELPER;
use crate::warp::{Emitter, TileStreams};
use tracer::TileSource;

const PASS: Pass = Pass::Output;

pub(super) fn replay<S: TileSource>(
    (eye, mut running): (Eye<'_, S>, Running),
    kernels: &Kernels<'_>,
    order: &PixelOrder,
) -> Result<Replayed, Error> {
    let mut places = vec![0; order.pixels.len()];
    (0..).zip(&order.pixels).for_each(|(place, &pixel)| places[pixel as usize] = place);
    error_detection::run(&eye, kernels, &places, &mut running)?;
    let pieces = eye.source.header().frame.tiles();
    let execute =
        |index: u32| eye.benches.with(|bench| Ok((executed(&eye, kernels, order, bench, index)?, ())));
    running.dispatch(&eye.tracing_passes(), eye.tracing_warps, pieces, execute, |()| {})?;
    Ok(eye.finish(running))
}

/// The warps of a piece of the lists.
fn executed<S: TileSource>(
    eye: &Eye<'_, S>,
    kernels: &Kernels<'_>,
    order: &PixelOrder,
    bench: &mut Bench,
    index: u32,
) -> Result<TileStreams, Error> {
    eye.tile(bench, index, |emitter, warp, rect| {
        let places = warp.rays.iter().copied().filter(|&ray| ray != HELPER).map(|ray| rect.x + ray);
        take_pixels(eye, kernels, order, emitter, &places);
        emitter.trace_rays(&eye.program, warp)?;
        emitter.end_warp(&eye.program);
        Ok(())
    })
}

/// A warp takes its pixels from the lists, and shades those that are answered.
fn take_pixels<S: TileSource>(
    eye: &Eye<'_, S>,
    kernels: &Kernels<'_>,
    order: &PixelOrder,
    emitter: &mut Emitter,
    places: &(impl Iterator<Item = u32> + Clone),
) {
    let lanes = places.clone().count() as u64;
    let sources = places
        .clone()
        .filter(|&place| order.known[place as usize])
        .filter_map(|place| kernels.known.left_pixel(order.pixels[place as usize]));
    let answered = sources.clone().count() as u64;
    eye.program.spend(kernels.costs.take, 1, lanes, emitter.issue(PASS));
    eye.program.spend(kernels.costs.reuse, u64::from(answered > 0), answered, emitter.issue(PASS));
    let fields = kernels.stereo.fields.all();
    if kernels.in_tiles() {
        eye.internal(emitter, PASS, lanes, ENTRY_BYTES);
        for bytes in fields {
            eye.internal(emitter, PASS, answered, u64::from(bytes));
        }
        return;
    }
    eye.records(emitter, PASS, (false, ENTRY_BYTES), &places.clone().map(|place| eye.buffers.entry(place)));
    emitter.end_turn(&eye.program, PASS, true);
    if answered > 0 {
        for (field, bytes) in fields.into_iter().enumerate() {
            let at = sources.clone().map(|pixel| eye.buffers.gbuffer(pixel)[field]);
            eye.records(emitter, PASS, (false, u64::from(bytes)), &at);
        }
        emitter.end_turn(&eye.program, PASS, true);
    }
}
