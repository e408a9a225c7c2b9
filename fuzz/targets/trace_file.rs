//! Trace files: opened, and every tile read.
//!
//! Random bytes end at the first checksum, so an input is mostly a recipe: the header's text, the tree and the tiles as they
//! are before compression. The recipe is packed and sealed here from `docs/trace-format.md` alone, and what the reader then
//! sees is whole but need not make sense. The first byte chooses: 0, a file as it stands; 1, a recipe; from 2, a recipe after
//! the place (u8) and the value (u64) of one word of the index and the trailer that is overwritten before they are sealed.
#![no_main]

use std::io::Write;
use tracer::{Tile, TileDraw, TileSource, TraceFile, TraceHeader};
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// More tiles would only slow the search.
const MOST_TILES: u32 = 64;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&choice, rest)) = bytes.split_first() else { return };
    let file = match (choice, rest.split_first_chunk()) {
        (0, _) => rest.to_vec(),
        (2.., Some((&[place, a, b, c, d, e, f, g, h], recipe))) => {
            sealed(recipe, Some((place, [a, b, c, d, e, f, g, h])))
        }
        _ => sealed(rest, None),
    };
    read_all(&file);
});

fn read_all(bytes: &[u8]) {
    let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
    file.write_all(bytes).expect("a temporary file takes bytes");
    let Ok(trace) = TraceFile::open(file.path()) else { return };
    let mut tile = Tile::default();
    for index in 0..trace.header().frame.tiles().min(MOST_TILES) {
        if trace.tile(index, &mut tile).is_ok() {
            let names = trace.topology().references.len();
            let primitives = tile.ray_sets.iter().flat_map(|set| &set.steps);
            let mut primitives = primitives.filter(|step| step.op() == tracer::Op::Primitive);
            assert!(primitives.all(|step| (step.id() as usize) < names));
            assert!(tile.draws.is_sorted_by(|a, b| a.triangle < b.triangle));
            let triangles = trace.header().triangles;
            let limits = |draw: &TileDraw| {
                draw.triangle < triangles
                    && draw.covered <= 1024
                    && draw.passed <= draw.covered
                    && (draw.passed.div_ceil(4)..=draw.passed.min(256)).contains(&draw.quads)
            };
            assert!(tile.draws.iter().all(limits));
            assert!(trace.header().raster || tile.draws.is_empty());
        }
    }
}

/// A finished file of three length-prefixed parts: header text, tree, and one tile that stands for all.
fn sealed(recipe: &[u8], overwritten: Option<(u8, [u8; 8])>) -> Vec<u8> {
    let (text, rest) = part(recipe);
    let (tree, rest) = part(rest);
    let (tile, _) = part(rest);
    let tiles =
        serde_json::from_slice(text).map_or(1, |header: TraceHeader| header.frame.tiles().min(MOST_TILES));
    let mut file = b"RBTRACE\x01".to_vec();
    file.extend((text.len() as u32).to_le_bytes());
    file.extend(text);
    file.extend(xxh3_64_with_seed(&file, 0).to_le_bytes());
    let mut words = Vec::new();
    for chunk in 0..=tiles {
        words.push((file.len() as u64).to_le_bytes());
        let (raw, seed) = if chunk == 0 { (tree, 1) } else { (tile, 1 << 32 | u64::from(chunk - 1)) };
        let packed = zstd::bulk::compress(raw, 1).expect("any bytes compress");
        let mut bytes = (packed.len() as u32).to_le_bytes().to_vec();
        bytes.extend((raw.len() as u32).to_le_bytes());
        bytes.extend(packed);
        bytes.extend(xxh3_64_with_seed(&bytes, seed).to_le_bytes());
        file.extend(bytes);
    }
    words.extend([file.len() as u64, u64::from(tiles), 0, 0].map(u64::to_le_bytes));
    if let Some((place, word)) = overwritten {
        let place = usize::from(place) % words.len();
        words[place] = word;
    }
    let (index, trailer) = words.split_at(words.len() - 4);
    for (words, seed) in [(index, 2), (trailer, 3)] {
        file.extend(words.as_flattened());
        file.extend(xxh3_64_with_seed(words.as_flattened(), seed).to_le_bytes());
    }
    file.extend(b"RBTREND\x01");
    file
}

/// A part after its length (u16, little-endian), or what there is of it.
fn part(bytes: &[u8]) -> (&[u8], &[u8]) {
    let Some((length, rest)) = bytes.split_first_chunk() else { return (&[], &[]) };
    rest.split_at(rest.len().min(usize::from(u16::from_le_bytes(*length))))
}
