//! The frames as CSV.

use super::{Accuracy, outcome};

/// The columns; errors are ratios, `run_s` are seconds of one processor of this machine.
pub const COLUMNS: [&str; 15] = [
    "id",
    "scene",
    "traversal",
    "gpu",
    "outcome",
    "ours_frame_time_ms",
    "reference_frame_time_ms",
    "error",
    "ours_dram_bytes",
    "reference_dram_bytes",
    "dram_error",
    "deciding_bound",
    "ours_run_s",
    "reference_run_s",
    "why",
];

/// One row for each frame, with a heading.
pub fn write(accuracy: &Accuracy) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let rows = accuracy.points.iter().map(|point| {
        let misses = point.misses(&accuracy.limits);
        [
            point.id(),
            point.scene.clone(),
            point.traversal.clone(),
            point.gpu.clone(),
            outcome(misses.is_empty()).to_owned(),
            point.ours.frame_time_ms.to_string(),
            point.reference.frame_time_ms.to_string(),
            point.time_error().to_string(),
            point.ours.dram_bytes().to_string(),
            point.reference.dram_bytes().to_string(),
            point.dram_error().to_string(),
            point.deciding_bound.clone(),
            point.ours.run_s.to_string(),
            point.reference.run_s.to_string(),
            misses.join("; "),
        ]
    });
    for row in std::iter::once(COLUMNS.map(str::to_owned)).chain(rows) {
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}
