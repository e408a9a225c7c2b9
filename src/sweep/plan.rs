//! The file that describes a sweep.
//!
//! ```toml
//! minimize = ["frame_time_ms", "dram_read_bytes"]
//!
//! [base]                                     # options of every point
//! size = "256x256"
//!
//! [grid]                                     # every combination, the last axis varying fastest
//! scene = ["cornell", "atrium"]
//! tree = [{ accel = "bvh" }, { accel = "kd", traversal = "push-down" }]
//! cache.uche.size = [65536, 131072]
//!
//! [[point]]                                  # one point each
//! scene = "chess"
//! gpu = "mali-g715"
//! ```

use crate::args::DEFAULT_SCENE;
use crate::options::{Options, RawOptions, figures_of, in_order, value_text};
use anyhow::{anyhow, bail};
use reports::sweep::{Direction, GridAxis, Objective};
use serde::Deserialize;
use toml::{Spanned, Value};

/// Most points of a sweep.
const MOST_POINTS: usize = 10_000;
/// What is best unless told otherwise.
const OBJECTIVES: [&str; 2] = ["frame_time_ms", "dram_read_bytes"];

/// What a file asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plan {
    pub(crate) axes: Vec<GridAxis>,
    pub(crate) objectives: Vec<Objective>,
    /// Those of the grid first.
    pub(crate) points: Vec<PlannedPoint>,
}

/// One point as it was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PlannedPoint {
    pub(crate) options: Options,
    /// Its place on each axis of the grid.
    pub(crate) place: Option<Vec<usize>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPlan {
    minimize: Option<Vec<String>>,
    maximize: Option<Vec<String>>,
    #[serde(default)]
    base: RawOptions,
    #[serde(default)]
    grid: RawOptions,
    #[serde(default)]
    point: Vec<Spanned<RawOptions>>,
}

/// An axis, and the options that each of its values stands for.
struct Axis {
    shown: GridAxis,
    options: Vec<Options>,
}

impl Plan {
    /// Reads the text of such a file; `file` names it in errors.
    pub(crate) fn parse(text: &str, file: &str) -> anyhow::Result<Self> {
        let line =
            |at: usize| 1 + text.as_bytes()[..at.min(text.len())].iter().filter(|&&b| b == b'\n').count();
        let raw: RawPlan = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(String::new(), |span| format!(":{}", line(span.start)));
            let problem = error.message().trim().replace('\n', ", ");
            anyhow!("{file}{at}: {problem}; a sweep has minimize, maximize, [base], [grid] and [[point]]")
        })?;
        let mut base = Options::read(&raw.base).map_err(|error| anyhow!("{file}: base.{error}"))?;
        if base.get(SCENE).is_none() {
            base.set(SCENE, DEFAULT_SCENE.to_owned())?;
        }
        let axes = axes(&raw.grid).map_err(|error| anyhow!("{file}: grid.{error}"))?;
        let combinations = axes
            .iter()
            .try_fold(1_usize, |count, axis| count.checked_mul(axis.options.len()))
            .unwrap_or(usize::MAX);
        let of_grid = if axes.is_empty() { 0 } else { combinations };
        if of_grid.saturating_add(raw.point.len()) > MOST_POINTS {
            bail!("{file}: more than {MOST_POINTS} points; vary less, or in several sweeps");
        }
        let mut points: Vec<PlannedPoint> =
            (0..of_grid).map(|index| of_combination(&base, &axes, index)).collect();
        for listed in &raw.point {
            let options = Options::read(listed.get_ref())
                .map_err(|error| anyhow!("{file}:{}: point.{error}", line(listed.span().start)))?;
            points.push(PlannedPoint { options: base.with(&options), place: None });
        }
        if points.is_empty() {
            bail!("{file}: no points; add a [grid] of lists, or [[point]] tables");
        }
        let objectives =
            objectives(raw.minimize, raw.maximize).map_err(|error| anyhow!("{file}: {error}"))?;
        Ok(Self { axes: axes.into_iter().map(|axis| axis.shown).collect(), objectives, points })
    }

    /// Names of all options that a point sets, in the order in which they first occur.
    pub(crate) fn options(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for (name, _) in self.points.iter().flat_map(|point| point.options.iter()) {
            if !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        }
        names
    }
}

