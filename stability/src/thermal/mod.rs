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

impl Thermal {
    /// Error of a temperature at which the times of methods are compared, in K.
    pub const COMPARED_AT: f64 = 1e-3;

    /// Least processor time in which a method met that error, in seconds; infinite where it never did.
    pub fn least_seconds(&self, method: Method) -> f64 {
        let of_method = self.points.iter().filter(|point| point.method == method);
        let good = of_method.filter(|point| point.error.is_some_and(|error| error <= Self::COMPARED_AT));
        good.map(|point| point.seconds).fold(f64::INFINITY, f64::min)
    }
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

    #[test]
    fn every_case_passes_however_busy_the_machine_is() {
        let found = thermal(Size::Quick, |_| ());
        for case in &found.cases {
            println!("{} {} {:?} {}", case.id, case.found, case.limit, case.why);
        }
        let failing: Vec<&Case> = found.cases.iter().filter(|case| !case.passes()).collect();
        assert!(failing.is_empty(), "{failing:?}");
        assert!(Method::ALL.iter().all(|&method| found.least_seconds(method) > 0.0));
    }
}
