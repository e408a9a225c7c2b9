//! The Pareto fronts: one for each scene, for which scene is rendered is nobody's choice.

use super::{Objective, Sweep, SweptPoint};
use std::cmp::Ordering;

/// Indices of the points that no other of the same scene is better than: none is as good in every objective and better in one. Scene by
/// scene in the order of their first points, by rising cost in the first objective. A point that lacks an objective is never among them;
/// of equal ones all are.
pub fn front(sweep: &Sweep) -> Vec<usize> {
    sweep.scenes().iter().flat_map(|&scene| front_of(sweep, scene)).collect()
}

/// The front of one scene.
pub(super) fn front_of(sweep: &Sweep, scene: Option<&str>) -> Vec<usize> {
    let costs = |point: &SweptPoint| -> Option<Vec<f64>> {
        let cost = |objective: &Objective| Some(objective.direction.cost(point.number(&objective.counter)?));
        sweep.objectives.iter().map(cost).collect()
    };
    let of_scene = sweep.points.iter().enumerate().filter(|(_, point)| sweep.scene(point) == scene);
    let mut candidates: Vec<(usize, Vec<f64>)> =
        of_scene.filter_map(|(index, point)| Some((index, costs(point)?))).collect();
    // In lexicographic order whatever dominates a point stands before it.
    let by_cost = |a: &[f64], b: &[f64]| {
        let mut orders = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
        orders.find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
    };
    candidates.sort_by(|a, b| by_cost(&a.1, &b.1).then(a.0.cmp(&b.0)));
    let mut front: Vec<(usize, Vec<f64>)> = Vec::new();
    for (index, costs) in candidates {
        let dominates = |(_, other): &(usize, Vec<f64>)| {
            *other != costs && other.iter().zip(&costs).all(|(other, cost)| other <= cost)
        };
        if !front.iter().any(dominates) {
            front.push((index, costs));
        }
    }
    front.into_iter().map(|(index, _)| index).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Direction;
    use crate::sweep::tests::sweep_of;
    use proptest::prelude::*;

    #[test]
    fn a_point_is_on_the_front_exactly_where_none_is_as_good_and_better() {
        let sweep = sweep_of(&[[1.0, 9.0], [2.0, 9.0], [2.0, 4.0], [2.0, 4.0], [5.0, 4.0], [7.0, 1.0]]);
        assert_eq!(front(&sweep), [0, 2, 3, 5]);
    }

    #[test]
    fn more_is_better_where_that_is_asked() {
        let mut sweep = sweep_of(&[[1.0, 9.0], [2.0, 9.0], [3.0, 10.0]]);
        sweep.objectives[1].direction = Direction::Maximize;
        assert_eq!(front(&sweep), [0, 2]);
    }

    #[test]
    fn a_point_without_figures_is_not_on_the_front() {
        let mut sweep = sweep_of(&[[1.0, 1.0], [2.0, 2.0]]);
        sweep.points[0].outcome = Err("no memory".to_owned());
        assert_eq!(front(&sweep), [1]);
    }

    #[test]
    fn a_scene_has_a_front_of_its_own() {
        let mut sweep = sweep_of(&[[9.0, 9.0], [1.0, 1.0], [8.0, 8.0], [2.0, 1.0]]);
        sweep.points[0].values[0] = Some("chess".to_owned());
        sweep.points[2].values[0] = Some("chess".to_owned());
        assert_eq!(front(&sweep), [2, 1]);
    }

    proptest! {
        #[test]
        fn the_front_is_that_of_the_definition(figures in prop::collection::vec([0_u8..6, 0..6], 0..40)) {
            let figures: Vec<[f64; 2]> = figures.iter().map(|pair| pair.map(f64::from)).collect();
            let better = |a: &[f64; 2], b: &[f64; 2]| a != b && a[0] <= b[0] && a[1] <= b[1];
            let expected: Vec<usize> =
                (0..figures.len()).filter(|&at| !figures.iter().any(|other| better(other, &figures[at]))).collect();
            let mut found = front(&sweep_of(&figures));
            found.sort_unstable();
            prop_assert_eq!(found, expected);
        }
    }
}
