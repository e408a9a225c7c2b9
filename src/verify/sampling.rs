//! Measures samples of frames, and of what changes do to them, against their replays.

use super::accuracy::{Walk, for_each_trace, side_by_side};
use crate::machine::Machine;
use crate::meter::timed_on_thread;
use anyhow::anyhow;
use gpumodel::{Estimate, Maps, Ratio, ReplayConfig, Sampled, Sampler, Value};
use reports::sampling::{self, Counter, Samples};
use tracer::{TileSource, TraceFile};

/// Counters that are looked at.
const COUNTERS: [&str; 4] = ["frame_time_ms", "dram_read_bytes", "dram_write_bytes", "alu_operations"];

/// A GPU's frame, or what a change does to it.
pub(crate) struct Case {
    pub(crate) machine: Machine,
    /// The change in words, and the machine with it.
    pub(crate) changed: Option<(String, Machine)>,
}

/// Samples every scene with every walk in every case, in this order, `seeds` times for each of `parts` of the tiles.
pub(crate) fn all(
    scenes: &[String],
    walks: &[Walk],
    cases: &[Case],
    parts: &[f64],
    seeds: u32,
) -> anyhow::Result<Vec<sampling::Frame>> {
    let mut frames = Vec::new();
    for_each_trace(scenes, walks, |trace, traversal| {
        for case in cases {
            frames.push(frame(trace, traversal, case, parts, seeds)?);
        }
        Ok(())
    })?;
    Ok(frames)
}

fn frame(
    trace: &TraceFile,
    traversal: &str,
    Case { machine, changed }: &Case,
    parts: &[f64],
    seeds: u32,
) -> anyhow::Result<sampling::Frame> {
    let machines = std::iter::once(machine).chain(changed.iter().map(|(_, machine)| machine));
    let configs: Vec<ReplayConfig> = machines.map(|machine| machine.config.clone()).collect();
    let replays = side_by_side(&[()], |()| {
        let (estimates, run_s) = timed_on_thread(|| {
            let replayed = gpumodel::replay_all(trace, &configs, Maps::Dropped, &|_, _| {})?;
            let estimate =
                |(replayed, config)| gpumodel::estimate(replayed, trace.header(), trace.topology(), config);
            replayed.iter().zip(&configs).map(estimate).collect::<Result<Vec<_>, _>>()
        });
        Ok((estimates?, run_s))
    })?;
    let (exact, replay_s) = &replays[0];
    let all: Vec<u32> = (0..seeds).collect();
    let samples = |&part: &f64| {
        let sampled = side_by_side(&all, |&seed| {
            let (sampled, run_s) =
                timed_on_thread(|| Sampler::new(trace, &configs)?.sample(part, u64::from(seed)));
            Ok((sampled?, run_s))
        })?;
        of_part(exact, trace.header().frame.tiles(), &sampled)
    };
    Ok(sampling::Frame {
        scene: trace.header().scene.clone(),
        traversal: traversal.to_owned(),
        gpu: machine.gpu_name.clone(),
        change: changed.as_ref().map(|(change, _)| change.clone()),
        replay_s: *replay_s,
        samples: parts.iter().map(samples).collect::<anyhow::Result<_>>()?,
    })
}

/// What a counter is, and how far it may be: of a frame in its unit, of a change as a ratio.
fn figure(id: &str, sampled: &[Sampled]) -> Option<(f64, [f64; 2])> {
    match sampled {
        [alone] => number(id, &alone.estimate).zip(alone.intervals.of_frame(id)),
        [first, changed, ..] => {
            let (_, Ratio { value, ci95 }) =
                changed.ratios_to(first)?.into_iter().find(|(of, _)| *of == id)?;
            Some((value, ci95))
        }
        [] => None,
    }
}

fn number(id: &str, estimate: &Estimate) -> Option<f64> {
    estimate.frame.get(id).and_then(Value::number)
}

fn of_part(exact: &[Estimate], tiles: u32, sampled: &[(Vec<Sampled>, f64)]) -> anyhow::Result<Samples> {
    let mean =
        |of: fn(&(Vec<Sampled>, f64)) -> f64| sampled.iter().map(of).sum::<f64>() / sampled.len() as f64;
    let counter = |id: &&str| -> anyhow::Result<Counter> {
        let missing = || anyhow!("the frame has no figure {id}; leave out this scene or GPU");
        let exact = match exact {
            [alone] => number(id, alone),
            [first, changed, ..] => {
                number(id, changed).zip(number(id, first)).and_then(|(this, first)| Ratio::of(this, first))
            }
            [] => None,
        };
        let exact = exact.ok_or_else(missing)?;
        let (mut errors, mut margins, mut covered) = (Vec::new(), Vec::new(), 0);
        for (sampled, _) in sampled {
            let (found, [low, high]) = figure(id, sampled).ok_or_else(missing)?;
            let reach = (found - low).max(high - found);
            errors.push(if found == exact { 0.0 } else { found / exact - 1.0 });
            margins.push(if reach > 0.0 { reach / found.abs() } else { 0.0 });
            // Ends of intervals are rounded less than the figures.
            let round = f64::EPSILON * exact;
            covered += usize::from((low - round..=high + round).contains(&exact));
        }
        Ok(Counter { id: (*id).to_owned(), errors, margins, covered })
    };
    Ok(Samples {
        part: mean(|(sampled, _)| f64::from(sampled[0].tiles)) / f64::from(tiles),
        run_s: mean(|(_, run_s)| *run_s),
        counters: COUNTERS.iter().map(counter).collect::<anyhow::Result<_>>()?,
    })
}
