//! DRAM with time: channels, banks, row buffers, refresh and an FR-FCFS controller, for standards that are
//! data files. [`Dram`] simulates, [`RowTally`] counts row hits and bounds the time without simulating,
//! [`MissTraceWriter`] writes the requests for other DRAM simulators.
//!
//! Time is whole picoseconds in a `u64`, so results are exact, deterministic and the same on every machine.
//! Times saturate at `u64::MAX` (213 days), where a legal but absurd bandwidth or time would overflow; every
//! request still completes.
//!
//! ```
//! use cachesim::{Dram, DramConfig, DramStandard};
//!
//! let standard = DramStandard::builtin("lpddr4x")?;
//! let config = DramConfig { standard, channels: 4, bytes_per_second: 29.8e9, queue: 32 };
//! let mut dram = Dram::new(&config)?;
//! dram.submit(0, 0x1000, 32, false, 7);
//! let mut done = Vec::new();
//! while let Some(at) = dram.next_event() {
//!     dram.advance(at, &mut done);
//! }
//! assert_eq!((done[0].tag, done[0].at_ps), (7, dram.timings().row_miss()));
//! # Ok::<(), cachesim::Error>(())
//! ```

mod address_map;
mod bank;
mod command;
mod fr_fcfs;
mod ledger;
mod miss_trace;
#[cfg(test)]
mod protocol;
mod refresh;
mod row_tally;
mod sourced;
mod standard;
mod timings;

use std::ops::RangeInclusive;

use address_map::AddressMap;
use bank::{Direction, RowNeed};
use fr_fcfs::Channel;
use ledger::Ledger;

pub use miss_trace::{MissTraceFormat, MissTraceWriter};
pub use row_tally::RowTally;
pub use sourced::DramTag;
pub use standard::{BuiltinDram, DRAM_STANDARDS, DramStandard};
pub use timings::DramTimings;

use crate::error::{Error, Place};

/// The most channels of a memory.
pub const MAX_CHANNELS: u32 = 64;
/// The most requests that a channel's scheduler sees.
pub const MAX_QUEUE: u32 = 4096;
/// From a byte per second to a hundred thousand times the fastest phone.
const BANDWIDTH: RangeInclusive<f64> = 1.0..=1e16;

/// A memory of a standard.
#[derive(Clone, Debug, PartialEq)]
pub struct DramConfig {
    /// What its channels are.
    pub standard: DramStandard,
    /// Independent channels, 1 to [`MAX_CHANNELS`].
    pub channels: u32,
    /// Peak of all channels together, 1 to 1e16. The data rate follows from it.
    pub bytes_per_second: f64,
    /// Waiting requests that a channel's scheduler sees, 1 to [`MAX_QUEUE`]; further ones wait in order.
    pub queue: u32,
}

impl DramConfig {
    /// Checks the figures that are not the standard's.
    ///
    /// # Errors
    /// If a figure is out of its range.
    pub fn check(&self) -> Result<(), Error> {
        let Self { standard, channels, bytes_per_second, queue } = self;
        let refuse = |key: &str, problem: String, remedy: &str| {
            let file = Some(format!("DRAM of {}", standard.name));
            Err(Error::Dram {
                place: Box::new(Place { file, ..Place::default() }),
                key: format!("{key}: "),
                problem,
                remedy: remedy.to_owned(),
            })
        };
        if !(1..=MAX_CHANNELS).contains(channels) {
            let problem = format!("is {channels}, expected 1 to {MAX_CHANNELS}");
            return refuse("channels", problem, "correct the number of channels");
        }
        if !BANDWIDTH.contains(bytes_per_second) {
            let problem = format!("is {bytes_per_second}, expected {} to 1e16", BANDWIDTH.start());
            return refuse("bytes_per_second", problem, "give the peak of all channels together");
        }
        if !(1..=MAX_QUEUE).contains(queue) {
            let problem = format!("is {queue}, expected 1 to {MAX_QUEUE}");
            return refuse("queue", problem, "give the entries that a channel's scheduler sees");
        }
        Ok(())
    }

    /// The timings at this bandwidth.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn timings(&self) -> Result<DramTimings, Error> {
        self.check()?;
        Ok(DramTimings::new(self))
    }
}

/// A finished request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Done {
    /// When its last data was on the bus.
    pub at_ps: u64,
    /// As submitted.
    pub tag: u32,
}

/// How often the row that was wanted was open. An access is the part of a request within one row and one
/// block of its channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowCounts {
    /// The row was open.
    pub hits: u64,
    /// No row of the bank was open.
    pub misses: u64,
    /// Another row of the bank was open.
    pub conflicts: u64,
}

