//! The first lines of a page: time, what decides, bytes, energy, and the largest causes.

use super::markup::{Escaped, series_class};
use crate::counters::Counters;
use crate::report::{Inputs, Report, TimePart};
use crate::text::margin;
use crate::units;
use crate::within::Within;

/// Causes that stand in the summary.
const CAUSES: usize = 3;

/// Name of the frame and what it was drawn with.
pub(super) fn heading(report: &Report) -> String {
    let Inputs { scene, gpu, accel, traversal, technique, ray_sets, triangles, width, height, .. } =
        &report.inputs;
    let size = match (width, height) {
        (Some(width), Some(height)) => format!("{width} \u{d7} {height} pixels"),
        _ => "a list of rays".to_owned(),
    };
    let facts = [
        format!("{} triangles", units::grouped(u64::from(*triangles))),
        size,
        format!("{} rays", ray_sets.join(" + ")),
        format!("{accel}, {traversal}"),
        technique.clone(),
    ];
    let facts: String = facts.iter().map(|fact| format!("<li>{}</li>", Escaped(fact))).collect();
    format!(
        "<header><h1>{} <span>on</span> {}</h1>\n<ul class=\"facts\">{facts}</ul></header>\n",
        Escaped(scene),
        Escaped(gpu)
    )
}

/// Everything in it follows from the inputs alone.
pub(super) fn write(report: &Report) -> String {
    let mut out = String::from("<div class=\"stats\">\n");
    let figure = |id: &str| figure(&report.counters, id);
    if let Some(time) = figure("frame_time_ms") {
        let rate = figure("fps").map(|(rate, _)| format!("{rate} frames per second"));
        let error = report.run.within.as_ref().map(within);
        out += &stat("Frame time", &time, &[rate, error].into_iter().flatten().collect::<Vec<_>>());
    }
    if let Some(name) = &report.deciding_bound {
        let bound = report.bounds.iter().find(|bound| bound.name == *name);
        let note =
            bound.map(|bound| format!("by itself {} ms of the frame", units::digits(bound.seconds * 1e3)));
        out += &stat("What decides", &(name.clone(), String::new()), note.as_slice());
    }
    let bytes = ["dram_read_bytes", "dram_write_bytes"].map(|id| report.counters.get(id)?.value.as_f64());
    if let [Some(read), Some(written)] = bytes {
        let shown = |bytes: f64| {
            let (size, unit) = units::scale("B", bytes);
            (units::digits(bytes / size), unit.to_owned())
        };
        let rate = report.counters.get("frame_time_ms").and_then(|counter| counter.value.as_f64());
        let rate = rate.filter(|ms| *ms > 0.0).map(|ms| {
            let (size, unit) = units::scale("B/s", (read + written) / (ms * 1e-3));
            format!("{} {unit} on average", units::digits((read + written) / (ms * 1e-3) / size))
        });
        let sampled = report.counters.get("dram_read_bytes").map(margin).filter(|margin| !margin.is_empty());
        let sampled = sampled.map(|margin| format!("what is read: {margin} (95 %)"));
        let [read, written, both] = [read, written, read + written].map(shown);
        let parts = format!("{} {} read, {} {} written", read.0, read.1, written.0, written.1);
        out += &stat(
            "DRAM traffic",
            &both,
            &[Some(parts), sampled, rate].into_iter().flatten().collect::<Vec<_>>(),
        );
    }
    if let Some(energy) = figure("energy_mj") {
        out += &stat("Energy", &energy, &["an estimate".to_owned()]);
    }
    out += "</div>\n";
    out + &causes(&report.stack)
}

fn figure(counters: &Counters, id: &str) -> Option<(String, String)> {
    let counter = counters.get(id)?;
    units::scaled(&counter.value, &counter.unit)
}

fn stat(title: &str, (number, unit): &(String, String), notes: &[String]) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!(" <span>{}</span>", Escaped(unit)) };
    let notes: String = notes.iter().map(|note| format!("<small>{}</small>", Escaped(note))).collect();
    let words = if unit.is_empty() { " class=\"words\"" } else { "" };
    format!("<div><h3>{title}</h3><p{words}>{}{unit}</p>{notes}</div>\n", Escaped(number))
}

fn within(within: &Within) -> String {
    match within {
        Within::Known { of, frame_time, .. } => {
            format!("within {} % of rung {}; see This run", units::digits(100.0 * frame_time), of.name())
        }
        Within::Unknown { .. } => "error not known; see This run".to_owned(),
    }
}

/// The largest parts of the frame time.
fn causes(stack: &[TimePart]) -> String {
    let all: f64 = stack.iter().map(|part| part.seconds).sum();
    if all <= 0.0 {
        return String::new();
    }
    let mut parts: Vec<&TimePart> = stack.iter().collect();
    parts.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    let row = |(series, part): (usize, &&TimePart)| {
        let (share, ms) = (100.0 * part.seconds / all, units::digits(part.seconds * 1e3));
        format!(
            "<li><span>{}</span><b>{share:.1} %</b><span>{ms} ms</span><i class=\"{}\" style=\"width:{share:.3}%\"></i></li>\n",
            Escaped(&part.name),
            series_class(series)
        )
    };
    let rows: String = parts.iter().take(CAUSES).enumerate().map(row).collect();
    format!("<h3>Largest causes of the frame time</h3>\n<ol class=\"causes\">{rows}</ol>\n")
}
