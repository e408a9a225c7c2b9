//! The budget file.

use super::check::Severity;
use crate::error::Error;
use crate::units;
use serde::Deserialize;
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

/// One rule for one counter.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Line of the file, from 1.
    pub line: usize,
    /// Id of the counter.
    pub counter: String,
    /// Name of a pass; none for the whole frame.
    pub pass: Option<String>,
    /// What breaking it means.
    pub severity: Severity,
    /// What must hold.
    pub rule: Rule,
}

/// A budget file, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Budget {
    /// Its name, for errors.
    pub file: String,
    /// Its limits, in file order; soft ones of an entry before hard ones.
    pub limits: Vec<Limit>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawBudget {
    #[serde(default)]
    limit: Vec<Spanned<RawLimit>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLimit {
    counter: Spanned<String>,
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
        const REMEDY: &str =
            "a budget is a list of [[limit]] tables with the keys counter, pass, soft and hard";
        let raw: RawBudget = toml::from_str(text).map_err(|error| refusal(text, file, &error, REMEDY))?;
        if raw.limit.is_empty() {
            return Err(Error::new(file, "no limits, expected at least one", "add a [[limit]] table"));
        }
        let mut limits = Vec::new();
        for raw_limit in raw.limit {
            let start = raw_limit.span().start;
            let RawLimit { counter, pass, soft, hard } = raw_limit.into_inner();
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
        Ok(Self { file: file.to_owned(), limits })
    }
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
