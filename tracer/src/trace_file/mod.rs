//! The trace file (`.rbt`): a header, the tree's shape, compressed and checksummed tiles, an index, a trailer.
//!
//! `docs/trace-format.md` describes it byte for byte, so that other renderers can write one.

mod codec;
mod ray_steps;
mod reader;
pub(crate) mod reflection_lines;
mod shape;
mod writer;

use crate::accel::Accel;
use crate::trace::{Frame, ReflectionRecord, TraceHeader};
use crate::wide::NodeFormat;
pub use reader::TraceFile;
pub use writer::{EncodedTile, TraceWriter};

/// First bytes of a file; the last one is the format version.
const MAGIC: [u8; 8] = *b"RBTRACE\x01";
/// Last bytes of a finished file.
const END_MAGIC: [u8; 8] = *b"RBTREND\x01";
/// Bytes of the trailer: index offset, number of tiles, of steps, of stalls, checksum, end magic.
const TRAILER_BYTES: u64 = 48;
/// Bytes before a chunk's payload: compressed and raw length.
const CHUNK_HEAD_BYTES: u64 = 8;
/// Most bytes of header text.
const MAX_HEADER_BYTES: u32 = 1 << 20;
/// Most bytes of a chunk, compressed or raw: a reader's memory is bounded by a few of them.
const MAX_CHUNK_BYTES: u32 = 1 << 29;

/// Most shaders of a trace's triangles.
pub const MOST_SHADERS: u32 = 1 << 16;

/// Seeds of the checksums, so that a piece in the wrong place does not pass for another.
const HEADER_SEED: u64 = 0;
const STRUCTURE_SEED: u64 = 1;
const INDEX_SEED: u64 = 2;
const TRAILER_SEED: u64 = 3;
const fn tile_seed(index: u32) -> u64 {
    1 << 32 | index as u64
}

/// Limits that a replay relies on.
fn check_header(header: &TraceHeader) -> Result<(), String> {
    const MAX_EDGE: u32 = 1 << 15;
    match header.frame {
        Frame::Image { width, height } if width == 0 || height == 0 || width.max(height) > MAX_EDGE => {
            return Err(format!("a frame of {width}x{height} pixels, 1 to {MAX_EDGE} per edge expected"));
        }
        Frame::List { rays } if rays > 1 << 30 => {
            return Err(format!("a list of {rays} rays, at most {} expected", 1 << 30));
        }
        Frame::List { .. } if header.raster => {
            return Err("drawn triangles for a list of rays, which has no image".to_owned());
        }
        _ => {}
    }
    crate::ray_set::check(&header.ray_sets)?;
    if let Some(alpha) = &header.alpha {
        alpha.check(header.triangles)?;
    }
    if let Some(ReflectionRecord { bounds: [least, most], .. }) = &header.reflections {
        let is_image = matches!(header.frame, Frame::Image { .. });
        if !is_image || reflection_lines::set(&header.ray_sets).is_none() {
            return Err("lines of reflection rays without an image of such rays".to_owned());
        }
        if !least.iter().zip(most).all(|(least, most)| least <= most && least.is_finite() && most.is_finite())
        {
            return Err(format!("a scene's box from {least:?} to {most:?}"));
        }
    }
    let may_be_wide = matches!(header.accel, Accel::WideBvh | Accel::TwoLevel);
    let may_be_binary = header.accel != Accel::WideBvh;
    if !(if header.node_format.is_some() { may_be_wide } else { may_be_binary }) {
        let said = header.node_format.map_or("no node format", NodeFormat::name);
        return Err(format!(
            "{said} for a structure '{}': wide BVHs have one, two levels may, and no other",
            header.accel.name()
        ));
    }
    if header.stack_entries.max(header.short_stack) > 1 << 16 {
        return Err(format!("a stack of {} entries", header.stack_entries.max(header.short_stack)));
    }
    Ok(())
}
