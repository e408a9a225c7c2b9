//! What was measured.

use super::model::Setup;
use std::collections::BTreeMap;

/// Figures by setup and metric. What is not in it was not measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurements {
    figures: BTreeMap<Setup, BTreeMap<String, f64>>,
    absences: BTreeMap<Setup, BTreeMap<String, String>>,
    failures: BTreeMap<Setup, String>,
    stand_ins: BTreeMap<String, String>,
}

impl Measurements {
    /// Nothing measured yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A figure of a setup. One that is not finite and at least 0 is taken as absent.
    pub fn figure(&mut self, setup: &Setup, metric: &str, value: f64) {
        if value.is_finite() && value >= 0.0 {
            self.figures.entry(setup.clone()).or_default().insert(metric.to_owned(), value);
        } else {
            self.absent(setup, metric, &format!("its figure is {value}"));
        }
    }

    /// A setup has no such figure, and why.
    pub fn absent(&mut self, setup: &Setup, metric: &str, reason: &str) {
        self.absences.entry(setup.clone()).or_default().insert(metric.to_owned(), reason.to_owned());
    }

    /// A setup could not be measured at all, and why.
    pub fn failed(&mut self, setup: &Setup, reason: &str) {
        self.failures.insert(setup.clone(), reason.to_owned());
    }

    /// The scene of a role was measured on a stand-in.
    pub fn stand_in(&mut self, scene: &str, stand_in: &str) {
        self.stand_ins.insert(scene.to_owned(), stand_in.to_owned());
    }

    /// What stands in for the scene of a role.
    pub fn stand_in_of(&self, scene: &str) -> Option<&str> {
        self.stand_ins.get(scene).map(String::as_str)
    }

    /// A setup's figure.
    ///
    /// # Errors
    /// Why there is none.
    pub fn get(&self, setup: &Setup, metric: &str) -> Result<f64, &str> {
        let figure = self.figures.get(setup).and_then(|figures| figures.get(metric));
        let absence = || {
            let absence = self.absences.get(setup).and_then(|absences| absences.get(metric));
            absence.or_else(|| self.failures.get(setup)).map_or("it was not measured", String::as_str)
        };
        figure.copied().ok_or_else(absence)
    }
}
