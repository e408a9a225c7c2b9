//! Reading a trace file: everything is checked before it is believed.

use super::check_header;
use super::codec::{self, Limits};
use super::shape;
use super::{
    CHUNK_HEAD_BYTES, END_MAGIC, HEADER_SEED, INDEX_SEED, MAGIC, MAX_CHUNK_BYTES, MAX_HEADER_BYTES,
    STRUCTURE_SEED, TRAILER_BYTES, TRAILER_SEED, tile_seed,
};
use crate::error::Error;
use crate::topology::Topology;
use crate::trace::{Tile, TileOutline, TileSource, TraceHeader};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// Room is made at once for tiles that decompress to up to so many times their length, as most do.
const USUAL_RATIO: usize = 64;

const RECORD_AGAIN: &str = "record the trace again with `raybudget trace`";

/// An open trace file; tiles are read when asked for.
pub struct TraceFile {
    path: PathBuf,
    file: Mutex<File>,
    header: TraceHeader,
    topology: Topology,
    shaders: Vec<u32>,
    /// Where each chunk begins, the structure's first, and at last where the index begins.
    offsets: Vec<u64>,
    steps: u64,
    stalls: u64,
    limits: Limits,
}

impl TraceFile {
    /// Opens a file and checks its header, tree, index and trailer; the tiles are checked when they are read.
    ///
    /// # Errors
    /// When the file cannot be read, is of another kind, torn, damaged, or contradicts itself.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let io = |action| move |source| Error::Io { path: path.to_owned(), action, source };
        let format = |offset: u64, problem: String, remedy| Error::Format {
            path: path.to_owned(),
            offset,
            problem,
            remedy,
        };
        let mut file = File::open(path).map_err(io("opening"))?;
        let metadata = file.metadata().map_err(io("reading"))?;
        if !metadata.is_file() {
            return Err(format(0, "not a regular file".to_owned(), "give the path of a .rbt file"));
        }
        let length = metadata.len();

        let mut head = [0; 12];
        read_at(&mut file, 0, &mut head)
            .map_err(|_| format(0, format!("{length} bytes are too few for a trace file"), RECORD_AGAIN))?;
        if head[..7] != MAGIC[..7] {
            let problem = "the file does not begin with RBTRACE, so it is not a raybudget trace".to_owned();
            return Err(format(
                0,
                problem,
                "give a file written by `raybudget trace` or as docs/trace-format.md says",
            ));
        }
        if head[7] != MAGIC[7] {
            let problem =
                format!("trace format version {}, this program reads version {}", head[7], MAGIC[7]);
            return Err(format(7, problem, RECORD_AGAIN));
        }
        let text_bytes = u32::from_le_bytes(*head[8..].first_chunk().expect("four bytes"));
        let structure_offset = 12 + u64::from(text_bytes) + 8;
        if text_bytes > MAX_HEADER_BYTES || structure_offset + TRAILER_BYTES > length {
            let problem = format!("a header of {text_bytes} bytes does not fit in the file of {length}");
            return Err(format(8, problem, RECORD_AGAIN));
        }
        let mut text = vec![0; text_bytes as usize + 8];
        read_at(&mut file, 12, &mut text).map_err(io("reading"))?;
        let checksum = take_checksum(&mut text);
        let checked = [&head[..], &text].concat();
        if xxh3_64_with_seed(&checked, HEADER_SEED) != checksum {
            return Err(format(
                12,
                "the header's checksum does not match: the file is damaged".to_owned(),
                RECORD_AGAIN,
            ));
        }

        let mut trailer = [0; TRAILER_BYTES as usize];
        read_at(&mut file, length - TRAILER_BYTES, &mut trailer).map_err(io("reading"))?;
        let word = |at: usize| u64::from_le_bytes(*trailer[at..].first_chunk().expect("eight bytes"));
        let (index_offset, tiles, steps, stalls) = (word(0), word(8), word(16), word(24));
        if trailer[40..] != END_MAGIC || xxh3_64_with_seed(&trailer[..32], TRAILER_SEED) != word(32) {
            let problem =
                "the trailer is missing or damaged: the file is torn, or its writing was interrupted"
                    .to_owned();
            return Err(format(length - TRAILER_BYTES, problem, RECORD_AGAIN));
        }

        let header: TraceHeader = serde_json::from_slice(&text)
            .map_err(|error| format(12, format!("the header is not as expected: {error}"), RECORD_AGAIN))?;
        check_header(&header).map_err(|problem| format(12, problem, RECORD_AGAIN))?;
        let chunks = tiles.saturating_add(1);
        let index_bytes = chunks.saturating_mul(8).saturating_add(8);
        let index_fits = index_offset >= structure_offset
            && index_offset.checked_add(index_bytes).and_then(|end| end.checked_add(TRAILER_BYTES))
                == Some(length);
        if !index_fits || tiles != u64::from(header.frame.tiles()) {
            let problem = format!(
                "{tiles} tiles with an index at byte {index_offset} do not fit the frame of {} tiles and the file of {length} bytes",
                header.frame.tiles()
            );
            return Err(format(length - TRAILER_BYTES, problem, RECORD_AGAIN));
        }
        let mut index = vec![0; index_bytes as usize];
        read_at(&mut file, index_offset, &mut index).map_err(io("reading"))?;
        let checksum = take_checksum(&mut index);
        if xxh3_64_with_seed(&index, INDEX_SEED) != checksum {
            return Err(format(index_offset, "the index is damaged".to_owned(), RECORD_AGAIN));
        }
        let mut offsets: Vec<u64> = index
            .chunks_exact(8)
            .map(|bytes| u64::from_le_bytes(*bytes.first_chunk().expect("eight bytes")))
            .collect();
        offsets.push(index_offset);
        if offsets[0] != structure_offset
            || offsets
                .windows(2)
                .any(|pair| pair[1].checked_sub(pair[0]).is_none_or(|bytes| bytes < CHUNK_HEAD_BYTES + 8))
        {
            return Err(format(
                index_offset,
                "the index does not lead from chunk to chunk".to_owned(),
                RECORD_AGAIN,
            ));
        }

