//! A DRAM standard as data: organisation, timings and latencies by data rate, each figure with its source.

use serde::Deserialize;
use toml::Spanned;

use super::sourced::{DramTag, Figure, File, Timing, estimates};
use crate::error::{Error, Place};

/// A description that comes with the program.
pub struct BuiltinDram {
    /// Its name on the command line and in descriptions of GPUs.
    pub name: &'static str,
    /// The text of its file.
    pub toml: &'static str,
}

/// All descriptions that come with the program.
pub const DRAM_STANDARDS: &[BuiltinDram] = &[
    BuiltinDram { name: "lpddr4x", toml: include_str!("../../../configs/dram/lpddr4x.toml") },
    BuiltinDram { name: "lpddr5", toml: include_str!("../../../configs/dram/lpddr5.toml") },
    BuiltinDram { name: "lpddr5x", toml: include_str!("../../../configs/dram/lpddr5x.toml") },
];

/// A DRAM standard: every figure checked, none defaulted.
#[derive(Clone, Debug, PartialEq)]
pub struct DramStandard {
    /// Its name on the command line and in descriptions of GPUs.
    pub name: String,
    /// What it is, for people.
    pub title: String,
    /// Keys of the figures that are estimates.
    pub estimates: Vec<String>,
    pub(super) organisation: Organisation,
    pub(super) waits: Waits,
    pub(super) speeds: Vec<Speed>,
    pub(super) controller: Controller,
}

/// What one channel is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Organisation {
    pub(super) width_bits: u32,
    pub(super) burst_length: u32,
    pub(super) transfers_per_clock: u32,
    pub(super) banks: u32,
    pub(super) bank_groups: u32,
    pub(super) row_bytes: u64,
    pub(super) refresh_banks: u32,
}

impl Organisation {
    pub(super) fn burst_bytes(&self) -> u64 {
        u64::from(self.width_bits / 8 * self.burst_length)
    }

    /// How many banks further the other bank of a pair is that is refreshed together: where the upper bit of its group
    /// differs, or of its number where there is one group. 0 where each bank is refreshed alone.
    pub(super) fn refresh_partner(&self) -> u32 {
        let upper_half = if self.bank_groups > 1 { self.bank_groups } else { self.banks } / 2;
        if self.refresh_banks == 2 { upper_half } else { 0 }
    }
}

/// The longer of a time and a number of clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wait {
    pub(super) ns: f64,
    pub(super) clocks: f64,
}

/// The standard's names; see the files for their meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Waits {
    pub(super) rcd: Wait,
    pub(super) rp_pb: Wait,
    pub(super) ras: Wait,
    pub(super) rc: Wait,
    pub(super) rrd: Wait,
    pub(super) faw: Wait,
    pub(super) rtp: Wait,
    pub(super) wr: Wait,
    pub(super) wtr_s: Wait,
    pub(super) wtr_l: Wait,
    pub(super) ccd_l: Wait,
    pub(super) read_strobe: Wait,
    pub(super) write_preamble: Wait,
    pub(super) rfc_pb: Wait,
    pub(super) pbr2pbr: Wait,
    pub(super) pbr2act: Wait,
    pub(super) refi: Wait,
}

/// Latencies in clocks up to a data rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Speed {
    pub(super) mbps: u32,
    pub(super) read_latency: u32,
    pub(super) write_latency: u32,
}

