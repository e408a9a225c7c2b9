//! A sweep for eyes.

use super::front::{front, front_of};
use super::{GridAxis, Objective, Sweep, effects};
use crate::chart::{BarChart, LogLogChart, LogLogSeries, Scale, Series};
use crate::units;

/// All points by the first two objectives, each scene's Pareto front joined by a line; none where there is only one objective.
pub fn pareto(sweep: &Sweep) -> Option<LogLogChart> {
    let [x, y] = sweep.objectives.get(..2)? else { return None };
    let place = |index: usize| {
        let point = &sweep.points[index];
        Some((point.number(&x.counter)?, point.number(&y.counter)?))
    };
    let axis = |objective: &Objective| {
        let (name, unit) = units::counter_info(&objective.counter)
            .map_or((objective.counter.as_str(), ""), |info| (info.name, info.unit));
        let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
        format!("{name}{unit}, {} is better", objective.direction.better())
    };
    let series = |name: String, points: &[usize], joined: bool| LogLogSeries {
        name,
        points: points.iter().filter_map(|&index| place(index)).collect(),
        joined,
        exact_at: None,
    };
    let front_series = |scene: &Option<&str>| {
        let name =
            scene.map_or_else(|| "Pareto front".to_owned(), |scene| format!("Pareto front of {scene}"));
        series(name, &front_of(sweep, *scene), true)
    };
    let on_front = front(sweep);
    let others: Vec<usize> = (0..sweep.points.len()).filter(|index| !on_front.contains(index)).collect();
    let fronts = sweep.scenes();
    Some(LogLogChart {
        title: "Pareto front".to_owned(),
        subtitle: format!("{}, {} points", sweep.title, sweep.points.len()),
        x_label: axis(x),
        y_label: axis(y),
        series: fronts
            .iter()
            .map(front_series)
            .chain([series("other points".to_owned(), &others, false)])
            .collect(),
        limit: None,
    })
}

/// What each value of an axis does, with a name for its file: one chart for each axis with several values.
pub fn effects_of_axes(sweep: &Sweep) -> Vec<(String, BarChart)> {
    let all = effects(sweep);
    let chart = |(index, axis): (usize, &GridAxis)| {
        let of_axis = || all.iter().filter(|effect| effect.axis == index);
        let combinations = of_axis().map(|effect| effect.combinations).max()?;
        if axis.values.len() < 2 || combinations == 0 {
            return None;
        }
        let series = sweep.objectives.iter().enumerate().map(|(at, objective)| Series {
            name: units::counter_info(&objective.counter)
                .map_or_else(|| objective.counter.clone(), |info| info.name.to_owned()),
            values: of_axis().filter(|effect| effect.objective == at).map(|effect| effect.ratio).collect(),
        });
        let others = if combinations == 1 {
            String::new()
        } else {
            format!(", {combinations} combinations of the other axes")
        };
        let chart = BarChart {
            title: format!("What {} does", axis.name),
            subtitle: format!("{}{others}", sweep.title),
            value_label: format!("ratio to {}, geometric mean", axis.values[0]),
            groups: axis.values.clone(),
            series: series.collect(),
            scale: Scale::Linear,
        };
        Some((effect_stem(&sweep.axes, axis), chart))
    };
    sweep.axes.iter().enumerate().filter_map(chart).collect()
}

/// Letters of an axis in the name of its chart.
const MOST_LETTERS: usize = 60;

/// The name of an axis' chart, without its extension; no other axis has it.
pub fn effect_stem(axes: &[GridAxis], axis: &GridAxis) -> String {
    let plain = |axis: &GridAxis| -> String {
        let letters = axis.name.chars().take(MOST_LETTERS);
        letters.map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '-' }).collect()
    };
    let (own, before) = (plain(axis), axes.iter().take_while(|other| other.name != axis.name));
    match before.filter(|other| plain(other) == own).count() {
        0 => format!("effect-{own}"),
        twins => format!("effect-{own}-{}", twins + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_axis_has_a_chart_of_its_own_whatever_it_is_called() {
        let names = ["a b", "a-b", "a.b", "\u{6728}", "\u{6797}", &"x".repeat(300)];
        let axes = names.map(|name| GridAxis { name: name.to_owned(), values: Vec::new() });
        let stems: Vec<String> = axes.iter().map(|axis| effect_stem(&axes, axis)).collect();
        assert_eq!(stems[..5], ["effect-a-b", "effect-a-b-2", "effect-a-b-3", "effect--", "effect---2"]);
        assert!(stems[5].len() < 100, "{}", stems[5]);
    }
}
