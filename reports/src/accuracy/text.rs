//! The comparison for a terminal: what is stated of all frames, means of groups, then every frame.

use super::{Accuracy, Errors, Point, outcome, percent, signed};
use crate::text::Style;
use crate::units;
use std::fmt::Write;

macro_rules! line {
    ($out:expr) => { $out.push('\n') };
    ($out:expr, $($args:tt)*) => { writeln!($out, $($args)*).expect("a string takes every write") };
}

/// Everything as text with a final line feed.
pub fn write(accuracy: &Accuracy, style: Style) -> String {
    let Accuracy { ours, reference, points, limits } = accuracy;
    let mut out = String::new();
    line!(out, "{}", style.bold(&format!("Frames on the rung '{ours}' against the rung '{reference}'")));
    line!(out);
    for statement in accuracy.statements() {
        let at = statement.at.as_ref().map(|at| format!(" at {at}")).unwrap_or_default();
        line!(out, "{}  {}", outcome(statement.holds()), statement.text);
        line!(out, "      Found {}{at}.", signed(statement.found));
    }
    let misses = points.iter().filter(|point| !point.misses(limits).is_empty()).count();
    line!(out, "{} frames, {} of them beyond a limit.", points.len(), misses);
    let groups = [
        ("GPU", accuracy.errors_by(|point| &point.gpu)),
        ("scene", accuracy.errors_by(|point| &point.scene)),
        ("traversal", accuracy.errors_by(|point| &point.traversal)),
    ];
    write_groups(&mut out, &groups, style);
    write_points(&mut out, accuracy, style);
    let [ours_s, reference_s] = accuracy.run_s();
    line!(out);
    line!(
        out,
        "Processor time for all frames: {ours} {} s, {reference} {} s, {} times as long.",
        units::digits(ours_s),
        units::digits(reference_s),
        units::digits(reference_s / ours_s)
    );
    out
}

fn write_groups(out: &mut String, groups: &[(&str, Vec<Errors>)], style: Style) {
    let names = groups
        .iter()
        .flat_map(|(title, errors)| errors.iter().map(|errors| errors.name.as_str()).chain([*title]));
    let width = names.map(|name| name.chars().count()).max().unwrap_or(0);
    for (title, errors) in groups {
        line!(out);
        let heading = format!("{title:<width$}  {:>6}  {:>9}  {:>9}", "frames", "mean", "worst");
        line!(out, "{}", style.bold(&heading));
        for Errors { name, frames, mean, worst } in errors {
            let [mean, worst] = [mean, worst].map(|error| format!("{:.1} %", 100.0 * error));
            line!(out, "{name:<width$}  {frames:>6}  {mean:>9}  {worst:>9}");
        }
    }
}

fn write_points(out: &mut String, accuracy: &Accuracy, style: Style) {
    let Accuracy { ours, reference, points, limits } = accuracy;
    let width = |of: fn(&Point) -> &str, least: usize| {
        points.iter().map(|point| of(point).chars().count()).max().unwrap_or(0).max(least)
    };
    let (gpu_width, bound_width) = (width(|point| &point.gpu, 3), width(|point| &point.deciding_bound, 8));
    let heading = format!(
        "  {:<gpu_width$}  {:>9}  {:>9}  {:>8}  {:>8}  {:>7}  {:<bound_width$}  {:>7}  {:>7}",
        "GPU", ours, reference, "error", "DRAM", "error", "decided", ours, reference
    );
    let units = format!(
        "  {:<gpu_width$}  {:>9}  {:>9}  {:>8}  {:>8}  {:>7}  {:<bound_width$}  {:>7}  {:>7}",
        "", "ms", "ms", "", "MiB", "", "by", "s", "s"
    );
    line!(out);
    line!(out, "{}", style.bold(&heading));
    line!(out, "{}", style.bold(units.trim_end()));
    let mut frame = ("", "");
    for point in points {
        if frame != (point.scene.as_str(), point.traversal.as_str()) {
            frame = (&point.scene, &point.traversal);
            line!(out, "{} {}", point.scene, point.traversal);
        }
        let mark = if point.misses(limits).is_empty() { "" } else { "  fail" };
        line!(
            out,
            "  {:<gpu_width$}  {:>9}  {:>9}  {:>8}  {:>8.2}  {:>7}  {:<bound_width$}  {:>7.2}  {:>7.2}{mark}",
            point.gpu,
            units::digits(point.ours.frame_time_ms),
            units::digits(point.reference.frame_time_ms),
            signed(point.time_error()),
            point.reference.dram_bytes() / (1024.0 * 1024.0),
            signed(point.dram_error()),
            point.deciding_bound,
            point.ours.run_s,
            point.reference.run_s,
        );
    }
    line!(out);
    line!(
        out,
        "DRAM is read and written bytes on '{reference}'. A frame fails beyond {} of time or {} of DRAM bytes.",
        percent(limits.worst),
        percent(limits.dram)
    );
}
