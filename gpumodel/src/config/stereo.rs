//! Two eyes on a GPU: where what the left one has hit is kept for the right one, and what the kernels between them cost.

use super::costs::{Cost, TaggedCostFile, TaggedRegistersFile, read_registers};
use super::gpu_file::InternalMemoryFile;
use super::sourced::{File, Sourced, Tag};
use super::technique::Attachments;
use crate::error::Error;
use serde::Deserialize;

/// Sides of a tile in pixels.
const SIDES: std::ops::RangeInclusive<u32> = 1..=16384;
/// Most pixels of a tile: their words take 512 KiB of shared memory, more than any GPU has.
const MOST_PIXELS: u32 = 1 << 16;
/// Bytes of a field of the G-buffer.
const FIELD_BYTES: std::ops::RangeInclusive<u32> = 4..=16;

/// How the right eye is given what the left one has hit (Lee et al. 2017).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stereo {
    /// Where the G-buffer of the left eye is: for tile after tile in internal memory, or for the whole screen in memory.
    pub gbuffer: Attachments,
    /// Its fields.
    pub fields: GBufferFields,
    /// Which lanes take the pixels of the right eye.
    pub launch: StereoLaunch,
    /// Pixels that are tested for reprojection errors together, and whose G-buffer is in internal memory at a time: width and height.
    pub tile: [u32; 2],
}

/// Which lanes take the pixels of the right eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StereoLaunch {
    /// Those of a dispatch over two lists, of the pixels that are traced and of the others: an inspector and its executor.
    Lists,
    /// Those of the pixels, which part where some are traced.
    Pixels,
}

/// Bytes of a pixel in each field of the G-buffer, each of which is a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GBufferFields {
    /// What the pixel shows but for what depends on the view, and which lights it sees.
    pub colour: u32,
    /// Normal.
    pub normal: u32,
    /// Texture coordinates.
    pub texcoord: u32,
    /// Position.
    pub position: u32,
}

impl GBufferFields {
    /// In the order of the planes.
    pub fn all(&self) -> [u32; 4] {
        let Self { colour, normal, texcoord, position } = *self;
        [colour, normal, texcoord, position]
    }

    /// Bytes of a pixel.
    pub fn bytes(&self) -> u32 {
        self.all().into_iter().sum()
    }
}

/// Memory on the chip that kernels address, as large as [`Tiler::tile_memory_bytes`](super::Tiler::tile_memory_bytes), and that DMA fills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InternalMemory {
    /// Seconds from when DMA is told of a transfer to when it begins.
    pub dma_setup_seconds: f64,
}

/// Costs of the kernels between two eyes, without the addresses of loads and stores to buffers; addresses of shared and internal memory and
/// loop control are among them.
#[derive(Clone, Copy, Debug)]
pub struct StereoCosts {
    /// Where the right eye sees a pixel of the left one.
    pub reproject: Cost,
    /// Putting it into its row of the right image, where the nearest stays.
    pub scatter: Cost,
    /// Between it and its right neighbour: the line whose pixels are tested.
    pub span: Cost,
    /// A pixel of that line.
    pub test: Cost,
    /// What a pixel of the right image is, and its place in the list of those that are traced or of the others.
    pub classify: Cost,
    /// Taking a pixel from a list.
    pub take: Cost,
    /// Shading a pixel that the left eye answers, from its G-buffer.
    pub reuse: Cost,
    /// Registers of four words per lane of the first two kernels.
    pub registers: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StereoFile {
    gbuffer: Attachments,
    launch: StereoLaunch,
    fields: Sourced<FieldsFile>,
    tile: Sourced<[u32; 2]>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct FieldsFile {
    colour: u32,
    normal: u32,
    texcoord: u32,
    position: u32,
}

impl StereoFile {
    pub(super) fn read(&self, file: &File<'_>) -> Result<Stereo, Error> {
        let refuse = |key: &str, figure: std::ops::Range<usize>, problem: String| {
            file.refuse(key, &figure, problem, "correct the value")
        };
        let FieldsFile { colour, normal, texcoord, position } =
            *file.sourced("stereo.fields", &self.fields)?;
        let fields = GBufferFields { colour, normal, texcoord, position };
        if let Some(bytes) =
            fields.all().into_iter().find(|bytes| !FIELD_BYTES.contains(bytes) || !bytes.is_multiple_of(4))
        {
            let problem = format!("have one of {bytes} bytes, expected 4, 8, 12 or 16");
            return Err(refuse("stereo.fields", self.fields.value.span(), problem));
        }
        let tile = *file.sourced("stereo.tile", &self.tile)?;
        let [width, height] = tile;
        if !tile.iter().all(|side| SIDES.contains(side)) {
            let problem = format!("is [{width}, {height}], expected two sides of 1 to {}", SIDES.end());
            return Err(refuse("stereo.tile", self.tile.value.span(), problem));
        }
        if width * height > MOST_PIXELS {
            let problem = format!("is [{width}, {height}], expected at most {MOST_PIXELS} pixels");
            return Err(refuse("stereo.tile", self.tile.value.span(), problem));
        }
        Ok(Stereo { gbuffer: self.gbuffer, launch: self.launch, fields, tile })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StereoCostsFile {
    reproject: TaggedCostFile,
    scatter: TaggedCostFile,
    span: TaggedCostFile,
    test: TaggedCostFile,
    classify: TaggedCostFile,
    take: TaggedCostFile,
    reuse: TaggedCostFile,
    registers: TaggedRegistersFile,
}

impl StereoCostsFile {
    pub(super) fn read(&self, file: &File<'_>) -> Result<StereoCosts, Error> {
        let TaggedRegistersFile { value, source, .. } = &self.registers;
        Ok(StereoCosts {
            reproject: self.reproject.read(file, "stereo.reproject")?,
            scatter: self.scatter.read(file, "stereo.scatter")?,
            span: self.span.read(file, "stereo.span")?,
            test: self.test.read(file, "stereo.test")?,
            classify: self.classify.read(file, "stereo.classify")?,
            take: self.take.read(file, "stereo.take")?,
            reuse: self.reuse.read(file, "stereo.reuse")?,
            registers: read_registers(file, "stereo", value, source)?,
        })
    }

    /// Keys of estimates.
    pub(super) fn estimates(&self) -> Vec<String> {
        let Self { reproject, scatter, span, test, classify, take, reuse, registers } = self;
        [
            ("stereo.reproject", reproject.tag),
            ("stereo.scatter", scatter.tag),
            ("stereo.span", span.tag),
            ("stereo.test", test.tag),
            ("stereo.classify", classify.tag),
            ("stereo.take", take.tag),
            ("stereo.reuse", reuse.tag),
            ("stereo.registers", registers.tag),
        ]
        .into_iter()
        .filter(|(_, tag)| *tag == Tag::Estimate)
        .map(|(key, _)| key.to_owned())
        .collect()
    }
}

pub(super) fn internal_memory(file: &File<'_>, raw: &InternalMemoryFile) -> Result<InternalMemory, Error> {
    let setup = file.within("internal_memory.dma_setup_us", &raw.dma_setup_us, 0.0..=1e6)?;
    Ok(InternalMemory { dma_setup_seconds: setup * 1e-6 })
}
