//! Writing a trace file: to a temporary name beside its place, renamed when finished.

use super::check_header;
use super::codec;
use super::shape;
use super::{
    END_MAGIC, HEADER_SEED, INDEX_SEED, MAGIC, MAX_CHUNK_BYTES, MAX_HEADER_BYTES, MOST_SHADERS,
    STRUCTURE_SEED, TRAILER_SEED, tile_seed,
};
use crate::error::Error;
use crate::topology::Topology;
use crate::trace::{Tile, TraceHeader};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// Fast enough to keep up with tracing; higher levels save a few per cent.
const ZSTD_LEVEL: i32 = 1;

/// A tile, encoded and compressed: the part of writing that any thread can do.
pub struct EncodedTile {
    compressed: Vec<u8>,
    raw_bytes: u32,
    steps: u64,
}

impl EncodedTile {
    /// Encodes a tile of a trace with this header.
    ///
    /// # Errors
    /// When it is too large for a chunk.
    pub fn new(tile: &Tile, header: &TraceHeader) -> Result<Self, Error> {
        let raw = codec::encode_tile(tile, header);
        let steps = tile.ray_sets.iter().map(|set| set.steps.len() as u64).sum();
        let (compressed, raw_bytes) = compress(&raw)?;
        Ok(Self { compressed, raw_bytes, steps })
    }
}

fn compress(raw: &[u8]) -> Result<(Vec<u8>, u32), Error> {
    let raw_bytes = u32::try_from(raw.len()).ok().filter(|&bytes| bytes <= MAX_CHUNK_BYTES).ok_or_else(|| {
        Error::Options(format!(
            "a tile or tree of {} bytes, more than a trace file's chunk can hold ({MAX_CHUNK_BYTES}); use a smaller scene",
            raw.len()
        ))
    })?;
    let compressed = zstd::bulk::compress(raw, ZSTD_LEVEL)
        .map_err(|source| Error::Options(format!("compression failed: {source}")))?;
    Ok((compressed, raw_bytes))
}

/// Writes a trace file tile by tile, in order. Dropped before [`TraceWriter::finish`], it leaves nothing behind.
pub struct TraceWriter {
    path: PathBuf,
    file: BufWriter<NamedTempFile>,
    /// Where each chunk begins; the structure's first.
    offsets: Vec<u64>,
    position: u64,
    steps: u64,
    tiles: u32,
}

impl TraceWriter {
    /// Opens a temporary file in the folder of `path` and writes the header and the tree's shape.
    ///
    /// # Errors
    /// When the frame is beyond what a file can hold, or the folder cannot be written to or is full.
    pub fn create(path: &Path, header: &TraceHeader, topology: &Topology) -> Result<Self, Error> {
        Self::create_with_shaders(path, header, topology, &[])
    }

