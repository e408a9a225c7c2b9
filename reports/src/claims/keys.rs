//! A test table, key by key: each rule takes the keys that it knows, and what is left over is refused.

use super::model::{Axes, Case, Quantifier, Test, Variant};
use super::names::{Names, Replacements};
use super::rule::{Bound, End, Rule};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use toml::{Spanned, Value};

/// A test as it stands in the file. Its keys depend on its rule, so they are checked here and not by serde.
pub(super) type RawTest = BTreeMap<String, Spanned<Value>>;

/// What is wrong, where in the text, and what to do about it.
pub(super) struct Problem {
    pub(super) offset: usize,
    pub(super) problem: String,
    pub(super) remedy: String,
}

impl Problem {
    pub(super) fn new(offset: usize, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { offset, problem: problem.into(), remedy: remedy.into() }
    }
}

const RULES: &str = "number, order, least, most, similar, correlation, strongest, trend, shift, contrast, swap, property, untestable";
/// Relative differences that an effect may ask for.
const EFFECTS: RangeInclusive<f64> = -0.99..=10.0;

/// The keys of a test that are not read yet.
pub(super) struct Keys<'a> {
    pub(super) rule: String,
    pub(super) start: usize,
    pub(super) left: BTreeMap<&'a str, &'a Spanned<Value>>,
    pub(super) names: &'a Names,
    pub(super) replacements: &'a Replacements,
}

/// Reads a test that begins at `start`; `base` are the axes of its setups before any variant.
pub(super) fn test(
    raw: &Spanned<RawTest>,
    line: usize,
    names: &Names,
    base: &Axes,
    fixed: &BTreeSet<String>,
    replacements: &Replacements,
) -> Result<Test, Problem> {
    let start = raw.span().start;
    let left = raw.get_ref().iter().map(|(key, value)| (key.as_str(), value)).collect();
    let mut keys = Keys { rule: String::new(), start, left, names, replacements };
    keys.rule = keys.text("rule")?;
    let holds = keys.optional("holds", |keys| keys.choice("holds", &Quantifier::NAMES))?;
    let each = keys.optional("each", |keys| keys.variants("each", 1))?;
    let rule = keys.read_rule()?;
    let scenes = match &rule {
        Rule::Number { figures, .. } => {
            names.scenes.iter().filter(|scene| figures.contains_key(*scene)).cloned().collect()
        }
        Rule::Untestable { .. } => Vec::new(),
        _ => keys.optional("scenes", |keys| keys.scenes("scenes"))?.unwrap_or_else(|| names.scenes.clone()),
    };
    keys.finish()?;
    let holds = holds.unwrap_or(Quantifier::All);
    if matches!(rule, Rule::Number { .. }) && holds == Quantifier::Mean {
        return Err(Problem::new(
            start,
            "a number has no mean over scenes",
            "leave holds out, or use majority",
        ));
    }
    check_axes(&rule, each.as_deref().unwrap_or_default(), fixed).map_err(|problem| {
        Problem::new(start, problem, "let every axis be set in one place: by each, by the rule, or by set")
    })?;
    let each: Vec<Option<Variant>> =
        each.map_or_else(|| vec![None], |each| each.into_iter().map(Some).collect());
    let cases = scenes
        .iter()
        .flat_map(|scene| each.iter().map(|each| Case { scene: scene.clone(), each: each.clone() }))
        .collect();
    Ok(Test { line, rule, cases, holds, base: base.clone() })
}

/// No two places may set one axis: one of them would have no effect.
fn check_axes(rule: &Rule, each: &[Variant], fixed: &BTreeSet<String>) -> Result<(), String> {
    let variants = rule.variants();
    for variant in variants.iter().copied().chain(each) {
        if let Some(axis) = variant.axes.keys().find(|axis| fixed.contains(*axis)) {
            return Err(format!("'{}' sets axis {axis}, which the reading sets as well", variant.name));
        }
    }
    for other in each {
        for variant in &variants {
            if let Some(axis) = variant.axes.keys().find(|axis| other.axes.contains_key(*axis)) {
                return Err(format!("'{}' and '{}' of each both set axis {axis}", variant.name, other.name));
            }
        }
    }
    Ok(())
}

