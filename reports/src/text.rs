//! The report as a profiler's counter list: groups of counters, under the names of the maker's profiler where there is one, one column for the
//! frame and one for each pass; then
//! the bounds, what was left out, what is an estimate, and what the run cost.

use crate::counters::{Counter, Counters, Value};
use crate::report::{Bound, Buffer, Energy, EnergyCause, Forced, Inputs, Report, Run, TimePart};
use crate::units;
use crate::vendor::{Formula, Profiler, VendorCounter, VendorInfo, VendorPass, VendorView};
use gpumodel::COUNTERS;
use std::fmt::Write;

/// Whether the text may hold terminal escapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Text only.
    Plain,
    /// Headings in bold.
    Ansi,
}

impl Style {
    pub(crate) fn bold(self, text: &str) -> String {
        match self {
            Self::Plain => text.to_owned(),
            Self::Ansi => format!("\x1b[1m{text}\x1b[0m"),
        }
    }
}

const NAME_WIDTH: usize = 32;
const NUMBER_WIDTH: usize = 14;
const UNIT_WIDTH: usize = 7;
const MARGIN_WIDTH: usize = 20;
const BUFFER_WIDTH: usize = 18;
const CAUSE_WIDTH: usize = 40;
const DOMAIN_WIDTH: usize = 14;
/// Text wraps at this width.
pub(crate) const LINE_WIDTH: usize = 100;

/// The whole report as text with a final line feed.
pub fn write(report: &Report, style: Style) -> String {
    let mut out = String::new();
    heading(&mut out, &report.tool, &report.inputs, style);
    counters(&mut out, report, style);
    absent(&mut out, report, style);
    stack(&mut out, &report.stack, style);
    energy(&mut out, report.energy.as_ref(), style);
    crate::sustained::write(&mut out, report.sustained.as_ref(), style);
    bounds(&mut out, &report.bounds, report.deciding_bound.as_deref(), style);
    buffers(&mut out, &report.buffers, style);
    let left_out: Vec<String> =
        report.left_out.iter().map(|entry| format!("{}: {}", entry.what, entry.why)).collect();
    sentences(&mut out, "Left out of these figures", &left_out, style);
    let forced: Vec<String> = report
        .forced
        .iter()
        .map(|Forced { what, choice, cost, .. }| format!("{what}, forced {choice}: {cost}"))
        .collect();
    sentences(&mut out, "Forced against the needs of the scene", &forced, style);
    sentences(&mut out, "Estimates and assumptions", &report.assumptions, style);
    sentences(&mut out, "The scene", &report.notes, style);
    run(&mut out, &report.run, style);
    out
}

macro_rules! line {
    ($out:expr) => { $out.push('\n') };
    ($out:expr, $($args:tt)*) => { writeln!($out, $($args)*).expect("a string takes every write") };
}

fn heading(out: &mut String, tool: &str, inputs: &Inputs, style: Style) {
    let size = match (inputs.width, inputs.height) {
        (Some(width), Some(height)) => format!("{width}x{height} pixels"),
        _ => "a list of rays".to_owned(),
    };
    line!(out, "{}", style.bold(&format!("{} on {}", inputs.scene, inputs.gpu)));
    line!(
        out,
        "{} triangles, {size}, {} rays{}{}; {} with {} traversal{}, Ct {} Ci {}; {} primitives; {}",
        units::grouped(u64::from(inputs.triangles)),
        inputs.ray_sets.join(" + "),
        inputs.samples_per_pixel.map_or(String::new(), |samples| format!(", {samples} samples per pixel")),
        inputs.shadow_query.as_ref().map_or(String::new(), |query| format!(", shadows by {query}")),
        inputs.accel,
        inputs.traversal,
        details(inputs),
        inputs.sah_costs[0],
        inputs.sah_costs[1],
        inputs.layout,
        inputs.technique,
    );
    line!(
        out,
        "{tool}; scene {}, gpu {}, costs {}",
        inputs.hashes.scene,
        inputs.hashes.gpu,
        inputs.hashes.costs
    );
}

fn details(inputs: &Inputs) -> String {
    let mut parts = Vec::new();
    parts.extend(inputs.node_format.as_ref().map(|format| format!("{format} nodes")));
    parts.extend(inputs.ray_unit.as_ref().map(|unit| format!("ray unit by {unit}")));
    parts.extend(inputs.trail_bits.map(|bits| format!("{bits}-bit trail")));
    if inputs.short_stack > 0 {
        parts.push(format!("short stack of {}", inputs.short_stack));
    }
    if parts.is_empty() { String::new() } else { format!(" ({})", parts.join(", ")) }
}

/// A figure and its unit; none where there is not even a reason for its absence.
type Cell = Option<(Value, String)>;

