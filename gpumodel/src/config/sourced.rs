//! Figures that carry their source, and the checks that name file, line, key, expectation and remedy.

use crate::error::Error;
use serde::Deserialize;
use std::fmt::Display;
use std::ops::{Range, RangeInclusive};
use toml::Spanned;

/// How far a figure can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tag {
    /// Probed on silicon.
    Measured,
    /// The maker's document or statement.
    Vendor,
    /// Source code of a driver or kernel.
    Driver,
    /// A specification-comparison or news site.
    Aggregator,
    /// Derived by the formula in the figure's source.
    Estimate,
}

impl Tag {
    /// Its name in files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Vendor => "vendor",
            Self::Driver => "driver",
            Self::Aggregator => "aggregator",
            Self::Estimate => "estimate",
        }
    }
}

/// How many figures of a description carry each tag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Tagged [`Tag::Measured`].
    pub measured: usize,
    /// Tagged [`Tag::Vendor`].
    pub vendor: usize,
    /// Tagged [`Tag::Driver`].
    pub driver: usize,
    /// Tagged [`Tag::Aggregator`].
    pub aggregator: usize,
    /// Tagged [`Tag::Estimate`].
    pub estimate: usize,
}

/// A figure as it stands in a file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sourced<T> {
    pub(crate) value: Spanned<T>,
    pub(crate) source: Spanned<String>,
    /// Required, and counted by [`tags`].
    #[serde(rename = "tag")]
    pub(crate) tag: Tag,
}

/// One configuration text, for reading and for complaining about it.
pub(crate) struct File<'a> {
    name: &'a str,
    text: &'a str,
}

impl<'a> File<'a> {
    pub(crate) fn new(name: &'a str, text: &'a str) -> Self {
        Self { name, text }
    }

    /// Reads the whole text; unknown and missing keys are errors.
    pub(crate) fn read<T: for<'de> Deserialize<'de>>(&self) -> Result<T, Error> {
        toml::from_str(self.text).map_err(|error| Error::Config {
            file: self.name.to_owned(),
            line: error.span().and_then(|span| self.line(&span)),
            key: String::new(),
            problem: error.message().replace('\n', ", "),
            remedy: "correct the file, or compare it with the built-in one".to_owned(),
        })
    }

    /// Refuses a figure.
    pub(crate) fn refuse(
        &self,
        key: &str,
        span: &Range<usize>,
        problem: impl Display,
        remedy: &str,
    ) -> Error {
        Error::Config {
            file: self.name.to_owned(),
            line: self.line(span),
            key: format!("{key}: "),
            problem: problem.to_string(),
            remedy: remedy.to_owned(),
        }
    }

    /// A figure within `range`, with a source that says something.
    pub(crate) fn within<T: Copy + PartialOrd + Display>(
        &self,
        key: &str,
        figure: &Sourced<T>,
        range: RangeInclusive<T>,
    ) -> Result<T, Error> {
        let value = *self.sourced(key, figure)?;
        if range.contains(&value) {
            return Ok(value);
        }
        let (low, high) = (range.start(), range.end());
        let problem = format!("is {value}, expected {low} to {high}");
        Err(self.refuse(key, &figure.value.span(), problem, "correct the value"))
    }

    /// A figure of any value, with a source that says something.
    pub(crate) fn sourced<'b, T>(&self, key: &str, figure: &'b Sourced<T>) -> Result<&'b T, Error> {
        self.said(key, &figure.source)?;
        Ok(figure.value.get_ref())
    }

    /// A source that is not empty.
    pub(crate) fn said(&self, key: &str, source: &Spanned<String>) -> Result<(), Error> {
        if source.get_ref().trim().is_empty() {
            let remedy = "say where the figure comes from";
            return Err(self.refuse(key, &source.span(), "has an empty source", remedy));
        }
        Ok(())
    }

    fn line(&self, span: &Range<usize>) -> Option<usize> {
        self.text.get(..span.start).map(|before| before.matches('\n').count() + 1)
    }
}

/// Dotted keys and tags of all figures in a text that has been read once; entries of an array of tables go by their `name` or their `mhz`.
pub(crate) fn tags(text: &str) -> Vec<(String, Tag)> {
    let mut found = Vec::new();
    if let Ok(table) = text.parse::<toml::Table>() {
        walk("", &toml::Value::Table(table), &mut found);
    }
    found
}

fn walk(path: &str, value: &toml::Value, found: &mut Vec<(String, Tag)>) {
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        toml::Value::Table(table) => {
            if let Some(Ok(tag)) = table.get("tag").map(|tag| tag.clone().try_into()) {
                found.push((path.to_owned(), tag));
                return;
            }
            table.iter().for_each(|(key, value)| walk(&join(key), value, found));
        }
        toml::Value::Array(items) => {
            for item in items {
                let name = item.get("name").and_then(toml::Value::as_str);
                let clock = item.get("mhz").and_then(|mhz| mhz.get("value"));
                let name = name.map(str::to_owned).or_else(|| clock.map(toml::Value::to_string));
                walk(&join(name.as_deref().unwrap_or("?")), item, found);
            }
        }
        _ => {}
    }
}

impl Provenance {
    pub(crate) fn of(tags: &[(String, Tag)]) -> Self {
        let mut counts = Self::default();
        for (_, tag) in tags {
            *match tag {
                Tag::Measured => &mut counts.measured,
                Tag::Vendor => &mut counts.vendor,
                Tag::Driver => &mut counts.driver,
                Tag::Aggregator => &mut counts.aggregator,
                Tag::Estimate => &mut counts.estimate,
            } += 1;
        }
        counts
    }
}
