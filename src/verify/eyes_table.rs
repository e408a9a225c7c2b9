//! The figures of Lee et al. 2017 beside ours, scene by scene.

use super::measure::Measured;
use reports::claims::{ClaimSet, Rule, Setup};
use std::fmt::Write;

/// The paper's letter.
const LETTER: &str = "B";
/// Claims with a published figure for each scene: speed-up, energy, frames per second.
const PUBLISHED: [&str; 3] = ["B4", "B5", "B6"];

pub(crate) fn is_of(claims: &ClaimSet) -> bool {
    claims.paper.letter == LETTER
}

/// Figures 1 and 3 of the paper, as a table in Markdown.
pub(crate) fn figures(claims: &ClaimSet, measured: &Measured) -> String {
    let needs = claims.needs();
    let setup = |scene: &str, eyes: &str| {
        let is = |setup: &&Setup| {
            setup.scene == scene
                && setup.get("eyes") == Some(eyes)
                && setup.get("technique") == Some("stereo")
        };
        needs.keys().find(is)
    };
    let mut out = String::from(
        "| scene | reused | traced | speed-up, units | frames | paper | energy, units | frames | paper | pairs/s | paper |\n\
         |---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    for role in &claims.scenes {
        let (Some(traced), Some(reuse)) = (setup(&role.name, "traced"), setup(&role.name, "reuse")) else {
            continue;
        };
        let of = |setup: &Setup, metric: &str| measured.measurements.get(setup, metric).ok();
        let figure = |value: Option<f64>, decimals: usize| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
        };
        let over = |above: &Setup, below: &Setup, metric: &str| {
            of(above, metric).zip(of(below, metric)).map(|(above, below)| above / below)
        };
        let [speed_up, energy, rate] = PUBLISHED.map(|claim| published(claims, claim, &role.name));
        let reused = of(reuse, "reused_share").map(|share| 100.0 * share);
        let stand_in = measured.scenes.get(&role.name).map_or("", String::as_str);
        writeln!(
            out,
            "| {} ({stand_in}) | {} % | {} % | {} | {} | {} | {} | {} | {} | {} | {} |",
            role.title,
            figure(reused, 2),
            figure(reused.map(|reused| 100.0 - reused), 2),
            figure(over(traced, reuse, "unit_ms"), 3),
            figure(over(traced, reuse, "eyes_ms"), 3),
            figure(speed_up, 2),
            figure(over(reuse, traced, "unit_energy_mj"), 3),
            figure(over(reuse, traced, "eyes_energy_mj"), 3),
            figure(energy, 2),
            figure(of(reuse, "pairs_per_second"), 1),
            figure(rate, 1),
        )
        .expect("a string takes every write");
    }
    out
}

/// The figure of a scene in a claim's first test.
fn published(claims: &ClaimSet, claim: &str, scene: &str) -> Option<f64> {
    let claim = claims.claims.iter().find(|other| other.id == claim)?;
    match &claim.tests.first()?.rule {
        Rule::Number { figures, .. } => figures.get(scene).copied(),
        _ => None,
    }
}