        let mut trace = Self {
            path: path.to_owned(),
            file: Mutex::new(file),
            limits: Limits::new(&header, &Topology::default()),
            header,
            topology: Topology::default(),
            shaders: Vec::new(),
            offsets,
            steps,
            stalls,
        };
        let raw = trace.read_chunk(0, STRUCTURE_SEED)?;
        (trace.topology, trace.shaders) =
            shape::decode_structure(&raw, &trace.header).map_err(|problem| trace.format_error(0, problem))?;
        if trace.topology.triangles != trace.header.triangles {
            let problem = format!(
                "a tree over {} triangles, {} in the header",
                trace.topology.triangles, trace.header.triangles
            );
            return Err(trace.format_error(0, problem));
        }
        trace.limits = Limits::new(&trace.header, &trace.topology);
        Ok(trace)
    }

    /// The shader of each triangle, in file order; empty unless the header has [`TraceHeader::reflections`].
    pub fn shaders(&self) -> &[u32] {
        &self.shaders
    }

    /// Steps in all tiles.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    fn format_error(&self, chunk: usize, problem: String) -> Error {
        Error::Format { path: self.path.clone(), offset: self.offsets[chunk], problem, remedy: RECORD_AGAIN }
    }

    /// Reads, checks and decompresses a chunk.
    fn read_chunk(&self, chunk: usize, seed: u64) -> Result<Vec<u8>, Error> {
        let (start, end) = (self.offsets[chunk], self.offsets[chunk + 1]);
        let bytes = end - start;
        if bytes > u64::from(MAX_CHUNK_BYTES) {
            return Err(self.format_error(
                chunk,
                format!("a chunk of {bytes} bytes, at most {MAX_CHUNK_BYTES} expected"),
            ));
        }
        let mut data = vec![0; bytes as usize];
        {
            let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            read_at(&mut file, start, &mut data).map_err(|source| Error::Io {
                path: self.path.clone(),
                action: "reading",
                source,
            })?;
        }
        let checksum = take_checksum(&mut data);
        if xxh3_64_with_seed(&data, seed) != checksum {
            let problem = "a chunk's checksum does not match: the file is damaged".to_owned();
            return Err(self.format_error(chunk, problem));
        }
        let word = |at: usize| u32::from_le_bytes(*data[at..].first_chunk().expect("four bytes"));
        let (compressed_bytes, raw_bytes) = (word(0), word(4));
        if u64::from(compressed_bytes) + CHUNK_HEAD_BYTES != data.len() as u64 || raw_bytes > MAX_CHUNK_BYTES
        {
            let problem = format!(
                "a chunk of {compressed_bytes} bytes, {raw_bytes} uncompressed, in {} bytes of file",
                data.len()
            );
            return Err(self.format_error(chunk, problem));
        }
        // One byte more than claimed, to notice data that go on. Beyond the usual, the vector grows with what is there, not
        // with the claim.
        let room = (raw_bytes as usize + 1).min(USUAL_RATIO * data.len());
        let mut raw = Vec::with_capacity(room);
        zstd::stream::read::Decoder::with_buffer(&data[CHUNK_HEAD_BYTES as usize..])
            .and_then(|decoder| decoder.take(u64::from(raw_bytes) + 1).read_to_end(&mut raw))
            .map_err(|error| self.format_error(chunk, format!("a chunk does not decompress: {error}")))?;
        if raw.len() as u64 != u64::from(raw_bytes) {
            let problem = format!("a chunk holds {} bytes or more, {raw_bytes} expected", raw.len());
            return Err(self.format_error(chunk, problem));
        }
        Ok(raw)
    }
}

impl TileSource for TraceFile {
    fn header(&self) -> &TraceHeader {
        &self.header
    }

    fn topology(&self) -> &Topology {
        &self.topology
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), Error> {
        let chunk = index as usize + 1;
        let raw = self.read_chunk(chunk, tile_seed(index))?;
        let rect = self.header.frame.tile(index);
        codec::decode_tile(&raw, rect, &self.limits, tile)
            .map_err(|problem| self.format_error(chunk, problem))
    }

    fn outline(&self, index: u32) -> Result<Option<TileOutline>, Error> {
        let chunk = index as usize + 1;
        let mut head = [0; CHUNK_HEAD_BYTES as usize];
        let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        read_at(&mut file, self.offsets[chunk], &mut head).map_err(|source| Error::Io {
            path: self.path.clone(),
            action: "reading",
            source,
        })?;
        let word = |at: usize| u64::from(u32::from_le_bytes(*head[at..].first_chunk().expect("four bytes")));
        let (compressed_bytes, bytes) = (word(0), word(4));
        Ok(Some(TileOutline { bytes, compressed_bytes }))
    }

    fn is_recorded(&self) -> bool {
        true
    }

    fn stalls(&self) -> u64 {
        self.stalls
    }
}

fn read_at(file: &mut File, offset: u64, bytes: &mut [u8]) -> std::io::Result<()> {
    file.seek(SeekFrom::Start(offset))?;
    file.read_exact(bytes)
}

/// Splits the checksum off the end.
fn take_checksum(data: &mut Vec<u8>) -> u64 {
    let start = data.len() - 8;
    let checksum = u64::from_le_bytes(*data[start..].first_chunk().expect("eight bytes"));
    data.truncate(start);
    checksum
}
