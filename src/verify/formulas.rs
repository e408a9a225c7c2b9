//! Metrics of claims that are about formulas alone: no frame changes them. Their definitions are in the claim file.

use scenes::RaySelection;

/// Directions per axis of the grid on which a normal's encoding is tried: 6 x 64 x 64 unit normals.
const NORMALS_PER_EDGE: u32 = 64;
/// Rays, and threads of a group, with which the number of groups is tried.
const MOST_RAYS: u32 = 4096;
const GROUPS: [u32; 4] = [16, 32, 64, 128];
/// Steps of roughness from 0 to 1.
const ROUGHNESS_STEPS: u32 = 1000;

/// A metric of a formula; `None` for a metric that is not of this kind.
pub(super) fn of_formula(metric: &str) -> Option<f64> {
    Some(match metric {
        "normal_error_printed" => normal_error(1.0),
        "normal_error_half" => normal_error(0.5),
        "group_count_error" => f64::from(group_count_error()),
        "gate_errors_printed" => f64::from(gate_errors(false)),
        "gate_errors_with_else" => f64::from(gate_errors(true)),
        _ => return None,
    })
}

/// Largest error of any component of a unit normal that is stored as `n * 0.5 + offset` in 8 bits, clamped to [0, 1] and rounded to
/// nearest.
fn normal_error(offset: f64) -> f64 {
    let mut worst = 0.0_f64;
    let coordinate = |step: u32| (f64::from(step) + 0.5) / f64::from(NORMALS_PER_EDGE) * 2.0 - 1.0;
    for (a, b) in (0..NORMALS_PER_EDGE).flat_map(|a| (0..NORMALS_PER_EDGE).map(move |b| (a, b))) {
        let (a, b) = (coordinate(a), coordinate(b));
        let length = (a * a + b * b + 1.0).sqrt();
        // The cube's other faces permute these components and their signs.
        for component in [a / length, b / length, 1.0 / length, -1.0 / length] {
            let stored = ((component * 0.5 + offset).clamp(0.0, 1.0) * 255.0).round() / 255.0;
            worst = worst.max(((stored - offset) / 0.5 - component).abs());
        }
    }
    worst
}

/// Largest difference between the groups that the rays of a buffer ask for, each by its place in it, and those that they need.
#[expect(clippy::manual_div_ceil, reason = "the printed formula is under test")]
fn group_count_error() -> u32 {
    let error = |threads: u32| {
        let mut asked = 0;
        let errors = (1..=MOST_RAYS).map(move |rays| {
            let place = rays - 1;
            asked = asked.max((place + 1 + (threads - 1)) / threads);
            asked.abs_diff(rays.div_ceil(threads))
        });
        errors.max().unwrap_or(0)
    };
    GROUPS.into_iter().map(error).max().unwrap_or(0)
}

/// What a surface sends.
#[derive(PartialEq)]
enum Sent {
    Mirror,
    Random,
    Nothing,
}

/// Surfaces that two conditions in a row, or with an `else` between them, let send another ray than the gates are meant to.
fn gate_errors(with_else: bool) -> u32 {
    let gates = RaySelection::default().roughness;
    let is_wrong = |step: &u32| {
        let roughness = *step as f32 / ROUGHNESS_STEPS as f32;
        let (mirror, glossy) = (roughness <= gates.mirror, roughness <= gates.glossy);
        let meant = match (mirror, glossy) {
            (true, _) => Sent::Mirror,
            (false, true) => Sent::Random,
            (false, false) => Sent::Nothing,
        };
        let sent = match (mirror && with_else, glossy) {
            (true, _) => Sent::Mirror,
            (false, true) => Sent::Random,
            (false, false) => Sent::Nothing,
        };
        sent != meant
    };
    (0..=ROUGHNESS_STEPS).filter(is_wrong).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_an_offset_keeps_a_normal_to_half_a_step_and_a_whole_one_loses_it() {
        assert!(normal_error(0.5) <= 1.0 / 255.0 + 1e-12, "{}", normal_error(0.5));
        assert!(normal_error(1.0) > 0.9, "positive components are clamped");
    }

    #[test]
    fn without_an_else_every_mirror_is_lost() {
        assert_eq!(gate_errors(true), 0);
        let gates = RaySelection::default().roughness;
        assert_eq!(gate_errors(false), (gates.mirror * ROUGHNESS_STEPS as f32).round() as u32 + 1);
    }
}
