//! Figures that carry their source, and the checks that name file, line, key, expectation and remedy.

use crate::error::Error;
use serde::Deserialize;
use std::fmt::Display;
use std::ops::{Range, RangeInclusive};
use toml::Spanned;

/// How far a figure can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Tag {
    Measured,
    Vendor,
    Driver,
    Aggregator,
    /// Derived by the formula in the figure's source.
    Estimate,
}

/// A figure as it stands in a file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sourced {
    value: Spanned<f64>,
    source: Spanned<String>,
    tag: Tag,
}

/// One text of a description, for reading and for complaining about it.
pub(crate) struct File<'a> {
    pub(crate) name: &'a str,
    pub(crate) text: &'a str,
}

impl File<'_> {
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

    /// Refuses what stands at a place.
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
    pub(crate) fn within(
        &self,
        key: &str,
        figure: &Sourced,
        range: RangeInclusive<f64>,
    ) -> Result<f64, Error> {
        if figure.source.get_ref().trim().is_empty() {
            let remedy = "say where the figure comes from";
            return Err(self.refuse(key, &figure.source.span(), "has an empty source", remedy));
        }
        let value = *figure.value.get_ref();
        if range.contains(&value) {
            return Ok(value);
        }
        let problem = format!("is {value}, expected {} to {}", range.start(), range.end());
        Err(self.refuse(key, &figure.value.span(), problem, "correct the value"))
    }

    fn line(&self, span: &Range<usize>) -> Option<usize> {
        self.text.get(..span.start).map(|before| before.matches('\n').count() + 1)
    }
}

impl Sourced {
    pub(crate) fn is_estimate(&self) -> bool {
        self.tag == Tag::Estimate
    }

    pub(crate) fn span(&self) -> Range<usize> {
        self.value.span()
    }
}
