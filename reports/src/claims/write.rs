//! Verdicts as text, Markdown, JSON and CSV.

use super::model::Paper;
use super::verdict::{Outcome, ReadingVerdict, Verdict};
use crate::text::Style;
use serde_json::{Value, json};
use std::fmt::Write;

macro_rules! line {
    ($out:expr) => { $out.push('\n') };
    ($out:expr, $($args:tt)*) => { writeln!($out, $($args)*).expect("a string takes every write") };
}

impl Outcome {
    fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::NotReproduced => "NOT reproduced",
            Self::Untestable => "untestable",
        }
    }
}

const LINE_WIDTH: usize = 100;

/// Adds `text` behind `label`, broken at spaces, with later lines indented by `indent`.
fn wrapped(out: &mut String, label: &str, text: &str, indent: usize) {
    let mut width = label.chars().count();
    out.push_str(label);
    for (index, word) in text.split_whitespace().enumerate() {
        let length = word.chars().count();
        if index > 0 && width + 1 + length > LINE_WIDTH {
            *out += &format!("\n{:indent$}", "");
            width = indent;
        } else if index > 0 {
            out.push(' ');
            width += 1;
        }
        out.push_str(word);
        width += length;
    }
    out.push('\n');
}

fn count(verdicts: &[Verdict], outcome: Outcome) -> usize {
    verdicts.iter().filter(|verdict| verdict.outcome == outcome).count()
}

fn summary(verdicts: &[Verdict]) -> String {
    format!(
        "{} statements: {} reproduced, {} not reproduced, {} untestable",
        verdicts.len(),
        count(verdicts, Outcome::Reproduced),
        count(verdicts, Outcome::NotReproduced),
        count(verdicts, Outcome::Untestable)
    )
}

/// A table of outcomes, then each claim with its figures and readings.
pub fn text(paper: &Paper, verdicts: &[Verdict], style: Style) -> String {
    let bold = |text: &str| match style {
        Style::Plain => text.to_owned(),
        Style::Ansi => format!("\x1b[1m{text}\x1b[0m"),
    };
    let mut out = String::new();
    line!(out, "{}", bold(&paper.citation));
    if let Some(doi) = &paper.doi {
        line!(out, "doi:{doi}");
    }
    line!(out);
    let width = verdicts.iter().map(|verdict| verdict.id.chars().count()).max().unwrap_or(0);
    for verdict in verdicts {
        let label = format!("{:<width$}  {:<14}  ", verdict.id, verdict.outcome.words());
        wrapped(&mut out, &label, &verdict.statement, label.chars().count());
    }
    line!(out);
    line!(out, "{}", summary(verdicts));
    for verdict in verdicts {
        line!(out);
        line!(out, "{}", bold(&format!("{} {} ({})", verdict.id, verdict.outcome.words(), verdict.place)));
        wrapped(&mut out, "  ", &verdict.statement, 2);
        for (name, text) in details(verdict) {
            wrapped(&mut out, &format!("  {name}: "), &text, 4);
        }
        for reading in &verdict.readings {
            let ReadingVerdict { name, assumption, outcome, why, .. } = reading;
            wrapped(&mut out, "  - ", &format!("{}: {name} ({assumption}). {why}", outcome.words()), 4);
        }
    }
    out
}

/// What there is to say of a claim beside its readings.
fn details(verdict: &Verdict) -> Vec<(&'static str, String)> {
    let mut details = vec![("why", verdict.why.clone())];
    let mut add = |name, text: Option<String>| details.extend(text.map(|text| (name, text)));
    add("published", verdict.published.clone());
    add("largest error", verdict.error.map(super::finding::percent));
    add("note", verdict.note.clone());
    add("not tested", verdict.untested.clone());
    add("stand-ins", (!verdict.stand_ins.is_empty()).then(|| verdict.stand_ins.join(", ")));
    details
}

/// The table as Markdown: a row for each claim, and below it one for each reading.
pub fn markdown(paper: &Paper, verdicts: &[Verdict]) -> String {
    let cell = |text: &str| text.replace('|', "\\|").replace('\n', " ");
    let mut out = String::new();
    line!(out, "## {}", paper.citation);
    line!(out);
    let doi = paper.doi.as_ref().map_or(String::new(), |doi| format!("doi:{doi}. "));
    line!(out, "{doi}{}.", summary(verdicts));
    line!(out);
    line!(out, "| id | statement | outcome | published | why |");
    line!(out, "|---|---|---|---|---|");
    for verdict in verdicts {
        let mut why = vec![verdict.why.clone()];
        why.extend(verdict.note.iter().map(|note| format!("Note: {note}")));
        why.extend(verdict.untested.iter().map(|untested| format!("Not tested: {untested}")));
        if !verdict.stand_ins.is_empty() {
            why.push(format!("Stand-ins: {}", verdict.stand_ins.join(", ")));
        }
        line!(
            out,
            "| {} | {} ({}) | **{}** | {} | {} |",
            cell(&verdict.id),
            cell(&verdict.statement),
            cell(&verdict.place),
            verdict.outcome.words(),
            cell(verdict.published.as_deref().unwrap_or("")),
            cell(&why.join(". "))
        );
        for reading in &verdict.readings {
            line!(
                out,
                "| | {}: {} | {} | | {} |",
                cell(&reading.name),
                cell(&reading.assumption),
                reading.outcome.words(),
                cell(&reading.why)
            );
        }
    }
    out
}

/// `{paper, rows: [...], run}`; `run` is what the caller knows of the measurement.
pub fn json_text(paper: &Paper, verdicts: &[Verdict], run: &Value) -> String {
    let whole = json!({ "paper": paper, "rows": verdicts, "run": run });
    format!("{whole:#}\n")
}

/// One row for each claim (empty `reading`) and each reading, with a heading.
pub fn csv_text(verdicts: &[Verdict]) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let heading = ["id", "reading", "statement", "outcome", "ours", "published", "error", "why", "stand_ins"];
    let mut rows: Vec<[String; 9]> = vec![heading.map(str::to_owned)];
    for verdict in verdicts {
        let text = |text: &Option<String>| text.clone().unwrap_or_default();
        rows.push([
            verdict.id.clone(),
            String::new(),
            verdict.statement.clone(),
            verdict.outcome.name().to_owned(),
            text(&verdict.ours),
            text(&verdict.published),
            verdict.error.map(|error| error.to_string()).unwrap_or_default(),
            verdict.why.clone(),
            verdict.stand_ins.join("; "),
        ]);
        rows.extend(verdict.readings.iter().map(|reading| {
            [
                verdict.id.clone(),
                reading.name.clone(),
                verdict.statement.clone(),
                reading.outcome.name().to_owned(),
                text(&reading.ours),
                String::new(),
                String::new(),
                reading.why.clone(),
                String::new(),
            ]
        }));
    }
    for row in rows {
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}
