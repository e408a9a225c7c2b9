//! Row hits and a lower bound on time, for models that have no time.

use super::address_map::AddressMap;
use super::bank::{RowNeed, SHUT};
use super::{DramConfig, DramTimings, RowCounts};
use crate::error::Error;

/// Counts row hits of accesses taken in order, with rows left open and no refresh.
#[derive(Clone, Debug)]
pub struct RowTally {
    map: AddressMap,
    timings: DramTimings,
    burst_bytes: u64,
    channels: Vec<ChannelTally>,
}

#[derive(Clone, Debug)]
struct ChannelTally {
    bursts: u64,
    banks: Vec<BankTally>,
}

#[derive(Clone, Copy, Debug)]
struct BankTally {
    open: u64,
    rows: RowCounts,
}

impl RowTally {
    /// Nothing seen yet, all rows shut.
    ///
    /// # Errors
    /// As [`DramConfig::check`].
    pub fn new(config: &DramConfig) -> Result<Self, Error> {
        let timings = config.timings()?;
        let (banks, _) = config.standard.banks_and_groups();
        let bank = BankTally { open: SHUT, rows: RowCounts::default() };
        let channel = ChannelTally { bursts: 0, banks: vec![bank; banks as usize] };
        Ok(Self {
            map: AddressMap::new(&config.standard, config.channels),
            timings,
            burst_bytes: config.standard.burst_bytes(),
            channels: vec![channel; config.channels as usize],
        })
    }

    /// Takes an access to `bytes` from `address`, in whole bursts; reads and writes alike.
    pub fn record(&mut self, address: u64, bytes: u32) {
        for segment in self.map.segments(address, bytes) {
            let channel = &mut self.channels[segment.channel as usize];
            let bank = &mut channel.banks[segment.bank as usize];
            let need = match bank.open {
                row if row == segment.row => RowNeed::Nothing,
                SHUT => RowNeed::Activate,
                _ => RowNeed::PrechargeAndActivate,
            };
            bank.open = segment.row;
            bank.rows.count(need);
            channel.bursts += u64::from(segment.bursts);
        }
    }

    /// Of all banks together.
    #[must_use]
    pub fn rows(&self) -> RowCounts {
        let mut total = RowCounts::default();
        self.channels.iter().flat_map(|channel| &channel.banks).for_each(|bank| total.add(&bank.rows));
        total
    }

    /// Of the banks of one channel, in order; empty if there is no such channel.
    pub fn bank_rows(&self, channel: u32) -> impl Iterator<Item = RowCounts> + '_ {
        let channel = self.channels.get(channel as usize);
        channel.into_iter().flat_map(|channel| &channel.banks).map(|bank| bank.rows)
    }

    /// Bytes moved per channel, in whole bursts.
    pub fn channel_bytes(&self) -> impl Iterator<Item = u64> + '_ {
        self.channels.iter().map(|channel| channel.bursts * self.burst_bytes)
    }

    /// A lower bound on the time that a memory needs for what was seen, all of it waiting from the start and
    /// each bank's part taken in order: the longest, over the channels, of data on the bus, of the row cycles
    /// of one bank, and of the activates of all banks at four per tFAW and one per tRRD. Refresh is left out: it goes on
    /// beside other banks, and may be postponed.
    #[must_use]
    pub fn service_ps(&self) -> u64 {
        let times = self.channels.iter().map(|channel| channel.service_ps(&self.timings));
        times.max().unwrap_or(0)
    }
}

impl ChannelTally {
    fn service_ps(&self, timings: &DramTimings) -> u64 {
        let activates = |bank: &BankTally| bank.rows.misses + bank.rows.conflicts;
        let bus = self.bursts.saturating_mul(timings.burst);
        let most = self.banks.iter().map(activates).max().unwrap_or(0);
        let all: u64 = self.banks.iter().map(activates).sum();
        let rest = |count: u64| count.saturating_sub(1);
        let bank = rest(most).saturating_mul(timings.rc);
        let window = (rest(all) / 4).saturating_mul(timings.faw);
        let spaced = rest(all).saturating_mul(timings.rrd);
        bus.max(bank).max(window).max(spaced)
    }
}
