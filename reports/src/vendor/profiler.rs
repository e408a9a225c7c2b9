//! A profiler's counters as data: `configs/counters/*.toml`, read and checked.

use super::expression::Expression;
use super::figures::GPU_FIGURES;
use crate::error::Error;
use crate::units;
use gpumodel::Family;
use serde::Deserialize;
use toml::Spanned;

/// Files that come with the program.
const FILES: [(&str, &str); 2] = [
    ("configs/counters/snapdragon.toml", include_str!("../../../configs/counters/snapdragon.toml")),
    ("configs/counters/streamline.toml", include_str!("../../../configs/counters/streamline.toml")),
];

/// A maker's profiler and its counters.
#[derive(Clone, Debug, PartialEq)]
pub struct Profiler {
    /// What it is called.
    pub name: String,
    /// Whose GPUs it looks into.
    pub family: Family,
    /// Its counters, by group.
    pub counters: Vec<VendorInfo>,
}

/// What a counter of a profiler is, and how it is made of ours.
#[derive(Clone, Debug, PartialEq)]
pub struct VendorInfo {
    /// Its exact name.
    pub name: String,
    /// What the hardware calls it; empty where that is not published.
    pub hardware: String,
    /// The GPUs that have it; empty for all of the family.
    pub gpus: String,
    /// Group or family in the profiler's list.
    pub group: String,
    /// Unit of the figure.
    pub unit: String,
    /// What it counts, in the vendor's words, shortened.
    pub definition: String,
    /// Where name and definition come from.
    pub source: String,
    /// In what the model's figure is not quite that; empty where it is.
    pub note: String,
    /// How it is made of ours.
    pub formula: Formula,
}

/// How a vendor's counter is made of ours.
#[derive(Clone, Debug, PartialEq)]
pub enum Formula {
    /// By this formula of counters and figures of the GPU.
    Known(KnownFormula),
    /// Not at all.
    Absent {
        /// Why.
        reason: String,
    },
}

/// A formula that has been read and whose names are known.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownFormula {
    text: String,
    pub(super) expression: Expression,
}

