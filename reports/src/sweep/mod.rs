//! Many frames that differ in their options: one row of figures for each, the Pareto fronts, and what each axis does.
//!
//! A point of a sweep has its figures in a file of its own, [`Figures`], that names neither clock nor host: the same inputs give the
//! same bytes, whoever makes them. [`csv_table`] has all points, [`front`] the best of them, [`effects`] what each value of an axis
//! does on average, [`charts`] both as pictures.

pub mod charts;
pub mod csv_table;
mod effects;
mod figures;
mod front;
pub mod json;
pub mod text;

pub use effects::{Effect, effects};
pub use figures::Figures;
pub use front::front;

/// The option that says what is rendered.
const SCENE: &str = "scene";

/// A sweep that has ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// What it is called.
    pub title: String,
    /// Names of all options that a point sets.
    pub options: Vec<String>,
    /// What varies together in the grid, outermost first; empty without a grid.
    pub axes: Vec<GridAxis>,
    /// What is best; at least one.
    pub objectives: Vec<Objective>,
    /// All points, those of the grid first, the last axis varying fastest.
    pub points: Vec<SweptPoint>,
}

/// One axis of the grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GridAxis {
    /// Its name.
    pub name: String,
    /// Its values, as they are shown.
    pub values: Vec<String>,
}

/// A counter that should be small, or large.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Objective {
    /// Id of the counter of the frame.
    pub counter: String,
    /// Which way is better.
    pub direction: Direction,
}

/// Which way is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Less is better.
    Minimize,
    /// More is better.
    Maximize,
}

impl Direction {
    /// What is better, in a word.
    pub fn better(self) -> &'static str {
        match self {
            Self::Minimize => "less",
            Self::Maximize => "more",
        }
    }

    /// A figure of which less is better.
    fn cost(self, figure: f64) -> f64 {
        match self {
            Self::Minimize => figure,
            Self::Maximize => -figure,
        }
    }
}

/// One point.
#[derive(Clone, Debug, PartialEq)]
pub struct SweptPoint {
    /// Hash of its inputs; stem of the name of its file.
    pub id: String,
    /// A value for each of [`Sweep::options`]; none where the point does not set it.
    pub values: Vec<Option<String>>,
    /// Its place on each of [`Sweep::axes`]; none for a point of the list.
    pub place: Option<Vec<usize>>,
    /// Its figures, or why there are none.
    pub outcome: Result<Figures, String>,
}

impl SweptPoint {
    /// A counter of its frame.
    fn number(&self, counter: &str) -> Option<f64> {
        self.outcome.as_ref().ok()?.counters.get(counter)?.value.as_f64()
    }
}

impl Sweep {
    /// Options that differ between points.
    fn varying(&self) -> Vec<usize> {
        let varies = |option: &usize| {
            let first = self.points.first().map(|point| &point.values[*option]);
            self.points.iter().any(|point| Some(&point.values[*option]) != first)
        };
        (0..self.options.len()).filter(varies).collect()
    }

    /// What a point has as its scene.
    fn scene<'a>(&self, point: &'a SweptPoint) -> Option<&'a str> {
        let option = self.options.iter().position(|name| name == SCENE)?;
        point.values[option].as_deref()
    }

    /// All scenes, in the order of their first points.
    fn scenes(&self) -> Vec<Option<&str>> {
        let mut scenes = Vec::new();
        for scene in self.points.iter().map(|point| self.scene(point)) {
            if !scenes.contains(&scene) {
                scenes.push(scene);
            }
        }
        scenes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counters::{Counter, Fidelity, Value};
    use crate::report::Inputs;

    const OBJECTIVES: [&str; 2] = ["frame_time_ms", "dram_read_bytes"];

    fn inputs() -> Inputs {
        let text = r#"{"scene": "cornell", "gpu": "adreno-540", "accel": "bvh", "traversal": "stack", "layout": "padded", "technique": "fragment",
            "width": 8, "height": 8, "seed": null, "hashes": {"scene": "1", "gpu": "2", "costs": "3"}, "triangles": 32, "ray_sets": ["primary"],
            "sah_costs": [3.0, 1.5], "short_stack": 0, "trail_bits": null}"#;
        serde_json::from_str(text).expect("inputs")
    }

    fn counter((id, figure): (&str, f64)) -> (String, Counter) {
        let unit = crate::units::counter_info(id).expect("it is known").unit.to_owned();
        (id.to_owned(), Counter { value: Value::Real(figure), unit, ci95: None, from: Fidelity::Replay })
    }

    /// A list of points with these figures for two objectives, of which less is better.
    pub(super) fn sweep_of(figures: &[[f64; 2]]) -> Sweep {
        let point = |(index, figures): (usize, &[f64; 2])| SweptPoint {
            id: format!("{index:032x}"),
            values: vec![Some("cornell".to_owned()), (index > 0).then(|| index.to_string())],
            place: None,
            outcome: Ok(Figures {
                schema: figures::SCHEMA,
                point: format!("{index:032x}"),
                tool: "raybudget".to_owned(),
                inputs: inputs(),
                within: None,
                counters: OBJECTIVES.into_iter().zip(*figures).map(counter).collect(),
                passes: Vec::new(),
            }),
        };
        let objective =
            |counter: &str| Objective { counter: counter.to_owned(), direction: Direction::Minimize };
        Sweep {
            title: "a sweep".to_owned(),
            options: vec!["scene".to_owned(), "cache.uche.size".to_owned()],
            axes: Vec::new(),
            objectives: OBJECTIVES.map(objective).into(),
            points: figures.iter().enumerate().map(point).collect(),
        }
    }

    #[test]
    fn figures_are_read_as_they_were_written_to_the_last_bit() {
        let third = sweep_of(&[[1.0 / 3.0, 5e-324]]);
        let figures = third.points[0].outcome.as_ref().expect("figures");
        assert_eq!(&Figures::parse(&figures.text(), "a file").expect("it is whole"), figures);
        let torn = &figures.text()[..40];
        let message = Figures::parse(torn, "a file").expect_err("it is torn").to_string();
        assert!(message.starts_with("a file:") && message.contains("remove the file"), "{message}");
    }
}
