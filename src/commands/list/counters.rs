//! What each counter means: ours, and those of the makers' profilers.

use super::{Table, markdown_row};
use gpumodel::COUNTERS;
use reports::vendor::{Formula, GPU_FIGURES, Profiler, VendorInfo};

/// Ours, then those of the profilers.
pub(super) fn table() -> anyhow::Result<Table> {
    let columns = vec![
        "counter",
        "name",
        "group",
        "unit",
        "denominator",
        "formula",
        "profiler",
        "definition",
        "absent",
    ];
    let ours = COUNTERS.iter().map(|counter| {
        let gpumodel::CounterInfo { id, name, group, unit, formula, denominator } = *counter;
        [id, name, group, unit, denominator, formula, "", "", ""].map(str::to_owned).to_vec()
    });
    let mut rows: Vec<Vec<String>> = ours.collect();
    for profiler in Profiler::all()? {
        for info in &profiler.counters {
            let (formula, absent) = match &info.formula {
                Formula::Known(formula) => (formula.text(), ""),
                Formula::Absent { reason } => ("", reason.as_str()),
            };
            let VendorInfo { name, group, unit, definition, .. } = info;
            let row = [name, name, group, unit, "", formula, &profiler.name, definition, absent];
            rows.push(row.map(str::to_owned).to_vec());
        }
    }
    Ok(Table { columns, rows })
}

/// Groups of our counters, in the order of reports.
fn groups() -> Vec<&'static str> {
    let mut groups = Vec::new();
    for counter in COUNTERS {
        if !groups.contains(&counter.group) {
            groups.push(counter.group);
        }
    }
    groups
}

/// Counters are too wide for a table: a paragraph each, by group.
pub(super) fn text() -> anyhow::Result<String> {
    let mut out = String::new();
    for group in groups() {
        out += &format!("{group}\n");
        for counter in COUNTERS.iter().filter(|counter| counter.group == group) {
            out += &format!("  {} [{}]: {}\n", counter.id, counter.unit, counter.name);
            out += &format!("      {}", counter.formula);
            if !counter.denominator.is_empty() {
                out += &format!(" (per {})", counter.denominator);
            }
            out.push('\n');
        }
    }
    for profiler in Profiler::all()? {
        for group in profiler.groups() {
            out += &format!("\n{}: {group}\n", profiler.name);
            for info in profiler.counters.iter().filter(|info| info.group == group) {
                out += &vendor_text(info);
            }
        }
    }
    out += "\nFigures of the GPU in these formulas\n";
    for figure in GPU_FIGURES {
        out += &format!("  {}: {}\n", figure.name, figure.meaning);
    }
    Ok(out)
}

fn vendor_text(info: &VendorInfo) -> String {
    let VendorInfo { name, hardware, gpus, group: _, unit, definition, source: _, note, formula } = info;
    let mut out = format!("  {name} [{unit}]: {definition}");
    if !hardware.is_empty() {
        out += &format!(" ({hardware}; GPUs: {gpus})");
    }
    out += "\n      ";
    match formula {
        Formula::Known(formula) if note.is_empty() => out += formula.text(),
        Formula::Known(formula) => out += &format!("{}; {note}", formula.text()),
        Formula::Absent { reason } => out += &format!("absent: {reason}"),
    }
    out.push('\n');
    out
}

/// How the page of the guide begins.
const PAGE: &str = "\
# Every counter

Made by `raybudget list counters --format markdown`, from what the program itself counts by. The ids in the first column are the keys of `report.json` and `counters.csv`, and what a budget names. A counter that a scene or a GPU does not have
is absent from a report with its reason, never zero.
";

/// The page of the guide: a table for each group.
pub(super) fn markdown() -> anyhow::Result<String> {
    let mut out = PAGE.to_owned();
    for group in groups() {
        out += &heading(group, &["counter", "name", "unit", "how it is computed", "per"]);
        for counter in COUNTERS.iter().filter(|counter| counter.group == group) {
            let gpumodel::CounterInfo { id, name, group: _, unit, formula, denominator } = *counter;
            out += &markdown_row(&[&code(id), name, unit, formula, denominator]);
        }
    }
    for profiler in Profiler::all()? {
        for group in profiler.groups() {
            let columns = ["name", "unit", "what it counts", "how it is made of the counters above"];
            out += &heading(&format!("{}: {group}", profiler.name), &columns);
            let mut sources: Vec<&str> = Vec::new();
            for info in profiler.counters.iter().filter(|info| info.group == group) {
                out += &vendor_row(info);
                if !sources.contains(&info.source.as_str()) {
                    sources.push(&info.source);
                }
            }
            out += &format!("\nNames and definitions: {}.\n", sources.join("; "));
        }
    }
    out += &heading("Figures of the GPU in these formulas", &["figure", "what it is"]);
    for figure in GPU_FIGURES {
        out += &markdown_row(&[&code(figure.name), figure.meaning]);
    }
    Ok(out)
}

fn heading(title: &str, columns: &[&str]) -> String {
    let rule: Vec<&str> = columns.iter().map(|_| "---").collect();
    format!("\n## {title}\n\n{}{}", markdown_row(columns), markdown_row(&rule))
}

fn code(text: &str) -> String {
    format!("`{text}`")
}

fn vendor_row(info: &VendorInfo) -> String {
    let VendorInfo { name, hardware, gpus, group: _, unit, definition, source: _, note, formula } = info;
    let mut meaning = definition.clone();
    if !hardware.is_empty() {
        meaning += &format!("; `{hardware}`");
    }
    if !gpus.is_empty() {
        meaning += &format!("; GPUs: {gpus}");
    }
    let made = match formula {
        Formula::Known(formula) if note.is_empty() => code(formula.text()),
        Formula::Known(formula) => format!("{}; {note}", code(formula.text())),
        Formula::Absent { reason } => format!("absent: {reason}"),
    };
    markdown_row(&[name, unit, &meaning, &made])
}
