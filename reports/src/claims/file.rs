//! Reads a claim file. Errors name the line, what was expected and the remedy; unknown keys are refused.

use super::keys::{self, Problem, RawTest};
use super::model::{Axes, Claim, ClaimSet, Kind, MetricInfo, Paper, Reading, SceneRole, Test};
use super::names::{Names, Replacements};
use crate::error::Error;
use crate::units::counter_info;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    paper: Paper,
    scene: Vec<Spanned<SceneRole>>,
    #[serde(default)]
    thresholds: BTreeMap<String, Spanned<f64>>,
    axes: BTreeMap<String, Vec<String>>,
    defaults: Spanned<RawAxes>,
    variants: BTreeMap<String, RawAxes>,
    #[serde(default)]
    sets: BTreeMap<String, Spanned<Vec<String>>>,
    #[serde(default)]
    metrics: BTreeMap<String, Spanned<MetricInfo>>,
    claim: Vec<Spanned<RawClaim>>,
}

type RawAxes = BTreeMap<String, Spanned<String>>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawClaim {
    id: Spanned<String>,
    statement: String,
    #[serde(rename = "where")]
    place: String,
    kind: Kind,
    published: Option<String>,
    note: Option<String>,
    untested: Option<String>,
    #[serde(default)]
    test: Vec<Spanned<RawTest>>,
    #[serde(default)]
    reading: Vec<Spanned<RawReading>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawReading {
    name: Spanned<String>,
    why: String,
    #[serde(default)]
    set: RawAxes,
    #[serde(default)]
    variants: RawAxes,
    #[serde(default)]
    metrics: RawAxes,
    #[serde(default)]
    test: Vec<Spanned<RawTest>>,
}

impl ClaimSet {
    /// Reads the text of a claim file; `file` names it in errors.
    ///
    /// # Errors
    /// On TOML that is not a claim file, an unknown key, rule or name, a duplicate, and limits that cannot be meant.
    pub fn parse(text: &str, file: &str) -> Result<Self, Error> {
        let line = |offset: usize| {
            1 + text.as_bytes()[..offset.min(text.len())].iter().filter(|&&b| b == b'\n').count()
        };
        let raw: RawFile = toml::from_str(text).map_err(|error| {
            const REMEDY: &str = "a claim file has the tables paper, scene, axes, defaults, variants and claim, and may \
                                  have thresholds, sets and metrics; `reports::claims` describes them";
            let problem = error.message().trim().replace('\n', ", ");
            match error.span() {
                Some(span) => Error::at_line(file, line(span.start), problem, REMEDY),
                None => Error::new(file, problem, REMEDY),
            }
        })?;
        build(raw, &line).map_err(|Problem { offset, problem, remedy }| {
            Error::at_line(file, line(offset), problem, remedy)
        })
    }
}

fn build(raw: RawFile, line: &dyn Fn(usize) -> usize) -> Result<ClaimSet, Problem> {
    let RawFile { paper, scene, thresholds, axes, defaults, variants, sets, metrics, claim } = raw;
    let first = defaults.span().start;
    let mut scenes: Vec<SceneRole> = Vec::new();
    for scene in scene {
        let offset = scene.span().start;
        let scene = scene.into_inner();
        if scenes.iter().any(|other| other.name == scene.name) {
            return Err(duplicate(offset, "scene", &scene.name));
        }
        scenes.push(scene);
    }
    for (id, info) in &metrics {
        if counter_info(id).is_some() {
            let problem = format!("metric '{id}' is a counter already");
            return Err(Problem::new(info.span().start, problem, "remove it, or call it otherwise"));
        }
    }
    for (name, value) in &thresholds {
        if !value.get_ref().is_finite() {
            let problem = format!("threshold {name} is not a finite number");
            return Err(Problem::new(value.span().start, problem, "correct it"));
        }
    }
    let mut names = Names {
        scenes: scenes.iter().map(|scene| scene.name.clone()).collect(),
        axes,
        variants: BTreeMap::new(),
        sets: BTreeMap::new(),
        metrics: metrics.into_iter().map(|(id, info)| (id, info.into_inner())).collect(),
        thresholds: thresholds.into_iter().map(|(name, value)| (name, value.into_inner())).collect(),
    };
    let base = names.read_axes(defaults.into_inner())?;
    if let Some(axis) = names.axes.keys().find(|axis| !base.contains_key(*axis)) {
        let problem = format!("axis {axis} has no default");
        return Err(Problem::new(first, problem, "add it to [defaults]"));
    }
    for (name, axes) in variants {
        let axes = names.read_axes(axes)?;
        names.variants.insert(name, axes);
    }
    for (name, members) in sets {
        let offset = members.span().start;
        if names.variants.contains_key(&name) {
            return Err(duplicate(offset, "set or variant", &name));
        }
        let members = members.into_inner();
        for member in &members {
            names.variant(member, &Replacements::default()).map_err(|problem| {
                Problem::new(offset, format!("set {name}: {problem}"), "correct the set")
            })?;
        }
        names.sets.insert(name, members);
    }
    let mut claims: Vec<Claim> = Vec::new();
    for raw in claim {
        let start = raw.span().start;
        let raw = raw.into_inner();
        if claims.iter().any(|other| other.id == *raw.id.get_ref()) {
            return Err(duplicate(raw.id.span().start, "claim", raw.id.get_ref()));
        }
        claims.push(read_claim(raw, start, &names, &base, line)?);
    }
    Ok(ClaimSet { paper, scenes, metrics: names.metrics, claims })
}

fn duplicate(offset: usize, what: &str, name: &str) -> Problem {
    Problem::new(offset, format!("a second {what} called '{name}'"), "give each its own name")
}

impl Names {
    fn read_axes(&self, raw: RawAxes) -> Result<Axes, Problem> {
        raw.into_iter()
            .map(|(axis, value)| {
                let offset = value.span().start;
                let value = value.into_inner();
                self.check_axis(&axis, &value)
                    .map_err(|problem| Problem::new(offset, problem, "correct it, or extend [axes]"))?;
                Ok((axis, value))
            })
            .collect()
    }
}

fn read_claim(
    raw: RawClaim,
    start: usize,
    names: &Names,
    base: &Axes,
    line: &dyn Fn(usize) -> usize,
) -> Result<Claim, Problem> {
    let RawClaim { id, statement, place, kind, published, note, untested, test, reading } = raw;
    let id = id.into_inner();
    if test.is_empty() {
        let problem = format!("claim {id} has no test");
        return Err(Problem::new(start, problem, "add a [[claim.test]], or one of the rule untestable"));
    }
    let read = |tests: &[Spanned<RawTest>], base: &Axes, fixed: &BTreeSet<String>, new: &Replacements| {
        tests
            .iter()
            .map(|raw| keys::test(raw, line(raw.span().start), names, base, fixed, new))
            .collect::<Result<Vec<Test>, Problem>>()
    };
    let tests = read(&test, base, &BTreeSet::new(), &Replacements::default())?;
    let mut readings: Vec<Reading> = Vec::new();
    for raw in reading {
        let offset = raw.span().start;
        let RawReading { name, why, set, variants, metrics, test: own } = raw.into_inner();
        if readings.iter().any(|other| other.name == *name.get_ref()) {
            return Err(duplicate(name.span().start, "reading", name.get_ref()));
        }
        let name = name.into_inner();
        let replaces = !(set.is_empty() && variants.is_empty() && metrics.is_empty());
        if replaces != own.is_empty() {
            let problem = format!("the reading '{name}' of {id} has both replacements and tests, or neither");
            let remedy = "give set, variants or metrics, or else [[claim.reading.test]] tables";
            return Err(Problem::new(offset, problem, remedy));
        }
        let set = names.read_axes(set)?;
        let mut axes = base.clone();
        axes.extend(set.clone());
        let plain = |raw: RawAxes| raw.into_iter().map(|(old, new)| (old, new.into_inner())).collect();
        let replacements = Replacements::new(plain(variants), plain(metrics));
        let source = if own.is_empty() { &test } else { &own };
        let tests = read(source, &axes, &set.into_keys().collect(), &replacements)?;
        if let Some(name) = replacements.unused() {
            let problem = format!("no test of {id} has the '{name}' that a reading replaces");
            return Err(Problem::new(offset, problem, "replace what the tests name"));
        }
        readings.push(Reading { name, why, tests });
    }
    Ok(Claim { line: line(start), id, statement, place, kind, published, note, untested, tests, readings })
}
