//! What each value of an axis does on average: main effects of a full grid.

use super::{Objective, Sweep};

/// What a value of an axis does to one objective.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Index of the axis.
    pub axis: usize,
    /// Index of the value.
    pub value: usize,
    /// Index of the objective.
    pub objective: usize,
    /// Figures with this value over those with the first one: geometric mean over all combinations of the other axes in which both have a
    /// figure above 0. None where there is no such combination.
    pub ratio: Option<f64>,
    /// Number of these combinations.
    pub combinations: usize,
}

/// The effects of all values of all axes on all objectives, in this order.
pub fn effects(sweep: &Sweep) -> Vec<Effect> {
    let mut all = Vec::new();
    for axis in 0..sweep.axes.len() {
        let tables: Vec<_> =
            sweep.objectives.iter().map(|objective| logarithms(sweep, axis, objective)).collect();
        for value in 0..sweep.axes[axis].values.len() {
            for (objective, rows) in tables.iter().enumerate() {
                let both = rows.iter().filter_map(|row| Some(row[value]? - row[0]?));
                let differences: Vec<f64> = both.collect();
                let combinations = differences.len();
                let mean = differences.iter().sum::<f64>() / combinations as f64;
                let ratio = (combinations > 0).then(|| mean.exp());
                all.push(Effect { axis, value, objective, ratio, combinations });
            }
        }
    }
    all
}

/// Logarithms of an objective for each combination of the other axes: one for each value of the axis, where there is a figure.
fn logarithms(sweep: &Sweep, axis: usize, objective: &Objective) -> Vec<Vec<Option<f64>>> {
    let lengths: Vec<usize> = sweep.axes.iter().map(|axis| axis.values.len()).collect();
    let combinations: usize = lengths.iter().product();
    let mut figures: Vec<Option<f64>> = vec![None; combinations];
    // The last axis varies fastest.
    let place =
        |coordinates: &[usize]| coordinates.iter().zip(&lengths).fold(0, |at, (c, length)| at * length + c);
    for point in &sweep.points {
        if let Some(coordinates) = &point.place {
            let number = point.number(&objective.counter).filter(|number| *number > 0.0);
            figures[place(coordinates)] = number.map(f64::ln);
        }
    }
    let stride: usize = lengths[axis + 1..].iter().product();
    let firsts = (0..combinations).filter(|at| (at / stride).is_multiple_of(lengths[axis]));
    firsts.map(|first| (0..lengths[axis]).map(|value| figures[first + value * stride]).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::GridAxis;
    use crate::sweep::tests::sweep_of;

    fn grid() -> Sweep {
        let axis = |name: &str, values: &[&str]| GridAxis {
            name: name.to_owned(),
            values: values.iter().map(|&value| value.to_owned()).collect(),
        };
        let mut sweep = sweep_of(&[[1.0, 1.0], [3.0, 1.0], [2.0, 1.0], [6.0, 1.0], [8.0, 1.0], [24.0, 1.0]]);
        sweep.axes = vec![axis("gpu", &["a", "b", "c"]), axis("layout", &["padded", "split"])];
        for (index, point) in sweep.points.iter_mut().enumerate() {
            point.place = Some(vec![index / 2, index % 2]);
        }
        sweep
    }

    fn ratios(sweep: &Sweep, axis: usize) -> Vec<Option<f64>> {
        let of_axis =
            effects(sweep).into_iter().filter(|effect| effect.axis == axis && effect.objective == 0);
        of_axis.map(|effect| effect.ratio.map(|ratio| (ratio * 1e9).round() / 1e9)).collect()
    }

    #[test]
    fn a_value_that_multiplies_has_its_factor_whatever_the_other_axes_do() {
        assert_eq!(ratios(&grid(), 0), [Some(1.0), Some(2.0), Some(8.0)]);
        assert_eq!(ratios(&grid(), 1), [Some(1.0), Some(3.0)]);
    }

    #[test]
    fn a_value_is_compared_where_it_and_the_first_one_have_figures() {
        let mut sweep = grid();
        sweep.points[4].outcome = Err("no memory".to_owned());
        assert_eq!(ratios(&sweep, 0), [Some(1.0), Some(2.0), Some(8.0)]);
        assert_eq!(ratios(&sweep, 1), [Some(1.0), Some(3.0)]);
        let combinations: Vec<usize> = effects(&sweep)
            .iter()
            .filter(|effect| effect.objective == 0)
            .map(|effect| effect.combinations)
            .collect();
        assert_eq!(combinations, [2, 2, 1, 2, 2]);
        sweep.points[5].outcome = Err("no memory".to_owned());
        assert_eq!(ratios(&sweep, 0), [Some(1.0), Some(2.0), None]);
    }
}
