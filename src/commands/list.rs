//! `raybudget list`: what there is to choose from, and what each counter means.

use crate::Outcome;
use crate::args::{Format, ListArgs, Listed};
use crate::console;
use gpumodel::{COUNTERS, GPUS, Gpu, PrimitiveLayout, Provenance, TECHNIQUES, Technique};
use reports::vendor::{Formula, GPU_FIGURES, Profiler, VendorInfo};
use serde_json::{Map, Value};
use tracer::Traversal;

/// Columns and rows; the first column is the name that other commands take.
struct Table {
    columns: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

pub(crate) fn run(args: &ListArgs) -> anyhow::Result<Outcome> {
    let table = table(args.what)?;
    console::print(&match args.format {
        Format::Text if args.what == Listed::Counters => counters_text()?,
        Format::Text => table.text(),
        Format::Json => table.json(),
        Format::Csv => table.csv()?,
    })?;
    Ok(Outcome::Done)
}

fn table(what: Listed) -> anyhow::Result<Table> {
    let table = |columns: &[&'static str], rows: Vec<Vec<String>>| Table { columns: columns.to_vec(), rows };
    let text = str::to_owned;
    Ok(match what {
        Listed::Gpus => {
            let mut rows = Vec::new();
            for builtin in GPUS {
                let gpu = Gpu::parse(builtin.toml, builtin.name)?;
                let known = gpu.provenance();
                let unit = gpu.ray_unit.as_ref().map_or("none", |unit| unit.scheduling.name());
                rows.push(vec![
                    text(builtin.name),
                    gpu.identity.title.clone(),
                    text(unit),
                    known.measured.to_string(),
                    known.vendor.to_string(),
                    known.driver.to_string(),
                    known.aggregator.to_string(),
                    known.estimate.to_string(),
                    share_known(known),
                ]);
            }
            table(
                &[
                    "gpu",
                    "description",
                    "ray unit",
                    "measured",
                    "vendor",
                    "driver",
                    "aggregator",
                    "estimate",
                    "known",
                ],
                rows,
            )
        }
        Listed::Scenes => table(
            &["scene", "triangles", "description"],
            scenes::BUILTINS
                .iter()
                .map(|scene| vec![text(scene.name), scene.triangles.to_string(), text(scene.description)])
                .collect(),
        ),
        Listed::Techniques => {
            let mut rows = Vec::new();
            for builtin in TECHNIQUES {
                let technique = Technique::parse(builtin.toml, builtin.name)?;
                let passes: Vec<&str> = technique.passes().into_iter().map(gpumodel::Pass::name).collect();
                rows.push(vec![text(builtin.name), passes.join(", "), technique.title]);
            }
            table(&["technique", "passes", "description"], rows)
        }
        Listed::Counters => counters_table()?,
        Listed::Traversals => table(
            &["accel", "traversal", "nodes per fetch", "stack"],
            Traversal::ALL
                .into_iter()
                .map(|traversal| {
                    let fetch = match traversal.node_fetch() {
                        tracer::NodeFetch::Single => "one",
                        tracer::NodeFetch::Pair => "two siblings",
                    };
                    vec![
                        text(traversal.accel().name()),
                        text(traversal.name()),
                        text(fetch),
                        text(stack(traversal)),
                    ]
                })
                .collect(),
        ),
        Listed::Layouts => table(
            &["layout", "bytes per triangle with normals", "of these in a second buffer, for shading"],
            PrimitiveLayout::ALL
                .into_iter()
                .map(|layout| {
                    vec![
                        text(layout.name()),
                        layout.records().bytes().to_string(),
                        layout.records().normal_bytes.to_string(),
                    ]
                })
                .collect(),
        ),
    })
}

fn stack(traversal: Traversal) -> &'static str {
    match traversal {
        Traversal::BvhRestartTrail { .. } => {
            "none, or a short one in registers (--short-stack); a trail of bits"
        }
        Traversal::WideShortStack { .. } => "short, in registers (--short-stack)",
        Traversal::KdPushDown { .. } => "none, or a short one in registers (--short-stack)",
        _ => match traversal.stack_use() {
            tracer::StackUse::Memory => "full, in private memory",
            tracer::StackUse::Registers => "short, in registers",
            tracer::StackUse::None => "none",
        },
    }
}

/// Figures that are measured or from the maker or its driver, in percent of all.
fn share_known(Provenance { measured, vendor, driver, aggregator, estimate }: Provenance) -> String {
    let known = measured + vendor + driver;
    format!("{} %", 100 * known / (known + aggregator + estimate).max(1))
}

/// Ours, then those of the profilers.
fn counters_table() -> anyhow::Result<Table> {
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

/// Counters are too wide for a table: a paragraph each, by group.
fn counters_text() -> anyhow::Result<String> {
    let mut out = String::new();
    let mut groups: Vec<&str> = Vec::new();
    for counter in COUNTERS {
        if !groups.contains(&counter.group) {
            groups.push(counter.group);
        }
    }
    for group in groups {
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

impl Table {
    fn text(&self) -> String {
        let heading: Vec<String> = self.columns.iter().map(|column| (*column).to_owned()).collect();
        let lines: Vec<&Vec<String>> = std::iter::once(&heading).chain(&self.rows).collect();
        let widths: Vec<usize> = (0..self.columns.len())
            .map(|column| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0))
            .collect();
        let mut out = String::new();
        for line in lines {
            let cells: Vec<String> =
                line.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
            out += cells.join("  ").trim_end();
            out.push('\n');
        }
        out
    }

    fn json(&self) -> String {
        let rows: Vec<Value> = self
            .rows
            .iter()
            .map(|row| {
                let fields = self.columns.iter().zip(row).map(|(column, cell)| {
                    let value = cell.parse::<u64>().map_or_else(|_| Value::from(cell.as_str()), Value::from);
                    (column.replace(' ', "_"), value)
                });
                Value::Object(fields.collect::<Map<String, Value>>())
            })
            .collect();
        format!("{:#}\n", Value::Array(rows))
    }

    fn csv(&self) -> anyhow::Result<String> {
        let mut table = csv::Writer::from_writer(Vec::new());
        table.write_record(&self.columns)?;
        for row in &self.rows {
            table.write_record(row)?;
        }
        Ok(String::from_utf8(table.into_inner()?)?)
    }
}
