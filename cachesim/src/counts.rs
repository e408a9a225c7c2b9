//! What a replay counts. All figures are whole numbers of accesses, lines or bytes.

/// The most levels a description may have, and so the longest path.
pub const MAX_LEVELS: usize = 8;

/// Which accesses of a run missed where, by their places in the run, in order; once for each miss that one caused.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Missed {
    /// By position on the path.
    pub levels: [Vec<u32>; MAX_LEVELS],
    /// Once for each line or sector read from memory.
    pub memory: Vec<u32>,
}

/// Totals of one level, summed over its private copies.
///
/// An access is one touch of one line, or of one sector where the level has sectors. Write-backs and
/// written-through data that arrive from the level above are accesses like any other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LevelCounts {
    /// Reads and writes that reached this level.
    pub accesses: u64,
    /// Accesses that found their data here: `accesses - misses`.
    pub hits: u64,
    /// Accesses that did not.
    pub misses: u64,
    /// The writes among `accesses`.
    pub writes: u64,
    /// The writes among `misses`.
    pub write_misses: u64,
    /// The misses whose line was here, but without the sector; 0 without sectors.
    pub sector_misses: u64,
    /// Lines (sectors) read from below.
    pub fills: u64,
    /// Dirty lines (sectors) written below: on eviction and by a flush.
    pub writebacks: u64,
    /// Misses by cause, where the level was asked to tell.
    pub classes: Option<MissClasses>,
}

/// The misses of a level by cause (Hill and Smith 1989). The three add up to `misses - sector_misses`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MissClasses {
    /// The line's first touch.
    pub cold: u64,
    /// A fully associative LRU cache of the same capacity misses too.
    pub capacity: u64,
    /// The rest: lost to the placement or the replacement policy.
    pub conflict: u64,
}

/// What reached the memory behind the last level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryCounts {
    /// Lines (sectors) read.
    pub reads: u64,
    /// Lines (sectors) written.
    pub writes: u64,
    /// Bytes read.
    pub read_bytes: u64,
    /// Bytes written.
    pub write_bytes: u64,
}

/// A line (sector) on its way to or from memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryRequest {
    /// Of its first byte.
    pub address: u64,
    /// Its length.
    pub bytes: u32,
    /// It is written.
    pub write: bool,
    /// The address of its page has to be walked for first; never without a TLB.
    pub walks: bool,
}

/// What one run of accesses caused at one level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LevelServed {
    /// Accesses that reached the level, write-backs caused by the run included.
    pub accesses: u64,
    /// Those that missed.
    pub misses: u64,
}

/// What one run of accesses caused, level by level along its path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// By position on the path: `levels[0]` is the path's first level. Positions beyond the path are zero.
    pub levels: [LevelServed; MAX_LEVELS],
    /// What the run read from and wrote to memory.
    pub memory: MemoryCounts,
}

impl MissClasses {
    pub(crate) fn plus(self, other: Self) -> Self {
        let Self { cold, capacity, conflict } = other;
        Self {
            cold: self.cold + cold,
            capacity: self.capacity + capacity,
            conflict: self.conflict + conflict,
        }
    }
}

impl MemoryCounts {
    pub(crate) fn add(&mut self, other: &Self) {
        let Self { reads, writes, read_bytes, write_bytes } = *other;
        self.reads += reads;
        self.writes += writes;
        self.read_bytes += read_bytes;
        self.write_bytes += write_bytes;
    }
}