/// What the standard leaves to the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Controller {
    pub(super) channel_bytes: u64,
    pub(super) group_bytes: u64,
    pub(super) write_high: f64,
    pub(super) write_low: f64,
    pub(super) age_cap_ns: f64,
    pub(super) refresh_postponed: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    name: Spanned<String>,
    title: String,
    organisation: RawOrganisation,
    timing: RawTiming,
    speed: Vec<RawSpeed>,
    controller: RawController,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawOrganisation {
    width_bits: Figure<u32>,
    burst_length: Figure<u32>,
    transfers_per_clock: Figure<u32>,
    banks: Figure<u32>,
    bank_groups: Figure<u32>,
    row_bytes: Figure<u64>,
    refresh_banks: Figure<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTiming {
    trcd: Timing,
    trp_pb: Timing,
    tras: Timing,
    trc: Timing,
    trrd: Timing,
    tfaw: Timing,
    trtp: Timing,
    twr: Timing,
    twtr_s: Timing,
    twtr_l: Timing,
    tccd_l: Timing,
    read_strobe: Timing,
    write_preamble: Timing,
    trfc_pb: Timing,
    tpbr2pbr: Timing,
    tpbr2act: Timing,
    trefi: Timing,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSpeed {
    mbps: Spanned<u32>,
    read_latency: Spanned<u32>,
    write_latency: Spanned<u32>,
    source: Spanned<String>,
    /// Required, and collected by [`estimates`].
    #[serde(rename = "tag")]
    _tag: DramTag,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawController {
    channel_bytes: Figure<u64>,
    group_bytes: Figure<u64>,
    write_high: Figure<f64>,
    write_low: Figure<f64>,
    age_cap_ns: Figure<f64>,
    refresh_postponed: Figure<u32>,
}

impl DramStandard {
    /// Reads and checks a description. `file` is its name, for errors only.
    ///
    /// # Errors
    /// If the text is not TOML, has an unknown key or lacks one, or contradicts itself; the error names the
    /// file, the line and the key.
    pub fn parse(text: &str, file: &str) -> Result<Self, Error> {
        let file = File::new(file, text);
        let raw: Raw = file.read()?;
        if raw.name.get_ref().trim().is_empty() {
            return Err(file.refuse("name", &raw.name.span(), "is empty", "name the standard"));
        }
        let organisation = raw.organisation.check(&file)?;
        Ok(Self {
            waits: raw.timing.check(&file, &organisation)?,
            speeds: speeds(&file, &raw.speed, &raw.name)?,
            controller: raw.controller.check(&file, &organisation)?,
            organisation,
            name: raw.name.into_inner(),
            title: raw.title,
            estimates: estimates(text),
        })
    }

    /// One of [`DRAM_STANDARDS`].
    ///
    /// # Errors
    /// If there is none of this name.
    pub fn builtin(name: &str) -> Result<Self, Error> {
        let Some(found) = DRAM_STANDARDS.iter().find(|standard| standard.name == name) else {
            let names: Vec<_> = DRAM_STANDARDS.iter().map(|standard| standard.name).collect();
            return Err(Error::Dram {
                place: Box::new(Place { file: Some(format!("DRAM '{name}'")), ..Place::default() }),
                key: String::new(),
                problem: format!("no such standard, expected {}", names.join(", ")),
                remedy: "name one of them, or give a file".to_owned(),
            });
        };
        Self::parse(found.toml, &format!("configs/dram/{}.toml", found.name))
    }

    /// Seconds from an activate of a bank to its first read (tRCD).
    #[must_use]
    pub fn row_open_seconds(&self) -> f64 {
        self.waits.rcd.ns * 1e-9
    }

    /// Seconds from an activate of a bank to its next one (tRC).
    #[must_use]
    pub fn row_cycle_seconds(&self) -> f64 {
        self.waits.rc.ns * 1e-9
    }

    /// Data lines of a channel.
    #[must_use]
    pub fn width_bits(&self) -> u32 {
        self.organisation.width_bits
    }

    /// Bytes that one read or write command moves.
    #[must_use]
    pub fn burst_bytes(&self) -> u64 {
        self.organisation.burst_bytes()
    }

    /// Banks of a channel, and the groups they form.
    #[must_use]
    pub fn banks_and_groups(&self) -> (u32, u32) {
        (self.organisation.banks, self.organisation.bank_groups)
    }

    /// Bytes of a row of a bank.
    #[must_use]
    pub fn row_bytes(&self) -> u64 {
        self.organisation.row_bytes
    }

    /// Consecutive bytes that stay in one channel.
    #[must_use]
    pub fn channel_bytes(&self) -> u64 {
        self.controller.channel_bytes
    }

    /// The peak of one channel at the highest data rate that has latencies, bytes per second.
    #[must_use]
    pub fn fastest_channel(&self) -> f64 {
        let mbps = self.speeds.last().map_or(0, |speed| speed.mbps);
        f64::from(mbps) * 1e6 * f64::from(self.organisation.width_bits) / 8.0
    }
}

impl RawOrganisation {
    fn check(&self, file: &File<'_>) -> Result<Organisation, Error> {
        let found = Organisation {
            width_bits: file.within("organisation.width_bits", &self.width_bits, 8..=4096)?,
            burst_length: file.within("organisation.burst_length", &self.burst_length, 1..=256)?,
            transfers_per_clock: file.within(
                "organisation.transfers_per_clock",
                &self.transfers_per_clock,
                1..=64,
            )?,
            banks: file.within("organisation.banks", &self.banks, 1..=64)?,
            bank_groups: file.within("organisation.bank_groups", &self.bank_groups, 1..=64)?,
            row_bytes: file.within("organisation.row_bytes", &self.row_bytes, 8..=1 << 20)?,
            refresh_banks: file.within("organisation.refresh_banks", &self.refresh_banks, 1..=2)?,
        };
        let refuse = |key: &str, span, problem: String, remedy: &str| {
            Err(file.refuse(&format!("organisation.{key}"), &span, problem, remedy))
        };
        if !found.width_bits.is_multiple_of(8) {
            let problem = format!("is {}, expected whole bytes", found.width_bits);
            return refuse("width_bits", self.width_bits.value.span(), problem, "give a multiple of 8");
        }
        if !found.burst_length.is_multiple_of(found.transfers_per_clock) {
            let problem = format!(
                "is {}, which is no whole number of clocks of {} transfers",
                found.burst_length, found.transfers_per_clock
            );
            let remedy = "give a multiple of transfers_per_clock";
            return refuse("burst_length", self.burst_length.value.span(), problem, remedy);
        }
        if !found.banks.is_multiple_of(found.bank_groups) {
            let problem =
                format!("is {}, expected a multiple of the {} bank groups", found.banks, found.bank_groups);
            return refuse("banks", self.banks.value.span(), problem, "change banks or bank_groups");
        }
        let paired = if found.bank_groups > 1 { found.bank_groups } else { found.banks };
        if !paired.is_multiple_of(found.refresh_banks) {
            let problem =
                format!("is 2, but {} banks in {} groups make no pairs", found.banks, found.bank_groups);
            let remedy = "give 1, or an even number of groups, or of banks in one group";
            return refuse("refresh_banks", self.refresh_banks.value.span(), problem, remedy);
        }
        if !found.row_bytes.is_multiple_of(found.burst_bytes()) {
            let problem =
                format!("is {}, expected a multiple of a burst's {}", found.row_bytes, found.burst_bytes());
            let remedy = "change row_bytes, width_bits or burst_length";
            return refuse("row_bytes", self.row_bytes.value.span(), problem, remedy);
        }
        Ok(found)
    }
}

impl RawTiming {
    fn check(&self, file: &File<'_>, organisation: &Organisation) -> Result<Waits, Error> {
        let timing = |key: &str, timing| file.timing(&format!("timing.{key}"), timing);
        let waits = Waits {
            rcd: timing("trcd", &self.trcd)?,
            rp_pb: timing("trp_pb", &self.trp_pb)?,
            ras: timing("tras", &self.tras)?,
            rc: timing("trc", &self.trc)?,
            rrd: timing("trrd", &self.trrd)?,
            faw: timing("tfaw", &self.tfaw)?,
            rtp: timing("trtp", &self.trtp)?,
            wr: timing("twr", &self.twr)?,
            wtr_s: timing("twtr_s", &self.twtr_s)?,
            wtr_l: timing("twtr_l", &self.twtr_l)?,
            ccd_l: timing("tccd_l", &self.tccd_l)?,
            read_strobe: timing("read_strobe", &self.read_strobe)?,
            write_preamble: timing("write_preamble", &self.write_preamble)?,
            rfc_pb: timing("trfc_pb", &self.trfc_pb)?,
            pbr2pbr: timing("tpbr2pbr", &self.tpbr2pbr)?,
            pbr2act: timing("tpbr2act", &self.tpbr2act)?,
            refi: timing("trefi", &self.trefi)?,
        };
        let refuse = |key: &str, at: &Timing, problem: String, remedy: &str| {
            Err(file.refuse(&format!("timing.{key}"), &at.span(), problem, remedy))
        };
        let least = waits.ras.ns + waits.rp_pb.ns;
        if waits.rc.ns < least {
            let problem = format!("is {} ns, less than tras + trp_pb = {least} ns", waits.rc.ns);
            return refuse("trc", &self.trc, problem, "raise trc, or lower tras or trp_pb");
        }
        if waits.ras.ns < waits.rcd.ns {
            let problem = format!("is {} ns, less than trcd = {} ns", waits.ras.ns, waits.rcd.ns);
            return refuse("tras", &self.tras, problem, "raise tras or lower trcd");
        }
        if waits.faw.ns < waits.rrd.ns {
            let problem = format!("is {} ns, less than trrd = {} ns", waits.faw.ns, waits.rrd.ns);
            return refuse("tfaw", &self.tfaw, problem, "raise tfaw or lower trrd");
        }
        let commands = f64::from(organisation.banks / organisation.refresh_banks);
        let busy = (waits.rp_pb.ns + waits.rfc_pb.ns + waits.rcd.ns).max(2.0 * commands * waits.pbr2pbr.ns);
        if waits.refi.ns <= busy {
            let problem = format!(
                "is {} ns, not more than trp_pb + trfc_pb + trcd and twice {commands} x tpbr2pbr = {busy} ns",
                waits.refi.ns
            );
            return refuse("trefi", &self.trefi, problem, "raise trefi, or lower trfc_pb or tpbr2pbr");
        }
        Ok(waits)
    }
}

fn speeds(file: &File<'_>, raw: &[RawSpeed], name: &Spanned<String>) -> Result<Vec<Speed>, Error> {
    let mut found: Vec<Speed> = Vec::new();
    for (number, speed) in (1..).zip(raw) {
        let key = |key: &str| format!("speed {number}.{key}");
        file.said(&key("source"), &speed.source)?;
        let next = Speed {
            mbps: file.number(&key("mbps"), &speed.mbps, 1..=1_000_000)?,
            read_latency: file.number(&key("read_latency"), &speed.read_latency, 1..=10_000)?,
            write_latency: file.number(&key("write_latency"), &speed.write_latency, 1..=10_000)?,
        };
        if let Some(last) = found.last().filter(|last| last.mbps >= next.mbps) {
            let problem = format!("is {}, not more than the {} before it", next.mbps, last.mbps);
            return Err(file.refuse(&key("mbps"), &speed.mbps.span(), problem, "sort by data rate"));
        }
        found.push(next);
    }
    if found.is_empty() {
        let remedy = "give the latencies of at least one data rate";
        return Err(file.refuse("speed", &name.span(), "the list is empty", remedy));
    }
    Ok(found)
}

impl RawController {
    fn check(&self, file: &File<'_>, organisation: &Organisation) -> Result<Controller, Error> {
        let found = Controller {
            channel_bytes: file.within("controller.channel_bytes", &self.channel_bytes, 1..=1 << 30)?,
            group_bytes: file.within("controller.group_bytes", &self.group_bytes, 1..=1 << 20)?,
            write_high: file.within("controller.write_high", &self.write_high, 0.0..=1.0)?,
            write_low: file.within("controller.write_low", &self.write_low, 0.0..=1.0)?,
            age_cap_ns: file.within("controller.age_cap_ns", &self.age_cap_ns, 0.0..=1e9)?,
            refresh_postponed: file.within("controller.refresh_postponed", &self.refresh_postponed, 0..=8)?,
        };
        let refuse = |key: &str, span, problem: String, remedy: &str| {
            Err(file.refuse(&format!("controller.{key}"), &span, problem, remedy))
        };
        let burst = organisation.burst_bytes();
        for (key, bytes, span) in [
            ("channel_bytes", found.channel_bytes, self.channel_bytes.value.span()),
            ("group_bytes", found.group_bytes, self.group_bytes.value.span()),
        ] {
            if !bytes.is_multiple_of(burst) {
                let problem = format!("is {bytes}, expected a multiple of a burst's {burst}");
                return refuse(key, span, problem, "give a multiple of the burst");
            }
        }
        if !organisation.row_bytes.is_multiple_of(found.group_bytes) {
            let problem = format!(
                "is {}, which does not divide a row of {}",
                found.group_bytes, organisation.row_bytes
            );
            return refuse(
                "group_bytes",
                self.group_bytes.value.span(),
                problem,
                "give a divisor of row_bytes",
            );
        }
        if found.write_low >= found.write_high {
            let problem = format!("is {}, not less than write_high = {}", found.write_low, found.write_high);
            return refuse("write_low", self.write_low.value.span(), problem, "lower write_low");
        }
        Ok(found)
    }
}