/// The point at a place of the grid.
fn of_combination(base: &Options, axes: &[Axis], index: usize) -> PlannedPoint {
    let mut rest = index;
    let mut place: Vec<usize> = Vec::with_capacity(axes.len());
    for axis in axes.iter().rev() {
        place.push(rest % axis.options.len());
        rest /= axis.options.len();
    }
    place.reverse();
    let chosen = axes.iter().zip(&place).map(|(axis, &value)| &axis.options[value]);
    let options = chosen.fold(base.clone(), |options, value| options.with(value));
    PlannedPoint { options, place: Some(place) }
}

/// The option that every point has.
const SCENE: &str = "scene";

fn axes(grid: &RawOptions) -> anyhow::Result<Vec<Axis>> {
    let entries = in_order(grid).into_iter().flat_map(|(key, value)| figures_of(key, value));
    let mut axes: Vec<Axis> = Vec::new();
    for (key, value) in entries {
        let axis = axis(&key, value).map_err(|error| anyhow!("{key}: {error}"))?;
        let sets = |axis: &Axis, name: &str| axis.options.iter().any(|options| options.get(name).is_some());
        for (name, _) in axis.options.iter().flat_map(Options::iter) {
            if let Some(other) = axes.iter().find(|other| sets(other, name)) {
                bail!("{key}: it sets {name}, and so does {}; set each option by one axis", other.shown.name);
            }
        }
        axes.push(axis);
    }
    Ok(axes)
}

/// An axis of values of one option, or of tables of several.
fn axis(key: &str, value: &Value) -> anyhow::Result<Axis> {
    if key.is_empty() || key.contains(char::is_control) {
        bail!("an axis needs a name that can be shown");
    }
    let values = value.as_array().filter(|values| !values.is_empty());
    let values = values.ok_or_else(|| anyhow!("expected a list of values, such as [1, 2]"))?;
    let mut axis = Axis { shown: GridAxis { name: key.to_owned(), values: Vec::new() }, options: Vec::new() };
    for value in values {
        let options = match value {
            Value::Table(table) => {
                let mut options = Options::default();
                for (key, value) in table.iter().flat_map(|(key, value)| figures_of(key, value)) {
                    let text = value_text(value);
                    options.set(&key, text.ok_or_else(|| anyhow!("{key}: expected text or a number"))?)?;
                }
                options
            }
            value => {
                let text = value_text(value);
                let mut options = Options::default();
                options
                    .set(key, text.ok_or_else(|| anyhow!("expected values of text, numbers or tables"))?)?;
                options
            }
        };
        let shown: Vec<&str> = options.iter().map(|(_, value)| value).collect();
        axis.shown.values.push(shown.join(" "));
        axis.options.push(options);
    }
    if let Some(twice) = (1..axis.options.len()).find(|&at| axis.options[..at].contains(&axis.options[at])) {
        bail!("the value {} is given twice; give each once", axis.shown.values[twice]);
    }
    Ok(axis)
}