    /// As [`Self::create`], of a trace with [`TraceHeader::reflections`]: `shaders` has the shader of each triangle, in file order, below
    /// [`MOST_SHADERS`]; of any other trace it is empty.
    ///
    /// # Errors
    /// As [`Self::create`], and when there is not one shader for each triangle.
    pub fn create_with_shaders(
        path: &Path,
        header: &TraceHeader,
        topology: &Topology,
        shaders: &[u32],
    ) -> Result<Self, Error> {
        check_header(header)
            .and_then(|()| check_shaders(header, shaders))
            .map_err(|problem| Error::Options(format!("a trace file cannot hold this: {problem}")))?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".raybudget-").suffix(".rbt.part");
        // Temporary files are private by default; a finished trace is an ordinary file, subject to the user's mask.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let temporary = builder
            .tempfile_in(folder)
            .map_err(|source| io_error(path, "creating a file beside it", source))?;
        let mut writer = Self {
            path: path.to_owned(),
            file: BufWriter::with_capacity(1 << 20, temporary),
            offsets: Vec::new(),
            position: 0,
            steps: 0,
            tiles: header.frame.tiles(),
        };
        let text = serde_json::to_vec(header).expect("a header of numbers and strings becomes JSON");
        if text.len() > MAX_HEADER_BYTES as usize {
            return Err(Error::Options(format!(
                "a trace header of {} bytes, at most {MAX_HEADER_BYTES} fit; shorten the scene's name and remarks",
                text.len()
            )));
        }
        let mut head = MAGIC.to_vec();
        head.extend((text.len() as u32).to_le_bytes());
        head.extend(text);
        head.extend(xxh3_64_with_seed(&head, HEADER_SEED).to_le_bytes());
        writer.write(&head)?;
        let (compressed, raw_bytes) = compress(&shape::encode_structure(topology, shaders))?;
        writer.write_chunk(&compressed, raw_bytes, STRUCTURE_SEED)?;
        Ok(writer)
    }

    /// Writes the next tile.
    ///
    /// # Errors
    /// When the file cannot be written, for example because the disk is full.
    pub fn write_tile(&mut self, tile: &EncodedTile) -> Result<(), Error> {
        let index = self.offsets.len() as u32 - 1;
        self.steps += tile.steps;
        self.write_chunk(&tile.compressed, tile.raw_bytes, tile_seed(index))
    }

    /// Writes the index and the trailer and gives the file its name. `stalls` is the number of traversals that their loop bound
    /// ended. Returns the file's size in bytes.
    ///
    /// # Errors
    /// When the file cannot be written or renamed.
    ///
    /// # Panics
    /// When tiles are missing.
    pub fn finish(mut self, stalls: u64) -> Result<u64, Error> {
        assert_eq!(self.offsets.len() as u64, u64::from(self.tiles) + 1);
        let index_offset = self.position;
        let mut index: Vec<u8> = self.offsets.iter().flat_map(|offset| offset.to_le_bytes()).collect();
        index.extend(xxh3_64_with_seed(&index, INDEX_SEED).to_le_bytes());
        self.write(&index)?;
        let mut trailer = Vec::new();
        trailer.extend(index_offset.to_le_bytes());
        trailer.extend(u64::from(self.tiles).to_le_bytes());
        trailer.extend(self.steps.to_le_bytes());
        trailer.extend(stalls.to_le_bytes());
        trailer.extend(xxh3_64_with_seed(&trailer, TRAILER_SEED).to_le_bytes());
        trailer.extend(END_MAGIC);
        self.write(&trailer)?;
        let Self { path, file, position, .. } = self;
        let temporary = file.into_inner().map_err(|error| io_error(&path, "writing", error.into_error()))?;
        temporary.as_file().sync_all().map_err(|source| io_error(&path, "writing", source))?;
        temporary
            .persist(&path)
            .map_err(|error| io_error(&path, "renaming the finished file", error.error))?;
        Ok(position)
    }

    /// Steps written so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    fn write_chunk(&mut self, compressed: &[u8], raw_bytes: u32, seed: u64) -> Result<(), Error> {
        self.offsets.push(self.position);
        let mut chunk = Vec::with_capacity(compressed.len() + 16);
        chunk.extend((compressed.len() as u32).to_le_bytes());
        chunk.extend(raw_bytes.to_le_bytes());
        chunk.extend(compressed);
        chunk.extend(xxh3_64_with_seed(&chunk, seed).to_le_bytes());
        self.write(&chunk)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.position += bytes.len() as u64;
        self.file.write_all(bytes).map_err(|source| io_error(&self.path, "writing", source))
    }
}

fn check_shaders(header: &TraceHeader, shaders: &[u32]) -> Result<(), String> {
    let triangles = if header.reflections.is_some() { header.triangles as usize } else { 0 };
    if shaders.len() != triangles {
        return Err(format!("shaders of {} triangles, {triangles} expected", shaders.len()));
    }
    match shaders.iter().find(|&&shader| shader >= MOST_SHADERS) {
        Some(shader) => Err(format!("a shader {shader}, below {MOST_SHADERS} expected")),
        None => Ok(()),
    }
}

fn io_error(path: &Path, action: &'static str, source: std::io::Error) -> Error {
    Error::Io { path: path.to_owned(), action, source }
}
