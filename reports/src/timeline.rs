//! A modelled frame on a time line, in the JSON of trace events that the Perfetto UI and `chrome://tracing` open.
//!
//! Passes lie one after the other, in the order of the report. The model knows one figure of a pass, not how it changes within: a counter track
//! holds it from the pass's begin to its end. Passes that one shader runs together are apart here, each as long as its part of their time.

use crate::counters::Counters;
use crate::report::Report;
use crate::units;
use serde_json::{Map, Value, json};

/// One process, with a track of frames and one of their passes.
const PROCESS: u32 = 1;
const FRAMES: u32 = 1;
const PASSES: u32 = 2;

/// How the height of a counter track follows from a counter.
enum Height {
    /// Counted bytes over the time of the pass, in GB/s.
    Rate,
    /// A ratio in per cent.
    Percent,
    /// As it is, in its unit.
    Plain,
}

/// Counters with a track, in the order of the tracks.
const TRACKS: [(&str, Height); 12] = [
    ("dram_read_bytes", Height::Rate),
    ("dram_write_bytes", Height::Rate),
    ("time_alus_working", Height::Percent),
    ("shader_alu_capacity_utilized", Height::Percent),
    ("simt_efficiency", Height::Percent),
    ("occupancy", Height::Percent),
    ("l1_miss_ratio", Height::Percent),
    ("l2_miss_ratio", Height::Percent),
    ("ray_unit_utilization", Height::Percent),
    ("stalled_on_system_memory", Height::Percent),
    ("mrays_per_second", Height::Plain),
    ("power_mw", Height::Plain),
];

/// The frames of `reports`, each under its name, one after the other: one report, or those of two eyes. A line feed ends the text.
///
/// Times are in microseconds to the nanosecond. A pass that takes less has no slice, and neither has one whose time is not known.
pub fn write(reports: &[(&str, &Report)]) -> String {
    let mut events = Vec::new();
    if let Some((_, report)) = reports.first() {
        let process = format!("{} on {}", report.inputs.scene, report.inputs.gpu);
        events.push(named("process_name", FRAMES, &process));
    }
    events.push(named("thread_name", FRAMES, "frame"));
    events.push(named("thread_name", PASSES, "passes"));
    let mut now = Clock::default();
    for &(name, report) in reports {
        let begin = now;
        for pass in &report.passes {
            let pass_begin = now;
            now.advance(&pass.counters);
            if let Some(slice) = slice(PASSES, &pass.name, &pass.counters, pass_begin, now) {
                events.push(slice);
                events.extend(tracks(reports, &pass.counters, pass_begin));
            }
        }
        // Where it takes no time, there is nothing to see.
        events.extend(slice(FRAMES, name, &report.counters, begin, now));
    }
    let file = json!({
        "otherData": {
            "tool": reports.first().map(|(_, report)| &report.tool),
            "times": "modelled; passes one after the other, counters constant within a pass, 0 where a pass has none",
        },
        "traceEvents": events,
    });
    format!("{file}\n")
}

/// Time since the begin of the first frame.
#[derive(Clone, Copy, Default)]
struct Clock {
    milliseconds: f64,
}

impl Clock {
    /// Passes what these counters belong to.
    fn advance(&mut self, counters: &Counters) {
        self.milliseconds += figure(counters, "frame_time_ms").unwrap_or(0.0);
    }

    fn nanoseconds(self) -> f64 {
        (self.milliseconds * 1e6).round()
    }
}

fn figure(counters: &Counters, id: &str) -> Option<f64> {
    counters.get(id)?.value.as_f64()
}

fn named(what: &str, track: u32, name: &str) -> Value {
    json!({"ph": "M", "name": what, "pid": PROCESS, "tid": track, "args": {"name": name}})
}

/// A slice with the counters that are there; none where it is too short.
fn slice(track: u32, name: &str, counters: &Counters, begin: Clock, end: Clock) -> Option<Value> {
    let length = end.nanoseconds() - begin.nanoseconds();
    let args: Map<String, Value> = counters
        .iter()
        .filter_map(|(id, counter)| {
            let name = units::counter_info(id).map_or(id, |info| info.name);
            let value = match counter.value {
                crate::Value::Count(count) => json!(count),
                crate::Value::Real(real) => json!(real),
                crate::Value::Absent { .. } => return None,
            };
            Some((format!("{name}, {}", counter.unit), value))
        })
        .collect();
    (length > 0.0).then(|| {
        json!({
            "ph": "X", "name": name, "cat": "gpu", "pid": PROCESS, "tid": track,
            "ts": begin.nanoseconds() / 1e3, "dur": length / 1e3, "args": args,
        })
    })
}

/// Where each counter track goes with a pass. A track that any pass has goes to 0 in one that has no such figure, as the figure of the pass
/// before would stay otherwise.
fn tracks(reports: &[(&str, &Report)], counters: &Counters, begin: Clock) -> Vec<Value> {
    let any_has = |id: &str| {
        let mut passes = reports.iter().flat_map(|(_, report)| &report.passes);
        passes.any(|pass| figure(&pass.counters, id).is_some())
    };
    let seconds = figure(counters, "frame_time_ms").unwrap_or(0.0) * 1e-3;
    let event = |(id, height): &(&str, Height)| {
        let info = units::counter_info(id).filter(|_| any_has(id))?;
        let value = figure(counters, id).unwrap_or(0.0);
        let (value, unit) = match height {
            Height::Rate => (value / seconds * 1e-9, "GB/s"),
            Height::Percent => (100.0 * value, "%"),
            Height::Plain => (value, info.unit),
        };
        // The UI calls the track by the name and the key.
        let ts = begin.nanoseconds() / 1e3;
        Some(json!({"ph": "C", "name": info.name, "pid": PROCESS, "ts": ts, "args": {unit: value}}))
    };
    TRACKS.iter().filter_map(event).collect()
}
