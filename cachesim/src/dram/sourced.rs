//! Figures that carry their source, and the checks that name file, line, key, expectation and remedy.

use std::fmt::Display;
use std::ops::{Range, RangeInclusive};

use serde::Deserialize;
use toml::Spanned;

use crate::error::{Error, Place};

/// How far a figure of a DRAM description can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DramTag {
    /// A table of the standard, as restated in the public file that the source names.
    Standard,
    /// The choice of the program that the source names.
    Driver,
    /// Derived by the formula in the figure's source.
    Estimate,
}

/// A single number.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Figure<T> {
    pub(super) value: Spanned<T>,
    source: Spanned<String>,
    /// Required, and collected by [`estimates`].
    #[serde(rename = "tag")]
    _tag: DramTag,
}

/// The longer of a time and a number of clocks.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Timing {
    ns: Spanned<f64>,
    clocks: Spanned<f64>,
    source: Spanned<String>,
    /// Required, and collected by [`estimates`].
    #[serde(rename = "tag")]
    _tag: DramTag,
}

/// One text of a description, for reading and for complaining about it.
pub(super) struct File<'a> {
    name: &'a str,
    text: &'a str,
}

impl<'a> File<'a> {
    pub(super) fn new(name: &'a str, text: &'a str) -> Self {
        Self { name, text }
    }

    /// Reads the whole text; unknown and missing keys are errors.
    pub(super) fn read<T: for<'de> Deserialize<'de>>(&self) -> Result<T, Error> {
        toml::from_str(self.text).map_err(|error| Error::Dram {
            place: self.place(error.span().as_ref()).into(),
            key: String::new(),
            problem: error.message().replace('\n', ", "),
            remedy: "correct the file, or compare it with the built-in one".to_owned(),
        })
    }

    /// Refuses a figure.
    pub(super) fn refuse(
        &self,
        key: &str,
        span: &Range<usize>,
        problem: impl Display,
        remedy: &str,
    ) -> Error {
        Error::Dram {
            place: self.place(Some(span)).into(),
            key: format!("{key}: "),
            problem: problem.to_string(),
            remedy: remedy.to_owned(),
        }
    }

    /// A number within `range`, with a source that says something.
    pub(super) fn within<T: Copy + PartialOrd + Display>(
        &self,
        key: &str,
        figure: &Figure<T>,
        range: RangeInclusive<T>,
    ) -> Result<T, Error> {
        self.said(key, &figure.source)?;
        self.number(key, &figure.value, range)
    }

    /// A timing whose parts are within what any memory needs, with a source that says something.
    pub(super) fn timing(&self, key: &str, timing: &Timing) -> Result<super::standard::Wait, Error> {
        self.said(key, &timing.source)?;
        let ns = self.number(&format!("{key}.ns"), &timing.ns, 0.0..=1e6)?;
        let clocks = self.number(&format!("{key}.clocks"), &timing.clocks, 0.0..=1e4)?;
        Ok(super::standard::Wait { ns, clocks })
    }

    pub(super) fn number<T: Copy + PartialOrd + Display>(
        &self,
        key: &str,
        number: &Spanned<T>,
        range: RangeInclusive<T>,
    ) -> Result<T, Error> {
        let value = *number.get_ref();
        if range.contains(&value) {
            return Ok(value);
        }
        let problem = format!("is {value}, expected {} to {}", range.start(), range.end());
        Err(self.refuse(key, &number.span(), problem, "correct the value"))
    }

    /// A source that is not empty.
    pub(super) fn said(&self, key: &str, source: &Spanned<String>) -> Result<(), Error> {
        if source.get_ref().trim().is_empty() {
            let remedy = "say where the figure comes from";
            return Err(self.refuse(key, &source.span(), "has an empty source", remedy));
        }
        Ok(())
    }

    fn place(&self, span: Option<&Range<usize>>) -> Place {
        let before = span.and_then(|span| self.text.get(..span.start));
        let line = before.map(|before| before.matches('\n').count() as u64 + 1);
        Place { file: Some(self.name.to_owned()), line, ..Place::default() }
    }
}

impl Timing {
    /// Where the file says it.
    pub(super) fn span(&self) -> Range<usize> {
        self.ns.span()
    }
}

/// Dotted keys of the figures tagged as estimates, in a text that has been read once.
pub(super) fn estimates(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    if let Ok(table) = text.parse::<toml::Table>() {
        walk("", &toml::Value::Table(table), &mut found);
    }
    found
}

fn walk(path: &str, value: &toml::Value, found: &mut Vec<String>) {
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        toml::Value::Table(table) => match table.get("tag").and_then(toml::Value::as_str) {
            Some("estimate") => found.push(path.to_owned()),
            Some(_) => {}
            None => table.iter().for_each(|(key, value)| walk(&join(key), value, found)),
        },
        toml::Value::Array(items) => {
            for item in items {
                let mbps = item.get("mbps").and_then(toml::Value::as_integer);
                let name = mbps.map_or("?".to_owned(), |mbps| mbps.to_string());
                walk(&join(&name), item, found);
            }
        }
        _ => {}
    }
}
