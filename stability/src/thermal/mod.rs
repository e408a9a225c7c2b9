//! The heat equation of a phone: do its integrators solve it, at what cost, and does a phone behave as theory says?

mod methods;
mod phone;
mod problem;

use crate::Size;
use crate::case::Case;
use thermal::{Method, Steps};

/// What one method did with one length of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkPoint {
    /// The method.
    pub method: Method,
    /// How long its steps were.
    pub steps: Steps,
    /// Largest error of a temperature, in K; none where the steps were too long for the method.
    pub error: Option<f64>,
    /// Processor time, in seconds.
    pub seconds: f64,
    /// Steps, repeated ones included.
    pub taken: u64,
}

/// The cases, and the points that show error against run time.
#[derive(Clone, Debug, PartialEq)]
pub struct Thermal {
    /// What must hold.
    pub cases: Vec<Case>,
    /// Of every method: tolerances, then fixed steps.
    pub points: Vec<WorkPoint>,
    /// What the points are of.
    pub problem: String,
}

/// Carries out all thermal cases; `starting` hears which group is next.
pub fn thermal(size: Size, starting: impl Fn(&'static str)) -> Thermal {
    starting("methods");
    let problem = problem::Problem::stiff();
    let points = problem.work(size);
    let mut cases = methods::cases(&problem, &points);
    starting("phone");
    cases.extend(phone::cases());
    Thermal { cases, points, problem: problem.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What depends on how busy the machine is.
    const TIMED: [&str; 2] = ["thermal/default", "thermal/ten-minutes"];

    #[test]
    fn every_case_that_no_clock_decides_passes() {
        let found = thermal(Size::Quick, |_| ());
        for case in &found.cases {
            println!("{} {} {:?} {}", case.id, case.found, case.limit, case.why);
        }
        let failing: Vec<&Case> =
            found.cases.iter().filter(|case| !case.passes() && !TIMED.contains(&case.id.as_str())).collect();
        assert!(failing.is_empty(), "{failing:?}");
        for id in TIMED {
            assert!(found.cases.iter().any(|case| case.id == id), "{id}");
        }
    }
}
