//! What alpha tests cost a shader.

use super::costs::{Cost, TaggedCostFile, TaggedRegistersFile, read_registers};
use super::sourced::{File, Sourced, Tag};
use crate::error::Error;
use serde::Deserialize;

/// Sizes that a mask may have, in bytes.
const MASK_BYTES: std::ops::RangeInclusive<u32> = 64..=1 << 30;

/// Costs of hits that the traversal does not decide about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct AlphaCosts {
    /// Registers of four words per lane that the shader holds while it tests.
    pub(crate) registers: u32,
    /// The any-hit shader: texture coordinates, the comparison with the mask, the verdict.
    pub(crate) any_hit: Cost,
    /// Taking a candidate from a ray query, and going on with the query.
    pub(crate) resume: Cost,
    /// Looking an opacity micromap up.
    pub(crate) micromap: Cost,
    /// Bytes of the mask that all triangles share out.
    pub(crate) mask_bytes: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AlphaFile {
    registers: TaggedRegistersFile,
    any_hit: TaggedCostFile,
    resume: TaggedCostFile,
    micromap: TaggedCostFile,
    mask_bytes: Sourced<u32>,
}

impl AlphaFile {
    pub(super) fn read(&self, file: &File<'_>) -> Result<AlphaCosts, Error> {
        let TaggedRegistersFile { value, source, .. } = &self.registers;
        Ok(AlphaCosts {
            registers: read_registers(file, "alpha", value, source)?,
            any_hit: self.any_hit.read(file, "alpha.any_hit")?,
            resume: self.resume.read(file, "alpha.resume")?,
            micromap: self.micromap.read(file, "alpha.micromap")?,
            mask_bytes: file.within("alpha.mask_bytes", &self.mask_bytes, MASK_BYTES)?,
        })
    }

    /// Keys of estimates.
    pub(super) fn estimates(&self) -> Vec<String> {
        let Self { registers, any_hit, resume, micromap, mask_bytes } = self;
        [
            ("alpha.registers", registers.tag),
            ("alpha.any_hit", any_hit.tag),
            ("alpha.resume", resume.tag),
            ("alpha.micromap", micromap.tag),
            ("alpha.mask_bytes", mask_bytes.tag),
        ]
        .into_iter()
        .filter(|(_, tag)| *tag == Tag::Estimate)
        .map(|(key, _)| key.to_owned())
        .collect()
    }
}
