//! Samples as text, CSV and JSON.

use super::{Counter, Frame, Limits, Samples, Sampling, Statement};
use crate::text::Style;
use crate::units;
use serde_json::{Value, json};
use std::fmt::Write;

macro_rules! line {
    ($out:expr) => { $out.push('\n') };
    ($out:expr, $($args:tt)*) => { writeln!($out, $($args)*).expect("a string takes every write") };
}

/// Columns of the CSV; errors, margins and coverage are ratios, run times seconds of one processor of this machine.
pub const COLUMNS: [&str; 14] = [
    "scene",
    "traversal",
    "gpu",
    "change",
    "part",
    "run_s",
    "replay_s",
    "speed",
    "counter",
    "seeds",
    "median_error",
    "p95_error",
    "median_margin",
    "coverage",
];

/// Everything as text with a final line feed.
pub fn text(sampling: &Sampling, style: Style) -> String {
    let Sampling { frames, seeds, .. } = sampling;
    let mut out = String::new();
    line!(out, "{}", style.bold("Samples of frames against their replays"));
    line!(out);
    for Statement { text, found, holds, .. } in sampling.statements() {
        line!(out, "{}  {text}", outcome(holds));
        line!(out, "      Found {found}.");
    }
    for frame in frames {
        line!(out);
        let title = format!(
            "{}: replayed in {} s, {seeds} samples of each part",
            frame.id(),
            units::digits(frame.replay_s)
        );
        line!(out, "{}", style.bold(&title));
        let heading = format!(
            "  {:>8}  {:>9}  {:>7}  {:<18}  {:>8}  {:>8}  {:>8}  {:>8}",
            "tiles", "time", "speed", "counter", "median", "95th %", "95 % CI", "covered"
        );
        line!(out, "{}", style.bold(&heading));
        for samples in &frame.samples {
            let Samples { part, run_s, counters } = samples;
            let mut lead = format!(
                "{:>6.1} %  {:>7} s  {:>6.1}x",
                100.0 * part,
                units::digits(*run_s),
                frame.speed(samples)
            );
            for counter in counters {
                let percent = |ratio: f64| format!("{:.2} %", 100.0 * ratio);
                line!(
                    out,
                    "  {lead:>28}  {:<18}  {:>8}  {:>8}  {:>8}  {:>6.0} %",
                    counter.id,
                    percent(counter.error_at(0.5)),
                    percent(counter.error_at(0.95)),
                    percent(counter.margin()),
                    100.0 * counter.coverage()
                );
                lead.clear();
            }
        }
    }
    out
}

fn outcome(holds: bool) -> &'static str {
    if holds { "pass" } else { "fail" }
}

/// One row for each frame, part and counter, with a heading.
pub fn csv_text(sampling: &Sampling) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let rows = rows(sampling).map(|(frame, samples, counter)| {
        [
            frame.scene.clone(),
            frame.traversal.clone(),
            frame.gpu.clone(),
            frame.change.clone().unwrap_or_default(),
            samples.part.to_string(),
            samples.run_s.to_string(),
            frame.replay_s.to_string(),
            frame.speed(samples).to_string(),
            counter.id.clone(),
            counter.errors.len().to_string(),
            counter.error_at(0.5).to_string(),
            counter.error_at(0.95).to_string(),
            counter.margin().to_string(),
            counter.coverage().to_string(),
        ]
    });
    for row in std::iter::once(COLUMNS.map(str::to_owned)).chain(rows) {
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}

fn rows(sampling: &Sampling) -> impl Iterator<Item = (&Frame, &Samples, &Counter)> {
    sampling.frames.iter().flat_map(|frame| {
        frame
            .samples
            .iter()
            .flat_map(move |samples| samples.counters.iter().map(move |counter| (frame, samples, counter)))
    })
}

/// `{rows, samples, limits, run}`: rows are the statements; `published` is null, for the reference is the project's own replay.
pub fn json_text(sampling: &Sampling, run: &Value) -> String {
    let statement = |Statement { id, text, found, holds }: Statement| {
        json!({
            "id": id,
            "statement": text,
            "outcome": outcome(holds),
            "ours": found,
            "published": null,
            "error": null,
            "why": found,
        })
    };
    let sample = |(frame, samples, counter): (&Frame, &Samples, &Counter)| {
        json!({
            "id": frame.id(),
            "change": frame.change,
            "part": samples.part,
            "run_s": samples.run_s,
            "replay_s": frame.replay_s,
            "counter": counter.id,
            "errors": counter.errors,
            "margins": counter.margins.iter().map(|margin| margin.is_finite().then_some(margin)).collect::<Vec<_>>(),
            "covered": counter.covered,
        })
    };
    let Limits { speed, error, covered } = sampling.limits;
    let whole = json!({
        "rows": sampling.statements().into_iter().map(statement).collect::<Vec<_>>(),
        "samples": rows(sampling).map(sample).collect::<Vec<_>>(),
        "limits": { "speed": speed, "error": error, "covered": covered },
        "run": run,
    });
    format!("{whole:#}\n")
}
