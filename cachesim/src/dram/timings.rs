//! The timings of a standard at one data rate, in picoseconds.

use super::DramConfig;
use super::standard::{DramStandard, Speed, Wait};

/// A data rate is written rounded (4267 for 4266.67), so an entry of the latency table reaches this much more.
const RATE_TOLERANCE: f64 = 1.005;

/// The waits of one channel in picoseconds, each a whole number of command clocks but for
/// the interval of refresh.
///
/// Saturates at `u64::MAX` where a legal but absurd bandwidth would overflow, and is never 0 for a burst.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DramTimings {
    /// The command clock, at least 1.
    pub clock: u64,
    /// Data of one burst on the bus.
    pub burst: u64,
    /// Read command to its first data (RL, nCL).
    pub read_latency: u64,
    /// Write command to its first data (WL).
    pub write_latency: u64,
    /// Activate to column command of the bank.
    pub rcd: u64,
    /// Precharge of a bank to its activate or refresh.
    pub rp: u64,
    /// Activate to precharge of the bank.
    pub ras: u64,
    /// Activate to activate of the bank, at least `ras + rp`.
    pub rc: u64,
    /// Activate to activate of another bank.
    pub rrd: u64,
    /// Window that holds at most four activates.
    pub faw: u64,
    /// Read command to precharge of the bank.
    pub rtp: u64,
    /// Last written data to precharge of the bank.
    pub wr: u64,
    /// Column command to the next of the same direction in another bank group.
    pub ccd_s: u64,
    /// Column command to the next of the same direction in the same bank group.
    pub ccd_l: u64,
    /// Read command to write command.
    pub read_to_write: u64,
    /// Write command to read command in another bank group.
    pub write_to_read_s: u64,
    /// Write command to read command in the same bank group.
    pub write_to_read_l: u64,
    /// Refresh of a bank to its activate (tRFCpb).
    pub rfc: u64,
    /// Refresh of a bank to refresh of others.
    pub pbr2pbr: u64,
    /// Refresh of a bank to activate of another.
    pub pbr2act: u64,
    /// Average interval between refreshes of a bank.
    pub refi: u64,
}

impl DramTimings {
    /// Of a checked configuration: the command clock follows from the bandwidth of a channel and its width.
    ///
    /// The latencies in clocks are those of the smallest data rate in the standard's table that reaches the
    /// configured one. Beyond the largest, they keep its nanoseconds, since the memory gets no faster inside.
    pub(super) fn new(config: &DramConfig) -> Self {
        let DramStandard { organisation, waits, speeds, .. } = &config.standard;
        let bytes_per_ps = config.bytes_per_second / f64::from(config.channels) * 1e-12;
        let burst = organisation.burst_bytes() as f64 / bytes_per_ps;
        let clocks_per_burst = f64::from(organisation.burst_length / organisation.transfers_per_clock);
        let clock = burst / clocks_per_burst;
        let mbps = f64::from(organisation.transfers_per_clock) / clock * 1e6;

        let speed = speed(speeds, mbps);
        let table_clock = f64::from(organisation.transfers_per_clock) * 1e6 / f64::from(speed.mbps);
        let latency = |clocks: u32| f64::from(clocks) * clock.max(table_clock);
        let whole = |wait: Wait| (wait.ns * 1e3 / clock - 1e-6).ceil().max(wait.clocks) * clock;
        let (ras, rp) = (ps(whole(waits.ras)), ps(whole(waits.rp_pb)));
        let (read, write) = (latency(speed.read_latency), latency(speed.write_latency));
        let gap = whole(waits.read_strobe) + whole(waits.write_preamble);
        let (burst_ps, read_to_write) = (ps(burst).max(1), ps(read + burst + gap - write));
        Self {
            clock: ps(clock).max(1),
            burst: burst_ps,
            read_latency: ps(read),
            write_latency: ps(write),
            rcd: ps(whole(waits.rcd)),
            rp,
            ras,
            rc: ps(whole(waits.rc)).max(ras.saturating_add(rp)),
            rrd: ps(whole(waits.rrd)),
            faw: ps(whole(waits.faw)),
            rtp: ps(whole(waits.rtp)),
            wr: ps(whole(waits.wr)),
            ccd_s: burst_ps,
            ccd_l: ps(whole(waits.ccd_l)).max(burst_ps),
            read_to_write: read_to_write.max(burst_ps),
            write_to_read_s: ps(write + burst + whole(waits.wtr_s)),
            write_to_read_l: ps(write + burst + whole(waits.wtr_l)),
            rfc: ps(whole(waits.rfc_pb)),
            pbr2pbr: ps(whole(waits.pbr2pbr)),
            pbr2act: ps(whole(waits.pbr2act)),
            refi: ps(waits.refi.ns * 1e3),
        }
    }

    /// From the arrival of a read at an idle channel with that bank's rows shut to its last data, for one
    /// burst.
    #[must_use]
    pub fn row_miss(&self) -> u64 {
        self.rcd.saturating_add(self.row_hit())
    }

    /// As [`Self::row_miss`], for several bursts of one row.
    #[must_use]
    pub fn row_miss_of(&self, bursts: u64) -> u64 {
        self.row_miss().saturating_add(bursts.saturating_sub(1).saturating_mul(self.ccd_l))
    }

    /// As [`Self::row_miss`], with another row of the bank open and long used.
    #[must_use]
    pub fn row_conflict(&self) -> u64 {
        self.rp.saturating_add(self.row_miss())
    }

    /// As [`Self::row_miss`], with the row open.
    #[must_use]
    pub fn row_hit(&self) -> u64 {
        self.read_latency.saturating_add(self.burst)
    }

    /// The share of time that refresh takes from a bank whose row is in use all the time: precharge, refresh and
    /// reopening per interval. At bandwidths so small that a clock lasts longer than the interval, 1.
    #[must_use]
    pub fn refresh_share(&self) -> f64 {
        let shut = self.rp as f64 + self.rfc as f64 + self.rcd as f64;
        (shut / self.refi as f64).min(1.0)
    }
}

fn speed(speeds: &[Speed], mbps: f64) -> Speed {
    let reaches = |speed: &&Speed| f64::from(speed.mbps) * RATE_TOLERANCE >= mbps;
    let found = speeds.iter().find(reaches).or(speeds.last());
    *found.expect("a checked standard has at least one speed")
}

/// Rounded to whole picoseconds, saturating.
fn ps(picoseconds: f64) -> u64 {
    picoseconds.round() as u64
}
