//! The budget file.

use super::check::Severity;
use crate::error::Error;
use crate::units;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A change against a baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// In the counter's unit.
    Absolute(f64),
    /// In percent of the baseline's figure.
    Percent(f64),
}

/// What a counter must keep to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// At most this.
    Max(f64),
    /// At least this.
    Min(f64),
    /// At most this much above the baseline.
    MaxIncrease(Change),
    /// At most this much below the baseline.
    MaxDecrease(Change),
    /// At least this much above the baseline: an improvement that is asked for.
    MinIncrease(Change),
    /// At least this much below the baseline: an improvement that is asked for.
    MinDecrease(Change),
}

/// Which frames a limit is for: those that have all that is given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Name of the frame in the budget.
    pub frame: Option<String>,
    /// Name of the scene in the report.
    pub scene: Option<String>,
    /// Name of the GPU in the report.
    pub gpu: Option<String>,
    /// Name of the technique in the report.
    pub technique: Option<String>,
}

/// One rule for one counter.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Line of the file, from 1.
    pub line: usize,
    /// Which frames it is for.
    pub selection: Selection,
    /// What it is told with.
    pub group: Option<String>,
    /// Id of the counter.
    pub counter: String,
    /// Name of a pass; none for the whole frame.
    pub pass: Option<String>,
    /// What breaking it means.
    pub severity: Severity,
    /// What must hold.
    pub rule: Rule,
}

/// Options of a frame by their names, which the command line knows.
pub type RawOptions = BTreeMap<Spanned<String>, toml::Value>;

/// A frame that a budget names.
#[derive(Clone, Debug, PartialEq)]
pub struct BudgetFrame {
    /// Line of the file, from 1.
    pub line: usize,
    /// Its name; no other frame of the budget has it.
    pub name: String,
    /// Its options, besides those of [`Budget::base`].
    pub options: RawOptions,
}

