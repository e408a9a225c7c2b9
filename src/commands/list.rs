//! `raybudget list`: what there is to choose from, and what each counter means.

mod counters;

use crate::Outcome;
use crate::args::{ListArgs, ListFormat, Listed};
use crate::console;
use gpumodel::{GPUS, Gpu, PrimitiveLayout, Provenance, TECHNIQUES, Technique};
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
        ListFormat::Text if args.what == Listed::Counters => counters::text()?,
        ListFormat::Markdown if args.what == Listed::Counters => counters::markdown()?,
        ListFormat::Text => table.text(),
        ListFormat::Json => table.json(),
        ListFormat::Csv => table.csv()?,
        ListFormat::Markdown => table.markdown(),
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
        Listed::Counters => counters::table()?,
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

    fn markdown(&self) -> String {
        let rule = vec!["---".to_owned(); self.columns.len()];
        let heading: Vec<String> = self.columns.iter().map(|column| (*column).to_owned()).collect();
        [heading, rule].iter().chain(&self.rows).map(|cells| markdown_row(cells)).collect()
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

/// A line of a table in Markdown.
fn markdown_row<S: AsRef<str>>(cells: &[S]) -> String {
    let cells = cells.iter().map(|cell| format!(" {} |", cell.as_ref().replace('|', "\\|")));
    format!("|{}\n", cells.collect::<String>())
}
