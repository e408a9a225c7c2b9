//! A sweep for a terminal: the Pareto front, what each value of an axis does, and which points have no figures.

use super::{Effect, Sweep, effects, front};
use crate::columns::{Column, write_rows};
use crate::text::{Style, sentences};
use crate::units;
use crate::within::Within;

/// Rows of a front that are shown; the file has all.
const MOST_ROWS: usize = 30;

/// The whole sweep as text with a final line feed.
pub fn write(sweep: &Sweep, style: Style) -> String {
    let mut out = format!("{}\n", style.bold(&sweep.title));
    let on_front = front(sweep);
    let (points, best) = (sweep.points.len(), on_front.len());
    let goals: Vec<String> = sweep
        .objectives
        .iter()
        .map(|objective| format!("{} {}", objective.direction.better(), objective.counter))
        .collect();
    let fronts =
        if sweep.scenes().len() > 1 { "the Pareto front of their scene" } else { "the Pareto front" };
    out += &format!("{points} points, {best} on {fronts}: {}\n", goals.join(", "));
    write_front(&mut out, sweep, &on_front, style);
    write_effects(&mut out, sweep, style);
    let failed = sweep.points.iter().filter_map(|point| {
        let reason = point.outcome.as_ref().err()?;
        Some(format!("{}: {reason}.", shown(sweep, &point.values)))
    });
    sentences(&mut out, "Points without figures", &failed.collect::<Vec<_>>(), style);
    let stated = sweep.points.iter().filter_map(|point| point.outcome.as_ref().ok()?.within.as_ref());
    sentences(&mut out, "How far the figures may be off", &Within::told(stated), style);
    out
}

/// The varying options of a point in words.
fn shown(sweep: &Sweep, values: &[Option<String>]) -> String {
    let option = |option: usize| Some(format!("{} {}", sweep.options[option], values[option].as_deref()?));
    sweep.varying().into_iter().filter_map(option).collect::<Vec<_>>().join(", ")
}

fn write_front(out: &mut String, sweep: &Sweep, on_front: &[usize], style: Style) {
    let rows = &on_front[..on_front.len().min(MOST_ROWS)];
    if rows.is_empty() {
        return;
    }
    let option = |option: usize| {
        let cells = rows.iter().map(|&row| sweep.points[row].values[option].clone().unwrap_or_default());
        Column::words([sweep.options[option].clone(), String::new()].into_iter().chain(cells).collect())
    };
    let objective = |counter: &str| {
        let (name, unit) = units::counter_info(counter).map_or((counter, ""), |info| (info.name, info.unit));
        let numbers: Vec<f64> = rows.iter().filter_map(|&row| sweep.points[row].number(counter)).collect();
        let (size, scaled) = units::scale(unit, numbers.iter().copied().fold(0.0, f64::max));
        let heads = [name.to_owned(), scaled.to_owned()];
        let cells = numbers.iter().map(|number| units::digits(number / size));
        Column::figures(heads.into_iter().chain(cells).collect())
    };
    let options = sweep.varying().into_iter().map(option);
    let columns: Vec<Column> =
        options.chain(sweep.objectives.iter().map(|each| objective(&each.counter))).collect();
    out.push('\n');
    write_rows(out, &columns.iter().collect::<Vec<_>>(), 2, style);
    if rows.len() < on_front.len() {
        *out += &format!("and {} more\n", on_front.len() - rows.len());
    }
}

fn write_effects(out: &mut String, sweep: &Sweep, style: Style) {
    let all = effects(sweep);
    let varied = |effect: &&Effect| effect.objective == 0 && sweep.axes[effect.axis].values.len() > 1;
    let rows: Vec<&Effect> = all.iter().filter(varied).collect();
    if rows.is_empty() {
        return;
    }
    let words = |heading: &str, cell: &dyn Fn(&Effect) -> String| {
        Column::words(std::iter::once(heading.to_owned()).chain(rows.iter().map(|row| cell(row))).collect())
    };
    let ratio = |objective: usize| {
        let of = |row: &&Effect| {
            let same = |other: &&Effect| {
                (other.axis, other.value, other.objective) == (row.axis, row.value, objective)
            };
            let ratio = all.iter().find(same).and_then(|effect| effect.ratio);
            ratio.map_or_else(|| "-".to_owned(), |ratio| format!("{ratio:.3}"))
        };
        let heading = sweep.objectives[objective].counter.clone();
        Column::figures(std::iter::once(heading).chain(rows.iter().map(of)).collect())
    };
    let axis = words("axis", &|row| sweep.axes[row.axis].name.clone());
    let value = words("value", &|row| sweep.axes[row.axis].values[row.value].clone());
    let ratios: Vec<Column> = (0..sweep.objectives.len()).map(ratio).collect();
    *out += &format!(
        "\n{}\n",
        style
            .bold("What each value does: ratio to the first of its axis, geometric mean over the other axes")
    );
    let columns: Vec<&Column> = [&axis, &value].into_iter().chain(&ratios).collect();
    write_rows(out, &columns, 1, style);
}