impl KnownFormula {
    /// As it stands in the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The one counter of ours that this is in another unit, if it is that.
    pub fn renames(&self) -> Option<&str> {
        let mut counters = self.expression.names();
        let first = counters.next()?;
        (counters.next().is_none() && units::counter_info(first).is_some()).then_some(first)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawProfiler {
    profiler: String,
    family: Family,
    #[serde(rename = "counter")]
    counters: Vec<RawCounter>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCounter {
    name: Spanned<String>,
    group: String,
    unit: String,
    definition: String,
    source: String,
    #[serde(default)]
    hardware: String,
    #[serde(default)]
    gpus: String,
    #[serde(default)]
    note: String,
    formula: Option<Spanned<String>>,
    absent: Option<String>,
}

impl Profiler {
    /// All profilers that the program knows.
    ///
    /// # Errors
    /// As [`Self::parse`]; never, as a test shows.
    pub fn all() -> Result<Vec<Self>, Error> {
        FILES.iter().map(|(file, text)| Self::parse(text, file)).collect()
    }

    /// The profiler that looks into GPUs of `family`, where there is one.
    ///
    /// # Errors
    /// As [`Self::all`].
    pub fn of(family: Family) -> Result<Option<Self>, Error> {
        Ok(Self::all()?.into_iter().find(|profiler| profiler.family == family))
    }

    /// Reads and checks a file; `file` names it in errors.
    ///
    /// # Errors
    /// When it is not TOML, has other keys, or a counter has no name, unit, definition or source, stands there twice, has neither
    /// formula nor reason or both, or a formula that cannot be read or names what there is not.
    pub fn parse(text: &str, file: &str) -> Result<Self, Error> {
        let line = |at: usize| text.get(..at).map_or(1, |before| before.matches('\n').count() + 1);
        let raw: RawProfiler = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            Error::at_line(file, line(at), error.message().replace('\n', ", "), "correct the file")
        })?;
        let mut counters: Vec<VendorInfo> = Vec::new();
        for raw in raw.counters {
            let RawCounter { name, group, unit, definition, source, hardware, gpus, note, formula, absent } =
                raw;
            let at = name.span().start;
            let name = name.into_inner();
            let refuse = |at: usize, problem: String, remedy: &str| {
                Error::at_line(file, line(at), format!("counter '{name}': {problem}"), remedy)
            };
            if [&name, &group, &definition, &source].iter().any(|text| text.trim().is_empty()) {
                let problem = "has an empty name, group, definition or source".to_owned();
                return Err(refuse(at, problem, "say what it is and where that is published"));
            }
            if counters.iter().any(|other| other.name == name) {
                return Err(refuse(at, "is there twice".to_owned(), "take one of them out"));
            }
            let formula = match (formula, absent) {
                (Some(text), None) => known(text.get_ref())
                    .map(Formula::Known)
                    .map_err(|problem| refuse(text.span().start, problem, "correct its formula"))?,
                (None, Some(reason)) if !reason.trim().is_empty() => Formula::Absent { reason },
                _ => {
                    let problem = "expected either a formula or the reason why it is absent".to_owned();
                    return Err(refuse(at, problem, "give one of the two"));
                }
            };
            counters.push(VendorInfo {
                name,
                hardware,
                gpus,
                group,
                unit,
                definition,
                source,
                note,
                formula,
            });
        }
        Ok(Self { name: raw.profiler, family: raw.family, counters })
    }

    /// Groups in the order of the file, each once.
    pub fn groups(&self) -> Vec<&str> {
        let mut groups: Vec<&str> = Vec::new();
        for counter in &self.counters {
            if !groups.contains(&counter.group.as_str()) {
                groups.push(&counter.group);
            }
        }
        groups
    }
}

/// A formula all of whose names are counters or figures of a GPU.
fn known(text: &str) -> Result<KnownFormula, String> {
    let expression = Expression::parse(text).map_err(|mistake| format!("'{text}': {mistake}"))?;
    let is_known = |name: &str| {
        units::counter_info(name).is_some() || GPU_FIGURES.iter().any(|figure| figure.name == name)
    };
    if let Some(stranger) = expression.names().find(|name| !is_known(name)) {
        let figures: Vec<&str> = GPU_FIGURES.iter().map(|figure| figure.name).collect();
        return Err(format!(
            "'{text}': '{stranger}' is neither a counter of `raybudget list counters` nor one of {}",
            figures.join(", ")
        ));
    }
    Ok(KnownFormula { text: text.to_owned(), expression })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
profiler = "P"
family = "mali"

[[counter]]
name = "Rays"
group = "G"
unit = "rays"
definition = "rays"
source = "a page"
formula = "2 * rays / cores"
"#;

    fn refused(from: &str, to: &str) -> String {
        assert!(GOOD.contains(from), "{from}");
        Profiler::parse(&GOOD.replacen(from, to, 1), "p.toml").expect_err(to).to_string()
    }

    #[test]
    fn the_files_of_the_program_are_sound() {
        let profilers = Profiler::all().expect("sound");
        let names: Vec<(&str, usize)> =
            profilers.iter().map(|profiler| (profiler.name.as_str(), profiler.counters.len())).collect();
        assert_eq!(names, [("Snapdragon Profiler", 42), ("Streamline", 72)]);
        for profiler in &profilers {
            let groups = profiler.groups();
            let in_order: Vec<&str> =
                profiler.counters.iter().map(|counter| counter.group.as_str()).collect();
            assert!(in_order.is_sorted_by_key(|group| groups.iter().position(|known| known == group)));
        }
        assert_eq!(Profiler::of(Family::Other), Ok(None));
    }

    #[test]
    fn a_file_that_makes_no_sense_is_refused_with_its_line_and_remedy() {
        Profiler::parse(GOOD, "p.toml").expect("sound as it is");
        let again = GOOD.split_once("[[counter]]").expect("a counter").1;
        for (from, to, expected) in [
            ("family = \"mali\"", "family = \"voodoo\"", "p.toml:3: "),
            ("group = ", "grupp = ", "grupp"),
            ("definition = \"rays\"", "definition = \" \"", "p.toml:6: counter 'Rays': has an empty"),
            ("formula = ", "absent = \"why\"\nformula = ", "either a formula or the reason"),
            ("formula = \"2 * rays / cores\"", "absent = \"\"", "either a formula or the reason"),
            ("formula = \"2 * rays / cores\"", "", "either a formula or the reason"),
            (
                "2 * rays",
                "2 * raise",
                "p.toml:11: counter 'Rays': '2 * raise / cores': 'raise' is neither a counter",
            ),
            ("2 * rays", "2 ** rays", "expected a number, a name, a sign or '(' at character 4"),
            ("[[counter]]", &format!("[[counter]]{again}[[counter]]"), "counter 'Rays': is there twice"),
        ] {
            let message = refused(from, to);
            assert!(
                message.contains(expected) && message.starts_with("p.toml") && message.contains("; "),
                "{message}"
            );
        }
    }

    #[test]
    fn a_counter_in_another_unit_is_a_rename() {
        let renames = |formula: &str| known(formula).expect("a formula").renames().map(str::to_owned);
        assert_eq!(renames("rays").as_deref(), Some("rays"));
        assert_eq!(renames("100 * l2_miss_ratio").as_deref(), Some("l2_miss_ratio"));
        assert_eq!(renames("rays / (frame_time_ms / 1000)"), None);
        assert_eq!(renames("clock_hz"), None);
        assert_eq!(renames("1"), None);
    }
}