fn objectives(
    minimize: Option<Vec<String>>,
    maximize: Option<Vec<String>>,
) -> anyhow::Result<Vec<Objective>> {
    let defaults = minimize.is_none() && maximize.is_none();
    let minimize = if defaults { OBJECTIVES.map(str::to_owned).into() } else { minimize.unwrap_or_default() };
    let all = minimize.into_iter().map(|counter| Objective { counter, direction: Direction::Minimize });
    let maximize = maximize.unwrap_or_default().into_iter();
    let all: Vec<Objective> =
        all.chain(maximize.map(|counter| Objective { counter, direction: Direction::Maximize })).collect();
    for (index, Objective { counter, .. }) in all.iter().enumerate() {
        if !gpumodel::COUNTERS.iter().any(|info| info.id == counter) {
            bail!("no counter is called '{counter}'; see `raybudget list counters`");
        }
        if all[..index].iter().any(|other| other.counter == *counter) {
            bail!("{counter} is to be best in two ways; name it once in minimize or maximize");
        }
    }
    if all.is_empty() {
        bail!("nothing to be best in; name a counter in minimize or maximize");
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(text: &str) -> anyhow::Result<Plan> {
        Plan::parse(text, "sweep.toml")
    }

    fn told(point: &PlannedPoint) -> String {
        point.options.iter().map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_grid_is_every_combination_in_the_order_of_the_file_and_a_list_follows() {
        let plan = plan(
            "[base]\nsize = \"8x8\"\n[grid]\nscene = [\"cornell\", \"chess\"]\ntree = [{ accel = \"kd\", traversal = \"restart\" }, { accel = \"bvh\" }]\n\
             cache.uche.size = [1024]\n[[point]]\nscene = \"soup\"\nsize = \"4x4\"\n",
        )
        .expect("a plan");
        let points: Vec<String> = plan.points.iter().map(told).collect();
        assert_eq!(
            points,
            [
                "size=8x8 scene=cornell accel=kd traversal=restart cache.uche.size=1024",
                "size=8x8 scene=cornell accel=bvh cache.uche.size=1024",
                "size=8x8 scene=chess accel=kd traversal=restart cache.uche.size=1024",
                "size=8x8 scene=chess accel=bvh cache.uche.size=1024",
                "size=4x4 scene=soup",
            ]
        );
        assert_eq!(plan.points[2].place, Some(vec![1, 0, 0]));
        assert_eq!(
            (plan.points[4].place.as_ref(), plan.axes[1].values.as_slice()),
            (None, &["kd restart".to_owned(), "bvh".to_owned()][..])
        );
        assert_eq!(plan.options(), ["size", "scene", "accel", "traversal", "cache.uche.size"]);
    }

    #[test]
    fn a_plan_that_cannot_be_followed_is_refused_with_its_place() {
        let long = format!(
            "[grid]\nct = [{0}]\nci = [{0}]",
            (1..=101).map(|n| n.to_string()).collect::<Vec<_>>().join(",")
        );
        for (text, expected) in [
            ("", "sweep.toml: no points"),
            ("[grid]\n", "no points"),
            ("[grid\n", "sweep.toml:1: "),
            ("weather = 1\n", "sweep.toml:1: unknown field `weather`"),
            ("[grid]\ngpu = \"adreno-540\"\n", "grid.gpu: expected a list of values"),
            ("[grid]\ngpu = []\n", "grid.gpu: expected a list of values"),
            ("[grid]\ngpu = [\"a\", \"a\"]\n", "grid.gpu: the value a is given twice"),
            ("[grid]\n\"\" = [{ gpu = \"a\" }]\n", "an axis needs a name"),
            (
                "[grid]\naccel = [\"bvh\"]\ntree = [{ accel = \"kd\" }]\n",
                "grid.tree: it sets accel, and so does accel",
            ),
            ("[grid]\nweather = [1]\n", "grid.weather: weather: no such option"),
            ("[base]\nweather = 1\n[[point]]\n", "base.weather: no such option"),
            ("\n[[point]]\nweather = 1\n", "sweep.toml:2: point.weather: no such option"),
            ("minimize = [\"warmth\"]\n[[point]]\n", "no counter is called 'warmth'"),
            ("minimize = []\n[[point]]\n", "nothing to be best in"),
            ("minimize = [\"fps\"]\nmaximize = [\"fps\"]\n[[point]]\n", "best in two ways"),
            (&long, "more than 10000 points"),
        ] {
            let message = plan(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