/// A counter: a cell for the frame and each pass, and how far the frame's may be off.
struct Row {
    name: String,
    margin: String,
    cells: Vec<Cell>,
}

/// Counters under one title.
struct Group {
    title: String,
    rows: Vec<Row>,
}

fn counters(out: &mut String, report: &Report, style: Style) {
    let groups = groups(report);
    let names = groups.iter().flat_map(|group| group.rows.iter().map(|row| row.name.chars().count()));
    // Only the figures of a sample may be off.
    let margin_width = if report.is_sampled() { MARGIN_WIDTH } else { 0 };
    let name_width = names.max().unwrap_or(0).max(NAME_WIDTH - 4) + 4;
    for Group { title, rows } in groups {
        line!(out);
        let mut titles = format!("{title:<name_width$}{:>NUMBER_WIDTH$} {:<UNIT_WIDTH$}", "frame", "");
        if margin_width > 0 {
            write!(titles, "{:<margin_width$}", "95 %").expect("a string takes every write");
        }
        for pass in &report.passes {
            write!(titles, "{:>NUMBER_WIDTH$} {:<UNIT_WIDTH$}", pass.name, "")
                .expect("a string takes every write");
        }
        line!(out, "{}", style.bold(titles.trim_end()));
        for Row { name, margin, cells } in rows {
            let (frame, passes) = cells.split_at(1);
            let [frame, passes] = [frame, passes].map(|cells| cells.iter().map(cell).collect::<String>());
            let line =
                format!("  {name:<width$}{frame}{margin:<margin_width$}{passes}", width = name_width - 2);
            line!(out, "{}", line.trim_end());
        }
    }
}

/// What belongs to rays and to the frame comes first, then the profiler's groups where the report has such a view, then the rest of ours
/// that the profiler does not only call otherwise.
fn groups(report: &Report) -> Vec<Group> {
    let view = vendor_view(report);
    let renamed = view.as_ref().map(|(_, profiler)| renamed(profiler)).unwrap_or_default();
    let mut ours: Vec<Group> = Vec::new();
    for info in COUNTERS.iter().filter(|info| !renamed.contains(&info.id)) {
        if report.counters.get(info.id).is_none() {
            continue;
        }
        let of = |counters: &Counters| {
            counters.get(info.id).map(|counter| (counter.value.clone(), counter.unit.clone()))
        };
        let cells =
            std::iter::once(&report.counters).chain(report.passes.iter().map(|pass| &pass.counters)).map(of);
        let margin = report.counters.get(info.id).map(margin).unwrap_or_default();
        let row = Row { name: info.name.to_owned(), margin, cells: cells.collect() };
        match ours.iter_mut().find(|group| group.title == info.group) {
            Some(group) => group.rows.push(row),
            None => ours.push(Group { title: info.group.to_owned(), rows: vec![row] }),
        }
    }
    if let Some((view, profiler)) = view {
        let before = ours.len().min(2);
        ours.splice(before..before, vendor_groups(view, &profiler, &report.counters));
    }
    ours
}

/// The profiler's view and the profiler, where this version knows it.
pub(crate) fn vendor_view(report: &Report) -> Option<(&VendorView, Profiler)> {
    let view = report.vendor.as_ref()?;
    let profiler = Profiler::all().ok()?.into_iter().find(|profiler| profiler.name == view.profiler)?;
    Some((view, profiler))
}

/// Our counters that the profiler only calls otherwise.
fn renamed(profiler: &Profiler) -> Vec<&'static str> {
    let renames = |info: &VendorInfo| match &info.formula {
        Formula::Known(formula) => formula.renames().and_then(units::counter_info).map(|info| info.id),
        Formula::Absent { .. } => None,
    };
    profiler.counters.iter().filter_map(renames).collect()
}

fn vendor_groups(view: &VendorView, profiler: &Profiler, ours: &Counters) -> Vec<Group> {
    let row = |info: &VendorInfo| {
        let VendorCounter { value, unit, .. } = view.counters.get(&info.name)?;
        value.as_f64()?;
        let of_pass = |pass: &VendorPass| {
            let figure = pass.counters.get(&info.name).copied().flatten();
            let value = match (figure, value) {
                // A count of the frame is one of its passes too.
                (Some(figure), Value::Count(_)) if figure.fract() == 0.0 => Value::Count(figure as u64),
                (Some(figure), _) => Value::Real(figure),
                (None, _) => Value::Absent { reason: String::new() },
            };
            Some((value, unit.clone()))
        };
        let cells =
            std::iter::once(Some((value.clone(), unit.clone()))).chain(view.passes.iter().map(of_pass));
        // Of a formula of several counters it is not known.
        let renamed = match &info.formula {
            Formula::Known(formula) => formula.renames().and_then(|id| ours.get(id)),
            Formula::Absent { .. } => None,
        };
        let margin = renamed.map(margin).unwrap_or_default();
        Some(Row { name: info.name.clone(), margin, cells: cells.collect() })
    };
    let group = |title: &str| {
        let rows: Vec<_> =
            profiler.counters.iter().filter(|info| info.group == title).filter_map(row).collect();
        Group { title: format!("{}: {title}", profiler.name), rows }
    };
    profiler.groups().into_iter().map(group).filter(|group| !group.rows.is_empty()).collect()
}

