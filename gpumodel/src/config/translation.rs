//! Translation of addresses between the last cache and memory.

use super::gpu_file::TranslationFile;
use super::sourced::File;
use crate::error::Error;
use cachesim::TlbConfig;

/// Pages that a TLB may know: each of its look-ups takes time in proportion.
const MOST_ENTRIES: u32 = 4096;

/// The memory management unit of a GPU, behind its last cache.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Translation {
    /// Pages, and how many of them are known at once.
    pub tlb: TlbConfig,
    /// Seconds that a walk for another page takes. Addresses are translated in order, so it holds up what comes behind it.
    pub walk_seconds: f64,
}

pub(super) fn translation(file: &File<'_>, raw: &TranslationFile) -> Result<Translation, Error> {
    let key = "translation.page_bytes";
    let page_bytes = file.within(key, &raw.page_bytes, 4096..=1 << 30)?;
    if !page_bytes.is_power_of_two() {
        let problem = format!("is {page_bytes}, which is no power of two");
        return Err(file.refuse(key, &raw.page_bytes.value.span(), problem, "correct the value"));
    }
    let entries = file.within("translation.entries", &raw.entries, 1..=MOST_ENTRIES)?;
    Ok(Translation {
        tlb: TlbConfig { page_bytes, entries },
        walk_seconds: file.within("translation.walk_ns", &raw.walk_ns, 1e-9..=1e9)? * 1e-9,
    })
}
