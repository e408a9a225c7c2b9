//! A sweep as JSON.

use super::{Sweep, SweptPoint, effects, front};
use serde_json::{Map, Value, json};

/// The whole sweep as indented JSON with a final line feed.
///
/// # Panics
/// Never: all of it has a form in JSON.
pub fn write(sweep: &Sweep) -> String {
    let on_front = front(sweep);
    let objective = |objective: &super::Objective| json!({ "counter": objective.counter, "better": objective.direction.better() });
    let effect = |effect: super::Effect| {
        let axis = &sweep.axes[effect.axis];
        json!({
            "axis": axis.name,
            "value": axis.values[effect.value],
            "counter": sweep.objectives[effect.objective].counter,
            "ratio": effect.ratio,
            "combinations": effect.combinations,
        })
    };
    let point = |(index, point): (usize, &SweptPoint)| {
        let set = sweep.options.iter().zip(&point.values);
        let options: Map<String, Value> =
            set.filter_map(|(name, value)| Some((name.clone(), json!(value.as_ref()?)))).collect();
        json!({
            "point": point.id,
            "options": options,
            "pareto": on_front.contains(&index),
            "failure": point.outcome.as_ref().err(),
            "within": point.outcome.as_ref().ok().and_then(|figures| figures.within.as_ref()),
            "counters": point.outcome.as_ref().ok().map(|figures| &figures.counters),
        })
    };
    let all = json!({
        "title": sweep.title,
        "objectives": sweep.objectives.iter().map(objective).collect::<Vec<_>>(),
        "points": sweep.points.iter().enumerate().map(point).collect::<Vec<_>>(),
        "effects": effects(sweep).into_iter().map(effect).collect::<Vec<_>>(),
    });
    serde_json::to_string_pretty(&all).expect("names and finite numbers have a form in JSON") + "\n"
}