/// How far a counter of a sample may be off, as a part of it.
pub(crate) fn margin(counter: &Counter) -> String {
    match counter.value.as_f64().zip(counter.ci95) {
        None => String::new(),
        Some((_, [low, high])) if low == high => "exact".to_owned(),
        Some((value, interval)) => reach(value, interval),
    }
}

/// How far an interval reaches from the value in it, as a part of that.
pub(crate) fn reach(value: f64, [low, high]: [f64; 2]) -> String {
    if !(low.is_finite() && high.is_finite()) {
        return "± unknown".to_owned();
    }
    if value == 0.0 {
        return format!("{} to {}", units::digits(low), units::digits(high));
    }
    let [below, above] = [1.0 - low / value, high / value - 1.0].map(|part| 100.0 * part);
    // What one decimal place cannot tell apart is one number, the larger.
    if (above - below).abs() < 0.1 {
        format!("± {:.1} %", above.max(below))
    } else {
        format!("-{below:.1} to +{above:.1} %")
    }
}

fn cell(figure: &Cell) -> String {
    let Some((value, unit)) = figure else {
        return " ".repeat(NUMBER_WIDTH + 1 + UNIT_WIDTH);
    };
    let (number, unit) = units::scaled(value, unit).unwrap_or(("-".into(), String::new()));
    format!("{number:>NUMBER_WIDTH$} {unit:<UNIT_WIDTH$}")
}

fn absent(out: &mut String, report: &Report, style: Style) {
    for (title, absent) in absent_sentences(report) {
        sentences(out, &title, &absent, style);
    }
}

/// Titles, and under each the counters that are absent, by reason.
pub(crate) fn absent_sentences(report: &Report) -> Vec<(String, Vec<String>)> {
    let view = vendor_view(report);
    let renamed = view.as_ref().map(|(_, profiler)| renamed(profiler)).unwrap_or_default();
    let ours = report.counters.iter().filter(|(id, _)| !renamed.contains(id)).filter_map(|(id, counter)| {
        match &counter.value {
            Value::Absent { reason } => Some((units::counter_info(id).map_or(id, |info| info.name), reason)),
            _ => None,
        }
    });
    let mut all = vec![("Absent counters".to_owned(), by_reason(ours))];
    if let Some((view, profiler)) = &view {
        let theirs =
            profiler.counters.iter().filter_map(|info| match &view.counters.get(&info.name)?.value {
                Value::Absent { reason } => Some((info.name.as_str(), reason)),
                _ => None,
            });
        all.push((format!("Absent counters of {}", profiler.name), by_reason(theirs)));
    }
    all
}

/// A sentence for each reason, with all counters that are absent for it.
fn by_reason<'a>(absent: impl Iterator<Item = (&'a str, &'a String)>) -> Vec<String> {
    let mut reasons: Vec<(&String, Vec<&str>)> = Vec::new();
    for (name, reason) in absent {
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, names)) => names.push(name),
            None => reasons.push((reason, vec![name])),
        }
    }
    reasons.into_iter().map(|(reason, names)| format!("{}: {reason}", names.join(", "))).collect()
}

fn stack(out: &mut String, parts: &[TimePart], style: Style) {
    let total: f64 = parts.iter().map(|part| part.seconds).sum();
    if total <= 0.0 {
        return;
    }
    line!(out);
    line!(out, "{}", style.bold("What the frame time is made of"));
    let mut parts: Vec<&TimePart> = parts.iter().collect();
    parts.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    for TimePart { name, seconds } in parts {
        let (milliseconds, share) = (units::digits(seconds * 1e3), 100.0 * seconds / total);
        line!(out, "  {name:<width$}{milliseconds:>NUMBER_WIDTH$} ms {share:>6.1} %", width = NAME_WIDTH - 2);
    }
}

