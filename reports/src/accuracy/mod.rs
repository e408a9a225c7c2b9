//! One rung of fidelity held against a more faithful one, over many frames: errors, limits, tables and charts.
//!
//! An error is `ours / reference - 1`. Means are of its magnitude, each frame with the same weight.

mod charts;
mod csv_table;
mod json;
mod text;

use crate::units;

pub use charts::charts;
pub use csv_table::{COLUMNS, write as csv_text};
pub use json::write as json_text;
pub use text::write as text;

/// How large errors may be, as ratios; a limit itself is still within it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Mean error of frame time.
    pub mean: f64,
    /// Error of any frame's time.
    pub worst: f64,
    /// Error of any frame's bytes to and from DRAM.
    pub dram: f64,
}

/// 10 % is the mean error of GCoM against its cycle-level reference (Lee et al. 2022).
pub const LIMITS: Limits = Limits { mean: 0.10, worst: 0.25, dram: 0.03 };

/// What one rung said of a frame, and how long that took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Milliseconds of the modelled frame.
    pub frame_time_ms: f64,
    /// Bytes read from DRAM.
    pub dram_read_bytes: f64,
    /// Bytes written to DRAM.
    pub dram_write_bytes: f64,
    /// Seconds of one processor of this machine.
    pub run_s: f64,
}

impl Figures {
    /// Bytes to and from DRAM.
    pub fn dram_bytes(&self) -> f64 {
        self.dram_read_bytes + self.dram_write_bytes
    }
}

/// A frame on a GPU, by both rungs.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The scene's name.
    pub scene: String,
    /// The structure and how rays walk it.
    pub traversal: String,
    /// The GPU's name.
    pub gpu: String,
    /// What the rung under test says.
    pub ours: Figures,
    /// What the reference says.
    pub reference: Figures,
    /// The resource that decides the time of the rung under test.
    pub deciding_bound: String,
}

/// `ours / reference - 1`; 0 where both are equal, so also where both are 0.
fn error(ours: f64, reference: f64) -> f64 {
    if ours == reference { 0.0 } else { ours / reference - 1.0 }
}

impl Point {
    /// Its name: scene, traversal and GPU.
    pub fn id(&self) -> String {
        let Self { scene, traversal, gpu, .. } = self;
        format!("{scene}/{traversal}/{gpu}")
    }

    /// Error of the frame's time.
    pub fn time_error(&self) -> f64 {
        error(self.ours.frame_time_ms, self.reference.frame_time_ms)
    }

    /// Error of the bytes to and from DRAM.
    pub fn dram_error(&self) -> f64 {
        error(self.ours.dram_bytes(), self.reference.dram_bytes())
    }

    /// Which limits it breaks, in words; empty for a frame within them.
    pub fn misses(&self, limits: &Limits) -> Vec<String> {
        let checks =
            [("frame time", self.time_error(), limits.worst), ("DRAM bytes", self.dram_error(), limits.dram)];
        // An error that is no number is not within a limit.
        let broken = checks.into_iter().filter(|&(_, error, limit)| !within(error, limit));
        broken
            .map(|(what, error, limit)| format!("{what} {}, limit {}", signed(error), percent(limit)))
            .collect()
    }
}

fn within(error: f64, limit: f64) -> bool {
    error.abs() <= limit
}

/// A comparison of two rungs.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// Name of the rung under test.
    pub ours: String,
    /// Name of the reference.
    pub reference: String,
    /// The frames.
    pub points: Vec<Point>,
    /// What is allowed.
    pub limits: Limits,
}

/// Errors of the frame times of several frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// What the frames share.
    pub name: String,
    /// How many there are.
    pub frames: usize,
    /// Mean magnitude.
    pub mean: f64,
    /// Largest magnitude.
    pub worst: f64,
}

/// Something that is stated of all frames together.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Its name.
    pub id: &'static str,
    /// What is stated.
    pub text: String,
    /// The figure that was found, a ratio.
    pub found: f64,
    /// What it may be.
    pub limit: f64,
    /// The frame that it was found at, where it is that of one frame.
    pub at: Option<String>,
}

impl Statement {
    /// Whether it is true.
    pub fn holds(&self) -> bool {
        within(self.found, self.limit)
    }
}

impl Accuracy {
    /// Mean and worst of the frames that `of` names alike, in the order of their first frames.
    pub fn errors_by(&self, of: impl Fn(&Point) -> &str) -> Vec<Errors> {
        let mut names: Vec<&str> = Vec::new();
        for point in &self.points {
            if !names.contains(&of(point)) {
                names.push(of(point));
            }
        }
        let errors = |name: &str| {
            let errors = self.points.iter().filter(|point| of(point) == name).map(Point::time_error);
            summary(name, &errors.collect::<Vec<_>>())
        };
        names.into_iter().map(errors).collect()
    }

    /// Mean and worst of all frames.
    pub fn errors(&self) -> Errors {
        summary("all", &self.points.iter().map(Point::time_error).collect::<Vec<_>>())
    }

    /// What is stated of all frames.
    pub fn statements(&self) -> [Statement; 3] {
        let Self { ours, reference, limits, .. } = self;
        let largest = |error: fn(&Point) -> f64| {
            let point = self.points.iter().max_by(|a, b| error(a).abs().total_cmp(&error(b).abs()));
            (point.map_or(0.0, error), point.map(Point::id))
        };
        let (time, slowest) = largest(Point::time_error);
        let (dram, heaviest) = largest(Point::dram_error);
        [
            Statement {
                id: "mean",
                text: format!(
                    "The mean error of the frame time of '{ours}' against '{reference}' is at most {}.",
                    percent(limits.mean)
                ),
                found: self.errors().mean,
                limit: limits.mean,
                at: None,
            },
            Statement {
                id: "worst",
                text: format!("The error of no frame's time is above {}.", percent(limits.worst)),
                found: time,
                limit: limits.worst,
                at: slowest,
            },
            Statement {
                id: "dram",
                text: format!(
                    "The bytes to and from DRAM of every frame are within {}.",
                    percent(limits.dram)
                ),
                found: dram,
                limit: limits.dram,
                at: heaviest,
            },
        ]
    }

    /// Seconds that each rung took for all frames: ours, and the reference.
    pub fn run_s(&self) -> [f64; 2] {
        let sum = |of: fn(&Point) -> &Figures| self.points.iter().map(|point| of(point).run_s).sum();
        [sum(|point| &point.ours), sum(|point| &point.reference)]
    }
}

fn summary(name: &str, errors: &[f64]) -> Errors {
    let magnitudes = || errors.iter().map(|error| error.abs());
    Errors {
        name: name.to_owned(),
        frames: errors.len(),
        mean: magnitudes().sum::<f64>() / errors.len().max(1) as f64,
        worst: magnitudes().fold(0.0, f64::max),
    }
}

fn percent(ratio: f64) -> String {
    format!("{} %", units::short(100.0 * ratio))
}

fn signed(ratio: f64) -> String {
    format!("{:+.1} %", 100.0 * ratio)
}

/// What is stated of each frame.
fn of_point(Accuracy { reference, limits, .. }: &Accuracy) -> String {
    format!(
        "The frame's time is within {} and its DRAM bytes within {} of those on '{reference}'.",
        percent(limits.worst),
        percent(limits.dram)
    )
}

fn outcome(holds: bool) -> &'static str {
    if holds { "pass" } else { "fail" }
}
