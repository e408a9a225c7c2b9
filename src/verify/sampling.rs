//! Measures samples of frames against their replays.

use super::accuracy::{Walk, for_each_trace, side_by_side};
use crate::machine::Machine;
use crate::meter::timed_on_thread;
use anyhow::anyhow;
use gpumodel::{Estimate, Maps, Sampled, Sampler, Value};
use reports::sampling::{self, Counter, Samples};
use tracer::{TileSource, TraceFile};

/// Counters that are looked at.
const COUNTERS: [&str; 4] = ["frame_time_ms", "dram_read_bytes", "dram_write_bytes", "alu_operations"];

/// Samples every scene with every walk on every GPU, in this order, `seeds` times for each of `parts` of the tiles.
pub(crate) fn all(
    scenes: &[String],
    walks: &[Walk],
    gpus: &[Machine],
    parts: &[f64],
    seeds: u32,
) -> anyhow::Result<Vec<sampling::Frame>> {
    let mut frames = Vec::new();
    for_each_trace(scenes, walks, |trace, traversal| {
        for gpu in gpus {
            frames.push(frame(trace, traversal, gpu, parts, seeds)?);
        }
        Ok(())
    })?;
    Ok(frames)
}

fn frame(
    trace: &TraceFile,
    traversal: &str,
    gpu: &Machine,
    parts: &[f64],
    seeds: u32,
) -> anyhow::Result<sampling::Frame> {
    let config = &gpu.config;
    let replays = side_by_side(&[()], |()| {
        let (estimate, run_s) = timed_on_thread(|| {
            let replayed = gpumodel::replay(trace, config, Maps::Dropped, &|_, _| {})?;
            gpumodel::estimate(&replayed, trace.header(), trace.topology(), config)
        });
        Ok((estimate?, run_s))
    })?;
    let (exact, replay_s) = &replays[0];
    let all: Vec<u32> = (0..seeds).collect();
    let samples = |&part: &f64| {
        let sampled = side_by_side(&all, |&seed| {
            let (sampled, run_s) =
                timed_on_thread(|| Sampler::new(trace, config)?.sample(part, u64::from(seed)));
            Ok((sampled?, run_s))
        })?;
        of_part(exact, trace.header().frame.tiles(), &sampled)
    };
    Ok(sampling::Frame {
        scene: trace.header().scene.clone(),
        traversal: traversal.to_owned(),
        gpu: gpu.gpu_name.clone(),
        replay_s: *replay_s,
        samples: parts.iter().map(samples).collect::<anyhow::Result<_>>()?,
    })
}

fn of_part(exact: &Estimate, tiles: u32, sampled: &[(Sampled, f64)]) -> anyhow::Result<Samples> {
    let mean = |of: fn(&(Sampled, f64)) -> f64| sampled.iter().map(of).sum::<f64>() / sampled.len() as f64;
    let counter = |id: &&str| -> anyhow::Result<Counter> {
        let number = |estimate: &Estimate| {
            let value = estimate.frame.get(id).and_then(Value::number);
            value.ok_or_else(|| anyhow!("the frame has no figure {id}; leave out this scene or GPU"))
        };
        let exact = number(exact)?;
        let errors = sampled.iter().map(|(sample, _)| {
            let found = number(&sample.estimate)?;
            Ok(if found == exact { 0.0 } else { found / exact - 1.0 })
        });
        let holds = |(sample, _): &&(Sampled, f64)| {
            // Ends of intervals are rounded less than the figures.
            let round = f64::EPSILON * exact;
            let interval = sample.intervals.of_frame(id);
            interval.is_some_and(|[low, high]| (low - round..=high + round).contains(&exact))
        };
        Ok(Counter {
            id: (*id).to_owned(),
            errors: errors.collect::<anyhow::Result<_>>()?,
            margins: sampled.iter().map(|(sample, _)| sample.margin(id)).collect(),
            covered: sampled.iter().filter(holds).count(),
        })
    };
    Ok(Samples {
        part: mean(|(sample, _)| f64::from(sample.tiles)) / f64::from(tiles),
        run_s: mean(|(_, run_s)| *run_s),
        counters: COUNTERS.iter().map(counter).collect::<anyhow::Result<_>>()?,
    })
}
