//! Claims: what a paper states, as data, and whether measurements reproduce it.
//!
//! A claim file names a paper, the scenes it used, the axes of a setup, the metrics, and its statements. Each statement
//! has tests, all of which must hold, and may have readings: other meanings of its words, or other assumptions about the
//! machine, tested beside it. This module knows no paper: [`ClaimSet::needs`] says what to measure,
//! [`ClaimSet::evaluate`] turns [`Measurements`] into [`Verdict`]s. What was not measured makes a claim untestable, with
//! the reason; it is never passed over.
//!
//! ```toml
//! [[claim]]
//! id = "A42"
//! statement = "Hybrid rendering is significantly faster than fragment and compute rendering"
//! where = "5.4, figure 14"
//! kind = "order"                        # number, order or qualitative
//! [[claim.test]]
//! rule = "order"
//! metric = "fps"                        # a counter, a metric of the file, or one over another: "a / b"
//! ascending = ["one-kernel", "hybrid"]  # variants, sets of them, or lists
//! effect = "considerable"               # a threshold of the file, or a number
//! each = "traversals"                   # optional: one case for each of these in each scene
//! scenes = ["cornell"]                  # optional: else all scenes
//! holds = "all"                         # optional: all, majority, some, or mean
//! [[claim.reading]]
//! name = "32 ALU lanes per core"
//! why = "published counts range from 32 to 96"
//! set = { gpu = "alu-32-per-core" }     # or variants, metrics = { old = "new" }; or [[claim.reading.test]] tables
//! ```
//!
//! | rule | keys | holds where |
//! |---|---|---|
//! | `number` | metric, of, to, figures, scale, within | metric, or of / to where there is a `to`, is within the tolerance of the paper's figure x scale; stand-in scenes never count |
//! | `order` | metric, ascending, effect | each step exceeds the one before by the effect; members of a set are not ordered |
//! | `least`, `most` | metric, of, among, effect | `of` is below (above) all others of the set by the effect |
//! | `similar` | metric, of, to, ratio | of / to lies in the band, ends included |
//! | `correlation` | x, y, over, sign, least | Spearman's rank correlation over the variants has that sign and at least that size |
//! | `strongest` | x, than, y, over, sign, effect | the correlation of x with y exceeds those of the others with y by the effect |
//! | `trend` | metric, along, direction, effect | no step goes the other way, and first to last is at least the effect |
//! | `shift` | metric, of, to, from, direction, effect | of / to differs from its value in scene `from` by the effect |
//! | `contrast` | metric, of, to, lower, higher, effect | of / to under each of `higher` exceeds that under each of `lower` by the effect |
//! | `swap` | metric, among, across, effect | two of `across` have a different least one of `among`, each less there than the other by the effect |
//! | `property` | metric, of, and one of equals, at_least, at_most | the metric keeps the bound, ends included |
//! | `untestable` | reason | never: what no measurement could decide |
//!
//! An effect is relative, `b / a - 1`; a negative one is a shortfall that still counts. What equals a limit keeps it.
//! `holds = "mean"` applies the rule once to the geometric means over all cases (arithmetic for correlations).

mod embedded;
mod evaluate;
mod file;
mod finding;
mod keys;
mod measurements;
mod model;
mod names;
mod rank_correlation;
mod rule;
mod values;
mod verdict;
mod write;

pub use embedded::{EMBEDDED, Embedded};
pub use measurements::Measurements;
pub use model::{
    Case, Claim, ClaimSet, Kind, Metric, MetricInfo, Paper, Quantifier, Reading, SceneRole, Setup, Test,
    Variant,
};
pub use rule::{Bound, Condition, Direction, End, Rule, Sign};
pub use verdict::{Figure, Outcome, ReadingVerdict, Verdict};
pub use write::{csv_text, json_text, markdown, text};
