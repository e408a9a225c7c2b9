//! How much of a frame is replayed, as it was asked for, checked.

use crate::args::SampleArgs;
use crate::machine::Machine;
use crate::meter::Meter;
use anyhow::{anyhow, bail};
use gpumodel::{COUNTERS, Fidelity, Goal};
use std::time::{Duration, Instant};

/// Part of the tiles that a sample has if nothing is asked of it.
const USUAL_PART: f64 = 0.06;
/// Counters that `--within` is about if none is named.
const HEADLINES: [&str; 3] = ["frame_time_ms", "dram_read_bytes", "dram_write_bytes"];

/// What a sample is to reach, and its seed.
pub(crate) struct Plan {
    pub(crate) goal: Goal,
    pub(crate) seed: u64,
}

impl Plan {
    /// `None` where all tiles are to be replayed; the time limit counts from the start of the program.
    pub(crate) fn new(args: &SampleArgs, machine: &Machine, meter: &Meter) -> anyhow::Result<Option<Self>> {
        let SampleArgs { sample, within, time_limit, seed } = args;
        let goal = match (sample, within.as_slice(), time_limit) {
            (Some(part), ..) => Goal::Part(fraction("--sample", part)?),
            (None, [], Some(limit)) => Goal::By(end(meter, limit)?),
            (None, [], None) if machine.sampled => Goal::Part(USUAL_PART),
            (None, [], None) if seed.is_some() => bail!(
                "--seed: it draws a sample, and all tiles are replayed; add --sample, --within or --time-limit"
            ),
            (None, [], None) => return Ok(None),
            (None, within, _) => Goal::Within(tolerances(within)?),
        };
        if machine.config.fidelity == Fidelity::Timed {
            bail!("--fidelity timed: it simulates every tile; leave out --sample, --within and --time-limit");
        }
        Ok(Some(Self { goal, seed: seed.unwrap_or(0) }))
    }
}

/// By counter; what is said of all headlines holds for those of which nothing is said, and the last word holds.
fn tolerances(given: &[String]) -> anyhow::Result<Vec<(String, f64)>> {
    let mut of_headlines = None;
    let mut named: Vec<(String, f64)> = Vec::new();
    for text in given {
        let Some((id, part)) = text.split_once('=') else {
            of_headlines = Some(fraction("--within", text)?);
            continue;
        };
        if !COUNTERS.iter().any(|counter| counter.id == id) {
            bail!("--within {text}: there is no counter '{id}'; see `raybudget list counters`");
        }
        named.retain(|(known, _)| known != id);
        named.push((id.to_owned(), fraction("--within", part)?));
    }
    if let Some(part) = of_headlines {
        for id in HEADLINES {
            if !named.iter().any(|(known, _)| known == id) {
                named.push((id.to_owned(), part));
            }
        }
    }
    Ok(named)
}

/// A part of a whole: `2%` or `0.02`.
pub(crate) fn fraction(option: &str, text: &str) -> anyhow::Result<f64> {
    let (number, scale) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let part = number.trim().parse::<f64>().ok().map(|number| number * scale);
    part.filter(|part| *part > 0.0 && *part <= 1.0)
        .ok_or_else(|| anyhow!("{option} {text}: expected a part of the whole above 0, such as 2% or 0.02"))
}

/// When a time limit is over.
fn end(meter: &Meter, limit: &str) -> anyhow::Result<Instant> {
    let end = duration(limit).and_then(|limit| meter.started().checked_add(limit));
    end.ok_or_else(|| {
        anyhow!("--time-limit {limit}: expected a time above 0 with its unit, such as 1s or 500ms")
    })
}

/// `1s`, `0.5s`, `500ms` or `10min`.
pub(crate) fn duration(text: &str) -> Option<Duration> {
    const UNITS: [(&str, f64); 3] = [("min", 60.0), ("ms", 1e-3), ("s", 1.0)];
    let (number, scale) = UNITS.iter().find_map(|(unit, scale)| Some((text.strip_suffix(unit)?, *scale)))?;
    let seconds = number.trim().parse::<f64>().ok()? * scale;
    if seconds > 0.0 { Duration::try_from_secs_f64(seconds).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_times_are_read_with_their_units_and_nothing_else_is() {
        assert_eq!(fraction("--within", "2%").unwrap(), 0.02);
        assert_eq!(fraction("--within", "0.5").unwrap(), 0.5);
        for wrong in ["", "%", "0", "-1%", "101%", "NaN", "inf", "2 percent"] {
            assert!(fraction("--within", wrong).is_err(), "{wrong}");
        }
        assert_eq!(duration("1.5s"), Some(Duration::from_millis(1500)));
        assert_eq!(duration("20ms"), Some(Duration::from_millis(20)));
        assert_eq!(duration("10min"), Some(Duration::from_secs(600)));
        for wrong in ["", "s", "1", "0s", "-1s", "NaNs", "infs", "1e300s", "1h", "min"] {
            assert_eq!(duration(wrong), None, "{wrong}");
        }
        assert!(end(&Meter::start(), "1e19s").is_err(), "beyond what the clock can tell");
    }

    #[test]
    fn a_counter_that_is_named_has_its_own_tolerance_wherever_it_stands() {
        let of =
            |given: &[&str]| tolerances(&given.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>());
        let expected = [("dram_read_bytes", 0.1), ("frame_time_ms", 0.02), ("dram_write_bytes", 0.02)];
        let expected = expected.map(|(id, part)| (id.to_owned(), part));
        assert_eq!(of(&["dram_read_bytes=10%", "2%"]).unwrap(), expected);
        assert_eq!(of(&["5%", "2%", "dram_read_bytes=1%", "dram_read_bytes=10%"]).unwrap(), expected);
        assert_eq!(of(&["simt_efficiency=1%"]).unwrap(), [("simt_efficiency".to_owned(), 0.01)]);
        assert!(of(&["frames=2%"]).unwrap_err().to_string().contains("list counters"));
    }
}
