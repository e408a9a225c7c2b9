//! The values of a test's keys, as the names of the file and ranges allow them.

use super::keys::{Keys, Problem};
use super::model::{Metric, Variant};
use super::rule::{Condition, Direction, Sign};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use toml::Value;

impl<'a> Keys<'a> {
    pub(super) fn sign(&mut self) -> Result<Sign, Problem> {
        self.choice("sign", &[("positive", Sign::Positive), ("negative", Sign::Negative)])
    }

    pub(super) fn direction(&mut self) -> Result<Direction, Problem> {
        self.choice("direction", &[("rising", Direction::Rising), ("falling", Direction::Falling)])
    }

    pub(super) fn offset(&self, key: &str) -> usize {
        self.left.get(key).map_or(self.start, |value| value.span().start)
    }

    pub(super) fn optional<T>(
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

    pub(super) fn text(&mut self, key: &str) -> Result<String, Problem> {
        self.with(key, |_, value| text(value).map(str::to_owned))
    }

    pub(super) fn metric(&mut self, key: &str) -> Result<Metric, Problem> {
        self.with(key, |keys, value| keys.names.metric(text(value)?, keys.replacements))
    }

    pub(super) fn metrics(&mut self, key: &str) -> Result<Vec<Metric>, Problem> {
        self.with(key, |keys, value| {
            let metrics: Vec<Metric> = array(value)?
                .iter()
                .map(|value| keys.names.metric(text(value)?, keys.replacements))
                .collect::<Result<_, _>>()?;
            if metrics.is_empty() { Err("an empty list".to_owned()) } else { Ok(metrics) }
        })
    }

    pub(super) fn variant(&mut self, key: &str) -> Result<Variant, Problem> {
        self.with(key, |keys, value| keys.names.variant(text(value)?, keys.replacements))
    }

    pub(super) fn variants(&mut self, key: &str, least: usize) -> Result<Vec<Variant>, Problem> {
        self.with(key, |keys, value| {
            let group = keys.group(value)?;
            if group.len() < least {
                return Err(format!("{} variants, expected at least {least}", group.len()));
            }
            Ok(group)
        })
    }

    /// Each variant of `key` with all of `members`, whose axes must be other ones.
    pub(super) fn under(&mut self, key: &str, members: &[&Variant]) -> Result<Vec<Condition>, Problem> {
        let offset = self.offset(key);
        let with = |outer: Variant| {
            let joined = members.iter().map(|member| {
                outer.with(member).map_err(|axis| {
                    let problem =
                        format!("'{}' and '{}' of {key} both set axis {axis}", member.name, outer.name);
                    Problem::new(offset, problem, "let every axis be set in one place")
                })
            });
            Ok(Condition { name: outer.name.clone(), among: joined.collect::<Result<_, _>>()? })
        };
        self.variants(key, 1)?.into_iter().map(with).collect()
    }

    pub(super) fn groups(&mut self, key: &str) -> Result<Vec<Vec<Variant>>, Problem> {
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

    pub(super) fn scene(&mut self, key: &str) -> Result<String, Problem> {
        self.with(key, |keys, value| {
            let name = text(value)?;
            keys.names.check_scene(name).map(|()| name.to_owned())
        })
    }

    pub(super) fn scenes(&mut self, key: &str) -> Result<Vec<String>, Problem> {
        self.with(key, |keys, value| {
            let scenes: Vec<String> =
                array(value)?.iter().map(|value| text(value).map(str::to_owned)).collect::<Result<_, _>>()?;
            scenes.iter().try_for_each(|scene| keys.names.check_scene(scene))?;
            distinct(&scenes)?;
            if scenes.is_empty() { Err("an empty list".to_owned()) } else { Ok(scenes) }
        })
    }

    pub(super) fn number(&mut self, key: &str, allowed: RangeInclusive<f64>) -> Result<f64, Problem> {
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

    pub(super) fn band(&mut self, key: &str) -> Result<[f64; 2], Problem> {
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

    pub(super) fn figures(&mut self, key: &str, scale: f64) -> Result<BTreeMap<String, f64>, Problem> {
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

    pub(super) fn choice<T: Copy>(&mut self, key: &str, choices: &[(&str, T)]) -> Result<T, Problem> {
        self.with(key, |_, value| {
            let name = text(value)?;
            choices.iter().find(|(known, _)| *known == name).map(|(_, choice)| *choice).ok_or_else(|| {
                let known: Vec<&str> = choices.iter().map(|(known, _)| *known).collect();
                format!("'{name}', expected one of {}", known.join(", "))
            })
        })
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
