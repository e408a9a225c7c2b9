//! Numerical stability of the tracer and of the models behind it, as a suite of cases: each with what was expected, what came out and
//! how far apart they are.
//!
//! Hits are held against exact arithmetic on scenes that are hard in one way each; solvers and models are driven to the ends of their
//! ranges, where answers must stay finite, monotone and exact under rescaling. The cases are the same for the command line and for
//! tests; a quick run has fewer rays, not fewer cases.

mod case;
mod exact;
mod geometry;
mod judge;
mod model;
mod random;
mod reference;
mod shapes;
mod structures;
mod thermal;

pub use case::{Case, Condition, Limit};
pub use thermal::{Thermal, WorkPoint, thermal};

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;
use structures::Watch;

/// How much of everything there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Few rays and small caches.
    Quick,
    /// Enough rays to tell rates of one in a million.
    Full,
}

impl Size {
    fn of<T>(self, quick: T, full: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Full => full,
        }
    }
}

/// Cases that are carried out together.
type Group = (&'static str, fn(Size, &Watch) -> Vec<Case>);

/// Names of the groups of cases, in the order in which they are carried out.
pub fn groups() -> impl Iterator<Item = &'static str> {
    geometry::GROUPS.into_iter().chain(model::GROUPS).map(|(name, _)| name)
}

/// Carries out every case; `starting` hears which group is next.
///
/// A panic in a group becomes a case that fails.
pub fn all(size: Size, starting: impl Fn(&'static str)) -> Vec<Case> {
    let watch = Watch::default();
    let mut cases = Vec::new();
    let mut panics = 0;
    for (name, group) in geometry::GROUPS.into_iter().chain(model::GROUPS) {
        starting(name);
        match catch_unwind(AssertUnwindSafe(|| group(size, &watch))) {
            Ok(found) => cases.extend(found),
            Err(panic) => {
                panics += 1;
                let text = panic.downcast_ref::<String>().map(String::as_str);
                let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
                cases.push(
                    Case::none_of(format!("{name}/panic"), "the group does not panic", "panics", 1)
                        .because(text),
                );
            }
        }
    }
    cases.extend(totals(&watch, panics));
    cases
}

/// What must not have happened to any ray of any case.
fn totals(watch: &Watch, panics: u64) -> [Case; 3] {
    let of = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
    let rays = format!("{} rays", of(&watch.rays));
    let none_of =
        |id: &str, statement: &str, counter| Case::none_of(id, statement, "rays", of(counter)).because(&rays);
    [
        Case::none_of("all/panics", "no group of cases panics", "panics", panics),
        none_of("all/nan", "no hit has a NaN, or a distance outside its ray's interval", &watch.not_numbers),
        none_of(
            "all/trips",
            "every traversal ends within the nodes that its order of visits allows: no loop has a bound that could end it early",
            &watch.over_bound,
        ),
    ]
}