fn energy(out: &mut String, energy: Option<&Energy>, style: Style) {
    let Some(Energy { process, volts, volts_from, celsius, causes }) = energy else { return };
    line!(out);
    line!(
        out,
        "{}",
        style.bold(&format!(
            "What the energy is made of ({process}, {volts:.3} V of its {volts_from}, {celsius} degrees Celsius)"
        ))
    );
    let titles = format!(
        "  {:<CAUSE_WIDTH$}{:>NUMBER_WIDTH$}    {:>8}  {:<DOMAIN_WIDTH$}{:<DOMAIN_WIDTH$}{}",
        "cause", "energy", "share", "domain", "boundary", "figure"
    );
    line!(out, "{titles}");
    let mut causes: Vec<&EnergyCause> = causes.iter().collect();
    causes.sort_by(|a, b| b.mj.total_cmp(&a.mj));
    for EnergyCause { cause, mj, share, domain, boundary, tag } in causes {
        let (energy, share) = (units::digits(*mj), 100.0 * share);
        line!(
            out,
            "  {cause:<CAUSE_WIDTH$}{energy:>NUMBER_WIDTH$} mJ {share:>6.1} %  {domain:<DOMAIN_WIDTH$}{boundary:<DOMAIN_WIDTH$}{tag}"
        );
    }
}

fn bounds(out: &mut String, bounds: &[Bound], deciding: Option<&str>, style: Style) {
    if bounds.is_empty() {
        return;
    }
    line!(out);
    line!(out, "{}", style.bold("Lower bounds of the frame time"));
    for Bound { name, seconds } in bounds {
        let mark = if deciding == Some(name) { "  <- the largest" } else { "" };
        let milliseconds = units::digits(seconds * 1e3);
        line!(out, "  {name:<width$}{milliseconds:>NUMBER_WIDTH$} ms{mark}", width = NAME_WIDTH - 2);
    }
}

fn buffers(out: &mut String, buffers: &[Buffer], style: Style) {
    if buffers.is_empty() {
        return;
    }
    let columns = ["size", "lines touched", "lines missed", "read from DRAM"];
    let heading: String = columns.iter().map(|column| format!("{column:>BUFFER_WIDTH$}")).collect();
    line!(out);
    line!(out, "{}", style.bold(&format!("{:<width$}{heading}", "Buffers", width = NAME_WIDTH - 8)));
    let bytes = |bytes: u64| {
        let (number, unit) = units::scaled(&Value::Count(bytes), "B").unwrap_or_default();
        format!("{number} {unit}")
    };
    for Buffer { name, bytes: size, line_accesses, line_misses, dram_read_bytes, dram_write_bytes: _ } in
        buffers
    {
        let figures = [
            bytes(*size),
            units::grouped(*line_accesses),
            units::grouped(*line_misses),
            bytes(*dram_read_bytes),
        ];
        let figures: String = figures.iter().map(|figure| format!("{figure:>BUFFER_WIDTH$}")).collect();
        line!(out, "  {name:<width$}{figures}", width = NAME_WIDTH - 10);
    }
}

/// A list of sentences under a title; nothing without a sentence.
pub(crate) fn sentences(out: &mut String, title: &str, sentences: &[String], style: Style) {
    if sentences.is_empty() {
        return;
    }
    line!(out);
    line!(out, "{}", style.bold(title));
    for sentence in sentences {
        let mut column = 0;
        for word in sentence.split_whitespace() {
            let width = word.chars().count();
            if column == 0 {
                write!(out, "  - {word}").expect("a string takes every write");
                column = 4 + width;
            } else if column + 1 + width > LINE_WIDTH {
                write!(out, "\n    {word}").expect("a string takes every write");
                column = 4 + width;
            } else {
                write!(out, " {word}").expect("a string takes every write");
                column += 1 + width;
            }
        }
        line!(out);
    }
}

fn run(out: &mut String, run: &Run, style: Style) {
    let Run {
        wall_s,
        peak_rss_bytes,
        fidelity,
        sampled_fraction,
        threads,
        load_s,
        build_s,
        replay_s,
        within,
    } = run;
    let seconds = |s: f64| format!("{s:.3} s");
    line!(out);
    line!(out, "{}", style.bold("This run"));
    let mut row = |name: &str, value: String| line!(out, "  {name:<width$}{value}", width = NAME_WIDTH - 2);
    let part = if *sampled_fraction < 1.0 {
        format!(" of {} % of the tiles", units::digits(sampled_fraction * 100.0))
    } else {
        ", every access".to_owned()
    };
    row("fidelity", format!("{}{part}", fidelity.name()));
    let build = build_s.map(|s| format!(", build {}", seconds(s))).unwrap_or_default();
    row(
        "wall time",
        format!(
            "{} (load {}{build}, trace and replay {})",
            seconds(*wall_s),
            seconds(*load_s),
            seconds(*replay_s)
        ),
    );
    if let Some(bytes) = peak_rss_bytes {
        let (number, unit) = units::scaled(&Value::Count(*bytes), "B").expect("a count is a figure");
        row("peak memory", format!("{number} {unit}"));
    }
    row("threads", threads.to_string());
    if let Some(within) = within {
        row("within", within.text());
    }
}
