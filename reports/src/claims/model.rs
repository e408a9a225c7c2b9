//! A claim file, checked: every name in it is resolved.

use super::rule::Rule;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Axis to value.
pub(super) type Axes = BTreeMap<String, String>;

/// The paper.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// What the ids of its claims begin with.
    pub letter: String,
    /// Authors, title, venue.
    pub citation: String,
    /// Digital object identifier, where it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doi: Option<String>,
    /// Width and height of its images in pixels.
    pub image: [u32; 2],
    /// Features that its frames have whatever the scene needs, as `--force` names them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub force: Vec<String>,
}

/// A scene of the paper, and what to trace for it.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SceneRole {
    /// Its name in setups.
    pub name: String,
    /// Its name in the paper.
    pub title: String,
    /// File names under which it may be found, best first; none where it is not obtainable.
    pub files: Vec<String>,
    /// The built-in scene that stands in for it.
    pub stand_in: String,
    /// Why that one.
    pub why: String,
}

/// What a statement is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Figures.
    Number,
    /// Which of several is larger.
    Order,
    /// A reason or a quality.
    Qualitative,
}

/// A claim file.
#[derive(Clone, Debug, PartialEq)]
pub struct ClaimSet {
    /// The paper.
    pub paper: Paper,
    /// Its scenes, in file order.
    pub scenes: Vec<SceneRole>,
    /// Unit and definition of the metrics that are no counters, by id.
    pub metrics: BTreeMap<String, MetricInfo>,
    /// Its statements, in file order.
    pub claims: Vec<Claim>,
}

/// What a metric is that is no counter.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MetricInfo {
    /// Unit of the value.
    pub unit: String,
    /// What must be measured.
    pub definition: String,
}

/// A statement.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Line of the file, from 1.
    pub line: usize,
    /// Its id.
    pub id: String,
    /// What the paper states.
    pub statement: String,
    /// Section, figure or table.
    pub place: String,
    /// What it is about.
    pub kind: Kind,
    /// The paper's figures, as text.
    pub published: Option<String>,
    /// Misprints and assumptions.
    pub note: Option<String>,
    /// The part of the statement that no test covers, and why.
    pub untested: Option<String>,
    /// What must hold, all of it.
    pub tests: Vec<Test>,
    /// Other meanings or assumptions.
    pub readings: Vec<Reading>,
}

/// Another meaning of a statement, or another assumption about the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// In a few words.
    pub name: String,
    /// Why one may read it so.
    pub why: String,
    /// What must hold then, all of it.
    pub tests: Vec<Test>,
}

/// One condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    /// Line of the file, from 1.
    pub line: usize,
    /// What must hold in a case.
    pub rule: Rule,
    /// The cases; none for a rule that measures nothing.
    pub cases: Vec<Case>,
    /// In how many cases.
    pub holds: Quantifier,
    /// What setups say where neither the case nor the rule says otherwise.
    pub base: BTreeMap<String, String>,
}

/// Where a rule is applied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// Name of the scene.
    pub scene: String,
    /// What every setup of the case has in common.
    pub each: Option<Variant>,
}

/// In how many cases a rule must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantifier {
    /// In all.
    All,
    /// In more than half.
    Majority,
    /// In at least one.
    Some,
    /// Once, for the means over all cases.
    Mean,
}

/// Values of some axes, with a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Its name.
    pub name: String,
    /// Axis to value.
    pub axes: BTreeMap<String, String>,
}

/// What is read from a setup's measurement: a metric, or one over another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Metric {
    /// Id of the metric.
    pub id: String,
    /// Id of the metric that it is divided by.
    pub over: Option<String>,
}

/// What is measured at once: a scene and a value for every axis of the file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct Setup {
    /// Name of the scene's role.
    pub scene: String,
    /// Axis to value.
    pub axes: BTreeMap<String, String>,
}

impl Test {
    /// The setup of `variant` in a case, or in another scene with what the case has in common.
    pub(super) fn setup(&self, scene: &str, case: &Case, variant: &Variant) -> Setup {
        let mut axes = self.base.clone();
        let each = case.each.iter().flat_map(|each| &each.axes);
        axes.extend(each.chain(&variant.axes).map(|(axis, value)| (axis.clone(), value.clone())));
        Setup { scene: scene.to_owned(), axes }
    }
}

impl Variant {
    /// Both at once, or an axis that both set.
    pub(super) fn with(&self, other: &Self) -> Result<Self, String> {
        if let Some(axis) = other.axes.keys().find(|axis| self.axes.contains_key(*axis)) {
            return Err(axis.clone());
        }
        let mut axes = self.axes.clone();
        axes.extend(other.axes.clone());
        Ok(Self { name: format!("{} with {}", other.name, self.name), axes })
    }
}

impl Setup {
    /// The value of an axis.
    pub fn get(&self, axis: &str) -> Option<&str> {
        self.axes.get(axis).map(String::as_str)
    }
}

impl fmt::Display for Setup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axes: Vec<String> = self.axes.iter().map(|(axis, value)| format!("{axis} {value}")).collect();
        write!(f, "{}: {}", self.scene, axes.join(", "))
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.each {
            Some(each) => write!(f, "{}, {}", self.scene, each.name),
            None => f.write_str(&self.scene),
        }
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.over {
            Some(over) => write!(f, "{} / {over}", self.id),
            None => f.write_str(&self.id),
        }
    }
}

impl Quantifier {
    pub(super) const NAMES: [(&'static str, Self); 4] =
        [("all", Self::All), ("majority", Self::Majority), ("some", Self::Some), ("mean", Self::Mean)];
}
