//! Errors of samples against their run times.

use super::{Counter, Frame, Sampling};
use crate::chart::{LogLogChart, LogLogSeries};

/// A chart for each counter, with the name of its file.
pub fn charts(sampling: &Sampling, subtitle: &str) -> Vec<(String, LogLogChart)> {
    let counters = sampling.frames.first().and_then(|frame| frame.samples.first());
    let counters = counters.map_or(&[][..], |samples| &samples.counters);
    counters.iter().enumerate().map(|(place, counter)| chart(sampling, place, counter, subtitle)).collect()
}

fn chart(
    Sampling { frames, seeds, limits }: &Sampling,
    place: usize,
    Counter { id, .. }: &Counter,
    subtitle: &str,
) -> (String, LogLogChart) {
    let series = |frame: &Frame| LogLogSeries {
        name: frame.id(),
        points: frame
            .samples
            .iter()
            .map(|samples| (samples.run_s, 100.0 * samples.counters[place].error_at(0.95)))
            .collect(),
        exact_at: Some(frame.replay_s),
        joined: true,
    };
    let chart = LogLogChart {
        title: format!("{id} of samples against the replay"),
        subtitle: format!("{subtitle}, {seeds} samples of each part; dashed: the replay's time"),
        x_label: "processor time, seconds".to_owned(),
        y_label: "error, 95th percentile, %".to_owned(),
        series: frames.iter().map(series).collect(),
        limit: Some((100.0 * limits.error, format!("{} %", 100.0 * limits.error))),
    };
    (format!("work-precision-{id}"), chart)
}
