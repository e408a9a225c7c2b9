//! The comparison as JSON: `{rows, summary, limits, run}`.

use super::{Accuracy, Errors, Figures, Point, Statement, outcome, percent, signed};
use serde_json::{Value, json};

/// `run` is what the caller knows of the measurement. Rows are frames, and in `summary` the statements of all of them; `published` is
/// null, for nobody has published these figures: the `reference` is the project's own.
pub fn write(accuracy: &Accuracy, run: &Value) -> String {
    let rows: Vec<Value> = accuracy.points.iter().map(|point| row(accuracy, point)).collect();
    let [ours, reference] = accuracy.run_s();
    let errors = |groups: Vec<Errors>| -> Vec<Value> {
        let group = |Errors { name, frames, mean, worst }: Errors| json!({ "name": name, "frames": frames, "mean": mean, "worst": worst });
        groups.into_iter().map(group).collect()
    };
    let limits = accuracy.limits;
    let whole = json!({
        "rows": rows,
        "summary": {
            "rows": accuracy.statements().iter().map(statement).collect::<Vec<_>>(),
            "by_gpu": errors(accuracy.errors_by(|point| &point.gpu)),
            "by_scene": errors(accuracy.errors_by(|point| &point.scene)),
            "by_traversal": errors(accuracy.errors_by(|point| &point.traversal)),
            "run_s": { "ours": ours, "reference": reference, "ratio": reference / ours },
        },
        "limits": { "mean": limits.mean, "worst": limits.worst, "dram": limits.dram },
        "run": run,
    });
    format!("{whole:#}\n")
}

fn row(accuracy: &Accuracy, point: &Point) -> Value {
    let figures = |rung: &str, figures: &Figures| {
        let Figures { frame_time_ms, dram_read_bytes, dram_write_bytes, run_s } = figures;
        json!({
            "rung": rung,
            "frame_time_ms": frame_time_ms,
            "dram_read_bytes": dram_read_bytes,
            "dram_write_bytes": dram_write_bytes,
            "run_s": run_s,
        })
    };
    let misses = point.misses(&accuracy.limits);
    json!({
        "id": point.id(),
        "statement": super::of_point(accuracy),
        "outcome": outcome(misses.is_empty()),
        "ours": figures(&accuracy.ours, &point.ours),
        "published": null,
        "reference": figures(&accuracy.reference, &point.reference),
        "error": point.time_error(),
        "dram_error": point.dram_error(),
        "deciding_bound": point.deciding_bound,
        "why": misses.join("; "),
    })
}

fn statement(statement: &Statement) -> Value {
    let at = statement.at.as_ref().map(|at| format!(" at {at}")).unwrap_or_default();
    json!({
        "id": statement.id,
        "statement": statement.text,
        "outcome": outcome(statement.holds()),
        "ours": statement.found,
        "published": null,
        "error": statement.found,
        "why": format!("{}{at}, limit {}", signed(statement.found), percent(statement.limit)),
    })
}
