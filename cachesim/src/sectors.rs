//! Lines made of sectors: which sector a granule number names, and what of a line is dirty.

use crate::assoc::SectorState;
use crate::config::LevelConfig;

/// The number of sectors per line, a power of two up to 32; 1 without sectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sectors {
    log2: u32,
}

impl Sectors {
    pub(crate) fn of(config: &LevelConfig) -> Self {
        Self { log2: config.line.log2() - config.granule().log2() }
    }

    /// The line, and the sector as a bit.
    #[inline(always)]
    pub(crate) fn split(self, granule: u64) -> (u64, u32) {
        (granule >> self.log2, 1 << (granule & ((1 << self.log2) - 1)))
    }

    /// The granule numbers of a line's dirty sectors, in order.
    pub(crate) fn dirty(self, line: u64, state: SectorState) -> impl Iterator<Item = u64> {
        (0..1_u64 << self.log2)
            .filter(move |sector| state.dirty >> sector & 1 != 0)
            .map(move |sector| line << self.log2 | sector)
    }
}
