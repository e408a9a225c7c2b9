//! Can the solver of closed networks be trusted: does it always answer, does the answer move the right way, is it right?

mod accuracy;
mod closed_forms;
mod contract;
mod exact;
mod random;
mod simulation;
mod sweep;

use gpumodel::queueing::{Network, solve};
use random::{NAMES, Random};
use std::time::Instant;

/// A measured figure and the range it has to be in.
struct Row {
    what: String,
    measured: f64,
    range: (f64, f64),
}

#[test]
fn every_row_of_the_summary_is_within_its_limits() {
    let mut rows = sweep::rows();
    rows.extend(accuracy::rows());
    rows.push(Row {
        what: "microseconds, 10 stations, worst of kinds".to_owned(),
        measured: solve_time(),
        range: (0.0, 5.0),
    });
    println!("{:<58} {:>12}   limits", "", "measured");
    for Row { what, measured, range } in &rows {
        println!("{what:<58} {measured:>12.3e}   {:.1e} to {:.1e}", range.0, range.1);
    }
    for Row { what, measured, range } in &rows {
        assert!((range.0..=range.1).contains(measured), "{what}: {measured:e} is not in {range:?}");
    }
}

/// Microseconds that a solve takes in the fastest of some batches, so that a busy machine does not matter.
fn solve_time() -> f64 {
    let kinds = [(1, 0.0, 2.0), (1, 1e-6, 48.0), (4, 1e-7, 48.0), (16, 3e-6, 1e6)];
    let times = kinds.map(|(servers, think_time, customers)| {
        let mut random = Random(7);
        let stations = NAMES[..10]
            .iter()
            .map(|name| gpumodel::queueing::Station {
                servers,
                variability: 0.5,
                ..gpumodel::queueing::Station::single(name, random.log_uniform(1e-9, 1e-7))
            })
            .collect();
        let network = Network { customers, think_time, stations };
        let batches = (0..50).map(|_| {
            let start = Instant::now();
            for _ in 0..100 {
                std::hint::black_box(solve(std::hint::black_box(&network)).expect("the network is valid"));
            }
            start.elapsed().as_secs_f64() * 1e4
        });
        batches.fold(f64::INFINITY, f64::min)
    });
    times.into_iter().fold(0.0, f64::max)
}
