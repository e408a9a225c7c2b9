//! Errors of the integrators as charts.

use crate::chart::{LogLogChart, LogLogSeries};
use stability::{Thermal, WorkPoint};
use thermal::{Method, Steps};

/// The charts, with the names of their files: error against run time at tolerances, and error against the length of fixed steps.
pub fn charts(thermal: &Thermal) -> [(&'static str, LogLogChart); 2] {
    let chart = |title: &str, x_label: &str, place: fn(&WorkPoint) -> Option<f64>| LogLogChart {
        title: title.to_owned(),
        subtitle: thermal.problem.clone(),
        x_label: x_label.to_owned(),
        y_label: "largest error of a temperature, K".to_owned(),
        series: Method::ALL.map(|method| series(thermal, method, place)).to_vec(),
        limit: None,
    };
    [
        (
            "work-precision",
            chart(
                "Error against run time, at tolerances of 1e-7 to 0.1 K",
                "processor time, seconds",
                |point| matches!(point.steps, Steps::Tolerance(_)).then_some(point.seconds),
            ),
        ),
        (
            "step-sizes",
            chart(
                "Error against the length of fixed steps",
                "length of a step, seconds",
                |point| match point.steps {
                    Steps::Fixed(length) => Some(length),
                    Steps::Tolerance(_) => None,
                },
            ),
        ),
    ]
}

fn series(thermal: &Thermal, method: Method, place: fn(&WorkPoint) -> Option<f64>) -> LogLogSeries {
    let of_method = thermal.points.iter().filter(|point| point.method == method);
    LogLogSeries {
        name: method.name().to_owned(),
        points: of_method.filter_map(|point| Some((place(point)?, point.error?))).collect(),
        exact_at: None,
        joined: true,
    }
}
