//! The names that tests may use, and what they stand for.

use super::model::{Axes, Metric, MetricInfo, Variant};
use crate::units::counter_info;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// What a claim file defines.
pub(super) struct Names {
    pub(super) scenes: Vec<String>,
    pub(super) axes: BTreeMap<String, Vec<String>>,
    pub(super) variants: BTreeMap<String, Axes>,
    pub(super) sets: BTreeMap<String, Vec<String>>,
    pub(super) metrics: BTreeMap<String, MetricInfo>,
    pub(super) thresholds: BTreeMap<String, f64>,
}

/// What a reading puts in the place of variants and metrics.
#[derive(Default)]
pub(super) struct Replacements {
    pub(super) variants: BTreeMap<String, String>,
    pub(super) metrics: BTreeMap<String, String>,
    used: RefCell<BTreeSet<String>>,
}

impl Replacements {
    pub(super) fn new(variants: BTreeMap<String, String>, metrics: BTreeMap<String, String>) -> Self {
        Self { variants, metrics, used: RefCell::default() }
    }

    /// Names that were to be replaced and did not occur.
    pub(super) fn unused(&self) -> Option<String> {
        let used = self.used.borrow();
        self.variants.keys().chain(self.metrics.keys()).find(|name| !used.contains(*name)).cloned()
    }

    fn replace<'a>(&'a self, map: &'a BTreeMap<String, String>, name: &'a str) -> &'a str {
        match map.get(name) {
            Some(other) => {
                self.used.borrow_mut().insert(name.to_owned());
                other
            }
            None => name,
        }
    }
}

impl Names {
    /// Whether the axis exists and has the value.
    pub(super) fn check_axis(&self, axis: &str, value: &str) -> Result<(), String> {
        let Some(values) = self.axes.get(axis) else {
            return Err(format!("no axis is called '{axis}', expected one of {}", list(self.axes.keys())));
        };
        if values.iter().any(|known| known == value) {
            Ok(())
        } else {
            Err(format!("axis {axis} has no value '{value}', expected one of {}", list(values)))
        }
    }

    pub(super) fn check_scene(&self, name: &str) -> Result<(), String> {
        if self.scenes.iter().any(|scene| scene == name) {
            Ok(())
        } else {
            Err(format!("no scene is called '{name}', expected one of {}", list(&self.scenes)))
        }
    }

    pub(super) fn check_metric(&self, id: &str) -> Result<(), String> {
        if counter_info(id).is_some() || self.metrics.contains_key(id) {
            Ok(())
        } else {
            Err(format!(
                "no metric is called '{id}', expected a counter or one of {}",
                list(self.metrics.keys())
            ))
        }
    }

    pub(super) fn metric(&self, text: &str, replacements: &Replacements) -> Result<Metric, String> {
        let id = |id: &str| {
            let id = replacements.replace(&replacements.metrics, id);
            self.check_metric(id).map(|()| id.to_owned())
        };
        match text.split_once(" / ") {
            Some((above, below)) => Ok(Metric { id: id(above)?, over: Some(id(below)?) }),
            None => Ok(Metric { id: id(text)?, over: None }),
        }
    }

    pub(super) fn variant(&self, name: &str, replacements: &Replacements) -> Result<Variant, String> {
        let name = replacements.replace(&replacements.variants, name);
        match self.variants.get(name) {
            Some(axes) => Ok(Variant { name: name.to_owned(), axes: axes.clone() }),
            None => {
                Err(format!("no variant is called '{name}', expected one of {}", list(self.variants.keys())))
            }
        }
    }

    /// The members of a set, or the one variant of that name.
    pub(super) fn group(&self, name: &str, replacements: &Replacements) -> Result<Vec<Variant>, String> {
        match self.sets.get(name) {
            Some(members) => members.iter().map(|member| self.variant(member, replacements)).collect(),
            None if self.variants.contains_key(name) => Ok(vec![self.variant(name, replacements)?]),
            None => Err(format!(
                "no variant or set is called '{name}', expected one of {}",
                list(self.sets.keys().chain(self.variants.keys()))
            )),
        }
    }

    pub(super) fn threshold(&self, name: &str) -> Result<f64, String> {
        self.thresholds.get(name).copied().ok_or_else(|| {
            format!(
                "no threshold is called '{name}', expected a number or one of {}",
                list(self.thresholds.keys())
            )
        })
    }
}

pub(super) fn list<'a>(names: impl IntoIterator<Item = &'a String>) -> String {
    names.into_iter().map(String::as_str).collect::<Vec<_>>().join(", ")
}