/// A budget file, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Budget {
    /// Its name, for errors.
    pub file: String,
    /// Options of all its frames.
    pub base: RawOptions,
    /// The frames that it is for; empty where it is for whatever is checked.
    pub frames: Vec<BudgetFrame>,
    /// Its limits, in file order; soft ones of an entry before hard ones.
    pub limits: Vec<Limit>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawBudget {
    #[serde(default)]
    base: Option<Spanned<RawOptions>>,
    #[serde(default)]
    frame: Vec<Spanned<RawOptions>>,
    #[serde(default)]
    limit: Vec<Spanned<RawLimit>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLimit {
    counter: Spanned<String>,
    frame: Option<Spanned<String>>,
    scene: Option<String>,
    gpu: Option<String>,
    technique: Option<String>,
    group: Option<String>,
    pass: Option<String>,
    soft: Option<Spanned<RawRules>>,
    hard: Option<Spanned<RawRules>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRules {
    max: Option<Spanned<f64>>,
    min: Option<Spanned<f64>>,
    max_increase: Option<Spanned<RawChange>>,
    max_decrease: Option<Spanned<RawChange>>,
    min_increase: Option<Spanned<RawChange>>,
    min_decrease: Option<Spanned<RawChange>>,
}

#[derive(Clone, Deserialize)]
#[serde(untagged, expecting = "expected a number in the counter's unit, or text such as \"5 %\"")]
enum RawChange {
    Absolute(f64),
    Percent(String),
}

impl Budget {
    /// Reads the text of a budget file; `file` names it in errors.
    ///
    /// # Errors
    /// On TOML that is not a budget, an unknown key or counter, a limit without rules, and figures that are not finite.
    pub fn parse(text: &str, file: &str) -> Result<Self, Error> {
        let line = |offset: usize| line(text, offset);
        const REMEDY: &str = "a budget is a list of [[limit]] tables with the keys counter, frame, scene, gpu, technique, group, pass, soft and hard, \
             and may have [[frame]] tables and [base]";
        let raw: RawBudget = toml::from_str(text).map_err(|error| refusal(text, file, &error, REMEDY))?;
        if raw.limit.is_empty() {
            return Err(Error::new(file, "no limits, expected at least one", "add a [[limit]] table"));
        }
        let frames = frames(raw.frame, file, line)?;
        let base = match raw.base {
            Some(base) if frames.is_empty() => {
                let problem = "[base] without a [[frame]]";
                let remedy = "add frames, or give the options on the command line";
                return Err(Error::at_line(file, line(base.span().start), problem, remedy));
            }
            base => base.map(Spanned::into_inner).unwrap_or_default(),
        };
        let mut limits = Vec::new();
        for raw_limit in raw.limit {
            let start = raw_limit.span().start;
            let RawLimit { counter, frame, scene, gpu, technique, group, pass, soft, hard } =
                raw_limit.into_inner();
            let known = |name: &Spanned<String>| frames.iter().any(|frame| frame.name == *name.get_ref());
            if let Some(name) = frame.as_ref().filter(|name| !known(name)) {
                let names: Vec<&str> = frames.iter().map(|frame| frame.name.as_str()).collect();
                return Err(Error::at_line(
                    file,
                    line(name.span().start),
                    format!("no frame is called '{}'", name.get_ref()),
                    match names.len() {
                        0 => {
                            "add a [[frame]] with this name, or select by scene, gpu or technique".to_owned()
                        }
                        _ => format!("use one of: {}", names.join(", ")),
                    },
                ));
            }
            if let Some(name) = group.as_ref().filter(|name| name.contains(char::is_control)) {
                let remedy = "leave line feeds and other control characters out";
                return Err(Error::at_line(file, line(start), format!("a group called {name:?}"), remedy));
            }
            let frame = frame.map(Spanned::into_inner);
            let selection = Selection { frame, scene, gpu, technique };
            let counter_line = line(counter.span().start);
            let counter = counter.into_inner();
            if units::counter_info(&counter).is_none() {
                return Err(Error::at_line(
                    file,
                    counter_line,
                    format!("no counter is called '{counter}'{}", suggestion(&counter)),
                    "see `raybudget list counters`",
                ));
            }
            let before = limits.len();
            for (severity, rules) in [(Severity::Soft, soft), (Severity::Hard, hard)] {
                let Some(rules) = rules else { continue };
                for (offset, rule) in rules.into_inner().rules() {
                    let line = line(offset);
                    rule.and_then(check)
                        .map(|rule| {
                            limits.push(Limit {
                                line,
                                selection: selection.clone(),
                                group: group.clone(),
                                counter: counter.clone(),
                                pass: pass.clone(),
                                severity,
                                rule,
                            });
                        })
                        .map_err(|problem| Error::at_line(file, line, problem, "correct the limit"))?;
                }
            }
            if limits.len() == before {
                return Err(Error::at_line(
                    file,
                    line(start),
                    format!("the limit on {counter} has no rule"),
                    "add one, such as hard = { max = 16.6 }",
                ));
            }
        }
        Ok(Self { file: file.to_owned(), base, frames, limits })
    }
}

/// The frames, each with a name of its own.
fn frames(
    raw: Vec<Spanned<RawOptions>>,
    file: &str,
    line: impl Fn(usize) -> usize,
) -> Result<Vec<BudgetFrame>, Error> {
    let mut frames: Vec<BudgetFrame> = Vec::new();
    for table in raw {
        let line = line(table.span().start);
        let mut options = table.into_inner();
        let key = options.keys().find(|key| key.get_ref() == "name").cloned();
        let name = key.and_then(|key| options.remove(&key));
        let Some(name) = name.as_ref().and_then(toml::Value::as_str).filter(|name| !name.is_empty()) else {
            let remedy = "give it one, such as name = \"cornell\"";
            return Err(Error::at_line(file, line, "a frame without a name", remedy));
        };
        if name.contains(char::is_control) {
            let remedy = "leave line feeds and other control characters out";
            return Err(Error::at_line(file, line, format!("a frame called {name:?}"), remedy));
        }
        if frames.iter().any(|frame| frame.name == name) {
            let problem = format!("a second frame called '{name}'");
            return Err(Error::at_line(file, line, problem, "give each frame a name of its own"));
        }
        frames.push(BudgetFrame { line, name: name.to_owned(), options });
    }
    Ok(frames)
}

/// The line of a place in a text, from 1.
fn line(text: &str, offset: usize) -> usize {
    1 + text.as_bytes()[..offset.min(text.len())].iter().filter(|&&b| b == b'\n').count()
}

/// What a text is refused with that is no such TOML.
pub(super) fn refusal(text: &str, file: &str, error: &toml::de::Error, remedy: &str) -> Error {
    let problem = error.message().trim().replace('\n', ", ");
    match error.span() {
        Some(span) => Error::at_line(file, line(text, span.start), problem, remedy),
        None => Error::new(file, problem, remedy),
    }
}

impl RawRules {
    /// The rules that are there, each with its place in the text.
    fn rules(self) -> Vec<(usize, Result<Rule, String>)> {
        let Self { max, min, max_increase, max_decrease, min_increase, min_decrease } = self;
        let number =
            |raw: Spanned<f64>, rule: fn(f64) -> Rule| (raw.span().start, Ok(rule(raw.into_inner())));
        let change = |raw: Spanned<RawChange>, rule: fn(Change) -> Rule| {
            (raw.span().start, raw.into_inner().read().map(rule))
        };
        [
            max.map(|raw| number(raw, Rule::Max)),
            min.map(|raw| number(raw, Rule::Min)),
            max_increase.map(|raw| change(raw, Rule::MaxIncrease)),
            max_decrease.map(|raw| change(raw, Rule::MaxDecrease)),
            min_increase.map(|raw| change(raw, Rule::MinIncrease)),
            min_decrease.map(|raw| change(raw, Rule::MinDecrease)),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

impl RawChange {
    fn read(self) -> Result<Change, String> {
        match self {
            Self::Absolute(number) => Ok(Change::Absolute(number)),
            Self::Percent(text) => text
                .strip_suffix('%')
                .and_then(|number| number.trim().parse().ok())
                .map(Change::Percent)
                .ok_or_else(|| format!("a change of '{text}', expected a number or text such as \"5 %\"")),
        }
    }
}

fn check(rule: Rule) -> Result<Rule, String> {
    match rule {
        Rule::Max(number) | Rule::Min(number) if number.is_finite() => Ok(rule),
        Rule::Max(number) | Rule::Min(number) => {
            Err(format!("a limit of {number}, expected a finite number"))
        }
        Rule::MaxIncrease(change)
        | Rule::MaxDecrease(change)
        | Rule::MinIncrease(change)
        | Rule::MinDecrease(change) => {
            let (Change::Absolute(number) | Change::Percent(number)) = change;
            if number.is_finite() && number >= 0.0 {
                Ok(rule)
            } else {
                Err(format!("a change of {number}, expected a finite number of at least 0"))
            }
        }
    }
}

/// The known id that shares the longest start with a misspelt one.
fn suggestion(wrong: &str) -> String {
    let shared = |id: &str| id.bytes().zip(wrong.bytes()).take_while(|(a, b)| a == b).count();
    let best = gpumodel::COUNTERS.iter().map(|info| info.id).max_by_key(|id| shared(id));
    best.filter(|id| shared(id) >= 3).map(|id| format!(" (the nearest is '{id}')")).unwrap_or_default()
}