impl<'a> Keys<'a> {
    fn read_rule(&mut self) -> Result<Rule, Problem> {
        match self.rule.as_str() {
            "number" => {
                let scale = self.optional("scale", |keys| keys.number("scale", f64::MIN_POSITIVE..=1e12))?;
                Ok(Rule::Number {
                    metric: self.metric("metric")?,
                    of: self.variant("of")?,
                    to: self.optional("to", |keys| keys.variant("to"))?,
                    figures: self.figures("figures", scale.unwrap_or(1.0))?,
                    within: self.number("within", 0.0..=1.0)?,
                })
            }
            "order" => Ok(Rule::Order {
                metric: self.metric("metric")?,
                ascending: self.groups("ascending")?,
                effect: self.number("effect", EFFECTS)?,
            }),
            "least" => self.extreme(End::Least),
            "most" => self.extreme(End::Most),
            "similar" => Ok(Rule::Similar {
                metric: self.metric("metric")?,
                of: self.variant("of")?,
                to: self.variant("to")?,
                ratio: self.band("ratio")?,
            }),
            "correlation" => Ok(Rule::Correlation {
                x: self.metric("x")?,
                y: self.metric("y")?,
                over: self.variants("over", 3)?,
                sign: self.sign()?,
                least: self.number("least", 0.0..=1.0)?,
            }),
            "strongest" => Ok(Rule::Strongest {
                x: self.metric("x")?,
                than: self.metrics("than")?,
                y: self.metric("y")?,
                over: self.variants("over", 3)?,
                sign: self.sign()?,
                effect: self.number("effect", 0.0..=1.0)?,
            }),
            "trend" => Ok(Rule::Trend {
                metric: self.metric("metric")?,
                along: self.variants("along", 2)?,
                direction: self.direction()?,
                effect: self.number("effect", EFFECTS)?,
            }),
            "shift" => Ok(Rule::Shift {
                metric: self.metric("metric")?,
                of: self.variant("of")?,
                to: self.variant("to")?,
                from: self.scene("from")?,
                direction: self.direction()?,
                effect: self.number("effect", EFFECTS)?,
            }),
            "contrast" => {
                let (of, to) = (self.variant("of")?, self.variant("to")?);
                Ok(Rule::Contrast {
                    metric: self.metric("metric")?,
                    lower: self.under("lower", &[&of, &to])?,
                    higher: self.under("higher", &[&of, &to])?,
                    of,
                    to,
                    effect: self.number("effect", EFFECTS)?,
                })
            }
            "swap" => {
                let among = self.variants("among", 2)?;
                let across = self.under("across", &among.iter().collect::<Vec<_>>())?;
                if across.len() < 2 {
                    let problem = format!("{} platforms, expected at least 2", across.len());
                    return Err(Problem::new(self.start, problem, "name more of them in across"));
                }
                Ok(Rule::Swap {
                    metric: self.metric("metric")?,
                    across,
                    effect: self.number("effect", 0.0..=10.0)?,
                })
            }
            "property" => {
                let bound = self.bound()?;
                Ok(Rule::Property { metric: self.metric("metric")?, of: self.variant("of")?, bound })
            }
            "untestable" => Ok(Rule::Untestable { reason: self.text("reason")? }),
            other => {
                let problem = format!("no rule is called '{other}', expected one of {RULES}");
                Err(Problem::new(self.start, problem, "correct the rule"))
            }
        }
    }

    fn extreme(&mut self, end: End) -> Result<Rule, Problem> {
        let offset = self.offset("of");
        let of = self.variant("of")?;
        let mut others = self.variants("among", 2)?;
        let all = others.len();
        others.retain(|other| *other != of);
        if others.len() + 1 != all {
            let problem = format!("'{}' is not among the variants that it is compared with", of.name);
            return Err(Problem::new(offset, problem, "name one of among"));
        }
        let effect = self.number("effect", EFFECTS)?;
        Ok(Rule::Extreme { metric: self.metric("metric")?, end, of, others, effect })
    }

    fn bound(&mut self) -> Result<Bound, Problem> {
        type MakeBound = fn(f64) -> Bound;
        const BOUNDS: [(&str, MakeBound); 3] =
            [("equals", Bound::Equals), ("at_least", Bound::AtLeast), ("at_most", Bound::AtMost)];
        let mut found = BOUNDS.into_iter().filter(|(key, _)| self.left.contains_key(key));
        let (Some((key, make)), None) = (found.next(), found.next()) else {
            return Err(Problem::new(
                self.start,
                "a property has one of equals, at_least, at_most",
                "give exactly one",
            ));
        };
        Ok(make(self.number(key, 0.0..=1e18)?))
    }

    fn finish(self) -> Result<(), Problem> {
        match self.left.iter().min_by_key(|(_, value)| value.span().start) {
            None => Ok(()),
            Some((key, value)) => {
                let problem = format!("the rule {} has no key '{key}'", self.rule);
                let remedy = "remove it; `reports::claims` lists the keys of every rule";
                Err(Problem::new(value.span().start, problem, remedy))
            }
        }
    }
}