impl RowCounts {
    fn count(&mut self, need: RowNeed) {
        match need {
            RowNeed::Nothing => self.hits += 1,
            RowNeed::Activate => self.misses += 1,
            RowNeed::PrechargeAndActivate => self.conflicts += 1,
        }
    }

    fn add(&mut self, other: &Self) {
        let Self { hits, misses, conflicts } = other;
        self.hits += hits;
        self.misses += misses;
        self.conflicts += conflicts;
    }
}

/// What a memory has done since it began.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DramStats {
    /// Read requests submitted.
    pub reads: u64,
    /// Write requests submitted.
    pub writes: u64,
    /// Bytes read from the banks, in whole bursts.
    pub read_bytes: u64,
    /// Bytes written to the banks, in whole bursts.
    pub written_bytes: u64,
    /// How the rows of finished accesses were found.
    pub rows: RowCounts,
    /// Refresh commands issued before the last request of their channel was served, of all channels.
    pub refreshes: u64,
    /// Per channel, the time in which data was on the bus.
    pub busy_ps: Vec<u64>,
    /// From submission to the last data, summed over the finished reads.
    pub read_latency_ps: u64,
}

/// A memory under simulation.
#[derive(Clone, Debug)]
pub struct Dram {
    map: AddressMap,
    timings: DramTimings,
    burst_bytes: u64,
    channels: Vec<Channel>,
    ledger: Ledger,
}

impl Dram {
    /// An idle memory with all rows shut, at time 0.
    ///
    /// # Errors
    /// As [`DramConfig::check`].
    pub fn new(config: &DramConfig) -> Result<Self, Error> {
        let timings = config.timings()?;
        Ok(Self {
            map: AddressMap::new(&config.standard, config.channels),
            timings,
            burst_bytes: config.standard.burst_bytes(),
            channels: vec![Channel::new(config, timings); config.channels as usize],
            ledger: Ledger::default(),
        })
    }

    /// The timings at the configured bandwidth.
    #[must_use]
    pub fn timings(&self) -> &DramTimings {
        &self.timings
    }

    /// Takes a request for `bytes` from `address` (at least 1, whole bursts). It is finished when the last
    /// of its bursts is. Requests come in order of time: one that comes late counts as coming with the
    /// latest before it at its channel.
    pub fn submit(&mut self, now_ps: u64, address: u64, bytes: u32, write: bool, tag: u32) {
        let direction = if write { Direction::Write } else { Direction::Read };
        let slot = self.ledger.open(now_ps, tag, direction);
        for segment in self.map.segments(address, bytes) {
            self.ledger.add_segment(slot);
            let channel = &mut self.channels[segment.channel as usize];
            channel.submit(now_ps, segment, slot, direction, &mut self.ledger);
        }
    }

    /// A time at or before which nothing finishes unless more is submitted: the next finish where it is
    /// already known, else the earliest that the next command could lead to. `None` when all is idle.
    /// Advancing there always moves on.
    pub fn next_event(&mut self) -> Option<u64> {
        let DramTimings { read_latency, write_latency, burst, .. } = self.timings;
        let service = read_latency.min(write_latency).saturating_add(burst);
        let commands = self.channels.iter_mut().filter_map(Channel::next_at).min();
        let command = commands.map(|at| at.saturating_add(service));
        [command, self.ledger.next_at()].into_iter().flatten().min()
    }

    /// Simulates up to and including `until_ps` and appends what finished by then to `done`, in order of
    /// time, ties in order of submission.
    pub fn advance(&mut self, until_ps: u64, done: &mut Vec<Done>) {
        for channel in &mut self.channels {
            channel.run(until_ps, &mut self.ledger);
        }
        self.ledger.fetch(until_ps, done);
    }

    /// What has been done so far.
    #[must_use]
    pub fn stats(&self) -> DramStats {
        let [reads, writes] = self.ledger.submitted;
        let mut stats =
            DramStats { reads, writes, read_latency_ps: self.ledger.read_latency, ..DramStats::default() };
        for channel in &self.channels {
            stats.refreshes += channel.refreshes();
            let channel = channel.stats();
            stats.rows.add(&channel.rows);
            stats.read_bytes += channel.read_bursts * self.burst_bytes;
            stats.written_bytes += channel.write_bursts * self.burst_bytes;
            stats.busy_ps.push(channel.busy);
        }
        stats
    }
}
