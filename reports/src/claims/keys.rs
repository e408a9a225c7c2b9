//! A test table, key by key: each rule takes the keys that it knows, and what is left over is refused.

use super::model::{Axes, Case, Metric, Quantifier, Test, Variant};
use super::names::{Names, Replacements};
use super::rule::{Bound, Direction, End, Rule, Sign};
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

const RULES: &str =
    "number, order, least, most, similar, correlation, strongest, trend, shift, property, untestable";
/// Relative differences that an effect may ask for.
const EFFECTS: RangeInclusive<f64> = -0.99..=10.0;

struct Keys<'a> {
    rule: String,
    start: usize,
    left: BTreeMap<&'a str, &'a Spanned<Value>>,
    names: &'a Names,
    replacements: &'a Replacements,
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

    fn sign(&mut self) -> Result<Sign, Problem> {
        self.choice("sign", &[("positive", Sign::Positive), ("negative", Sign::Negative)])
    }

    fn direction(&mut self) -> Result<Direction, Problem> {
        self.choice("direction", &[("rising", Direction::Rising), ("falling", Direction::Falling)])
    }

    fn offset(&self, key: &str) -> usize {
        self.left.get(key).map_or(self.start, |value| value.span().start)
    }

    fn optional<T>(
        &mut self,
        key: &str,
        read: impl FnOnce(&mut Self) -> Result<T, Problem>,
    ) -> Result<Option<T>, Problem> {
        if self.left.contains_key(key) { read(self).map(Some) } else { Ok(None) }
    }

    fn take(&mut self, key: &str) -> Result<(usize, &'a Value), Problem> {
        match self.left.remove(key) {
            Some(value) => Ok((value.span().start, value.get_ref())),
            None => {
                let rule = if self.rule.is_empty() { "test" } else { &self.rule };
                let problem = format!("a {rule} without the key '{key}'");
                Err(Problem::new(
                    self.start,
                    problem,
                    "add it; `reports::claims` lists the keys of every rule",
                ))
            }
        }
    }

    /// Takes a key and reads it with `read`, which gives what is wrong.
    fn with<T>(
        &mut self,
        key: &str,
        read: impl FnOnce(&Self, &Value) -> Result<T, String>,
    ) -> Result<T, Problem> {
        let (offset, value) = self.take(key)?;
        read(self, value)
            .map_err(|problem| Problem::new(offset, format!("{key}: {problem}"), "correct the value"))
    }

    fn text(&mut self, key: &str) -> Result<String, Problem> {
        self.with(key, |_, value| text(value).map(str::to_owned))
    }

    fn metric(&mut self, key: &str) -> Result<Metric, Problem> {
        self.with(key, |keys, value| keys.names.metric(text(value)?, keys.replacements))
    }

    fn metrics(&mut self, key: &str) -> Result<Vec<Metric>, Problem> {
        self.with(key, |keys, value| {
            let metrics: Vec<Metric> = array(value)?
                .iter()
                .map(|value| keys.names.metric(text(value)?, keys.replacements))
                .collect::<Result<_, _>>()?;
            if metrics.is_empty() { Err("an empty list".to_owned()) } else { Ok(metrics) }
        })
    }

    fn variant(&mut self, key: &str) -> Result<Variant, Problem> {
        self.with(key, |keys, value| keys.names.variant(text(value)?, keys.replacements))
    }

    fn variants(&mut self, key: &str, least: usize) -> Result<Vec<Variant>, Problem> {
        self.with(key, |keys, value| {
            let group = keys.group(value)?;
            if group.len() < least {
                return Err(format!("{} variants, expected at least {least}", group.len()));
            }
            Ok(group)
        })
    }

    fn groups(&mut self, key: &str) -> Result<Vec<Vec<Variant>>, Problem> {
        self.with(key, |keys, value| {
            let groups: Vec<Vec<Variant>> =
                array(value)?.iter().map(|value| keys.group(value)).collect::<Result<_, _>>()?;
            if groups.len() < 2 {
                return Err(format!("{} groups, expected at least 2", groups.len()));
            }
            distinct(groups.iter().flatten().map(|variant| &variant.name))?;
            Ok(groups)
        })
    }

    /// A set, a variant, or a list of variants.
    fn group(&self, value: &Value) -> Result<Vec<Variant>, String> {
        let group = match value {
            Value::String(name) => self.names.group(name, self.replacements)?,
            _ => array(value)?
                .iter()
                .map(|value| self.names.variant(text(value)?, self.replacements))
                .collect::<Result<Vec<_>, _>>()?,
        };
        distinct(group.iter().map(|variant| &variant.name))?;
        if group.is_empty() { Err("an empty list".to_owned()) } else { Ok(group) }
    }

    fn scene(&mut self, key: &str) -> Result<String, Problem> {
        self.with(key, |keys, value| {
            let name = text(value)?;
            keys.names.check_scene(name).map(|()| name.to_owned())
        })
    }

    fn scenes(&mut self, key: &str) -> Result<Vec<String>, Problem> {
        self.with(key, |keys, value| {
            let scenes: Vec<String> =
                array(value)?.iter().map(|value| text(value).map(str::to_owned)).collect::<Result<_, _>>()?;
            scenes.iter().try_for_each(|scene| keys.names.check_scene(scene))?;
            distinct(&scenes)?;
            if scenes.is_empty() { Err("an empty list".to_owned()) } else { Ok(scenes) }
        })
    }

    fn number(&mut self, key: &str, allowed: RangeInclusive<f64>) -> Result<f64, Problem> {
        self.with(key, |keys, value| {
            let number = match value {
                Value::String(name) => keys.names.threshold(name)?,
                _ => number(value)?,
            };
            if allowed.contains(&number) {
                Ok(number)
            } else {
                Err(format!("{number}, expected a number from {:e} to {:e}", allowed.start(), allowed.end()))
            }
        })
    }

    fn band(&mut self, key: &str) -> Result<[f64; 2], Problem> {
        self.with(key, |_, value| match array(value)? {
            [low, high] => {
                let [low, high] = [number(low)?, number(high)?];
                if low > 0.0 && low <= high && high.is_finite() {
                    Ok([low, high])
                } else {
                    Err(format!("[{low}, {high}], expected two ratios above 0, the smaller first"))
                }
            }
            other => Err(format!("{} numbers, expected 2", other.len())),
        })
    }

    fn figures(&mut self, key: &str, scale: f64) -> Result<BTreeMap<String, f64>, Problem> {
        self.with(key, |keys, value| {
            let table = value.as_table().ok_or_else(|| unexpected(value, "a table of scenes"))?;
            let mut figures = BTreeMap::new();
            for (scene, value) in table {
                keys.names.check_scene(scene)?;
                let figure = number(value)? * scale;
                if !(figure > 0.0 && figure.is_finite()) {
                    return Err(format!("{figure} for {scene}, expected a finite figure above 0"));
                }
                figures.insert(scene.clone(), figure);
            }
            if figures.is_empty() { Err("no figure".to_owned()) } else { Ok(figures) }
        })
    }

    fn choice<T: Copy>(&mut self, key: &str, choices: &[(&str, T)]) -> Result<T, Problem> {
        self.with(key, |_, value| {
            let name = text(value)?;
            choices.iter().find(|(known, _)| *known == name).map(|(_, choice)| *choice).ok_or_else(|| {
                let known: Vec<&str> = choices.iter().map(|(known, _)| *known).collect();
                format!("'{name}', expected one of {}", known.join(", "))
            })
        })
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

fn unexpected(value: &Value, expected: &str) -> String {
    format!("a value of type {}, expected {expected}", value.type_str())
}

fn text(value: &Value) -> Result<&str, String> {
    value.as_str().ok_or_else(|| unexpected(value, "text"))
}

fn array(value: &Value) -> Result<&[Value], String> {
    value.as_array().map(Vec::as_slice).ok_or_else(|| unexpected(value, "a list"))
}

fn number(value: &Value) -> Result<f64, String> {
    match value {
        Value::Integer(integer) => Ok(*integer as f64),
        Value::Float(float) => Ok(*float),
        _ => Err(unexpected(value, "a number")),
    }
}

fn distinct<'a>(names: impl IntoIterator<Item = &'a String>) -> Result<(), String> {
    let mut seen = BTreeSet::new();
    match names.into_iter().find(|name| !seen.insert(*name)) {
        Some(twice) => Err(format!("'{twice}' stands there twice")),
        None => Ok(()),
    }
}
