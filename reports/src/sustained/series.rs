//! The series over time as CSV and as a chart.

use crate::chart::{TimePanel, TimeSeries, TimeSeriesChart};
use thermal::{OperatingPoint, Phone, Rule, Run, Sample};

/// A row for each sample: time, clock, frame rate, power, frames and energy so far, and each node's temperature.
pub fn csv_text(phone: &Phone, points: &[OperatingPoint], run: &Run) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let fixed = ["seconds", "mhz", "fps", "power_w", "frames", "energy_j"].map(str::to_owned);
    let nodes = phone.network.nodes().iter().map(|node| format!("{}_celsius", node.name));
    let heading: Vec<String> = fixed.into_iter().chain(nodes).collect();
    let row = |Sample { at, point, watts, celsius, frames, joules }: &Sample| {
        let OperatingPoint { mhz, frames_per_second, .. } = &points[*point];
        let fixed = [at, mhz, frames_per_second, watts, frames, joules];
        fixed.into_iter().chain(celsius).map(f64::to_string).collect::<Vec<_>>()
    };
    for row in std::iter::once(heading).chain(run.samples.iter().map(row)) {
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}

/// Frame rate, clock and temperatures over time.
pub fn chart(phone: &Phone, points: &[OperatingPoint], run: &Run, subtitle: String) -> TimeSeriesChart {
    const MINUTE: f64 = 60.0;
    let ends = run.samples.last().map(|sample| (sample.at, sample.point));
    let starts = std::iter::once((0.0, 0)).chain(run.switches.iter().map(|switch| (switch.at, switch.to)));
    let held = |of: fn(&OperatingPoint) -> f64| {
        starts.clone().chain(ends).map(|(at, point)| (at / MINUTE, of(&points[point]))).collect()
    };
    let sampled = |of: &dyn Fn(&Sample) -> f64| {
        run.samples.iter().map(|sample| (sample.at / MINUTE, of(sample))).collect()
    };
    let line = |name: &str, points, holds| TimeSeries { name: name.to_owned(), points, holds };
    let panel = |y_label: &str, series, from_zero| TimePanel {
        y_label: y_label.to_owned(),
        series,
        limits: Vec::new(),
        from_zero,
    };
    let nodes = phone.network.nodes().iter().enumerate();
    let temperatures =
        nodes.map(|(node, of)| line(&of.name, sampled(&|sample| sample.celsius[node]), false)).collect();
    let hottest = run.samples.iter().flat_map(|sample| &sample.celsius).copied().fold(0.0, f64::max);
    TimeSeriesChart {
        title: "Frame rate, clock, power and temperatures of a frame drawn again and again".to_owned(),
        subtitle,
        x_label: "time, minutes".to_owned(),
        panels: vec![
            panel(
                "frame rate, frames per second",
                vec![line("frame rate", held(|point| point.frames_per_second), true)],
                true,
            ),
            panel("clock of the GPU, MHz", vec![line("clock", held(|point| point.mhz), true)], true),
            panel("power of the phone, W", vec![line("power", sampled(&|sample| sample.watts), false)], true),
            TimePanel {
                limits: limits(phone, hottest),
                ..panel("temperature, degrees Celsius", temperatures, false)
            },
        ],
    }
}

/// The trips that some temperature came near to.
fn limits(phone: &Phone, hottest: f64) -> Vec<(f64, String)> {
    /// Kelvins.
    const NEAR: f64 = 10.0;
    let trips = phone.zones.iter().flat_map(|zone| {
        let trips: Vec<f64> = match &zone.rule {
            Rule::StepWise(trip) => vec![trip.celsius],
            Rule::Monitor(caps) => caps.iter().map(|cap| cap.trip.celsius).collect(),
        };
        trips.into_iter().map(|celsius| (celsius, format!("trip of {}, {celsius}", zone.name)))
    });
    let shutdown = (phone.shutdown.celsius, format!("shutdown, {}", phone.shutdown.celsius));
    trips.chain([shutdown]).filter(|(celsius, _)| *celsius <= hottest + NEAR).collect()
}
