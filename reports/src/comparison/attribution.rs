//! What the difference of two frames is made of: bytes of DRAM by kind of buffer, time by what warps use or wait for, and by pass.

use super::figures::{difference, ratio};
use super::{Comparison, Variant};
use crate::report::{Pass, Report, Traffic};
use gpumodel::Pass as PassKind;
use serde::Serialize;

/// Parts of a difference that a sentence names.
const MOST_PARTS: usize = 4;
/// Percent of the first frame's total below which a sentence does not name a part.
const LEAST_POINTS: f64 = 0.05;

/// A difference and its parts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attribution {
    /// What differs.
    pub what: &'static str,
    /// Unit of the figures.
    pub unit: &'static str,
    /// Of the first frame.
    pub before: f64,
    /// Of the other one.
    pub after: f64,
    /// What adds up to both, the largest change first.
    pub parts: Vec<AttributedPart>,
}

/// A part of a figure in both frames; 0 where a frame does not have it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AttributedPart {
    /// Which.
    pub name: String,
    /// Of the first frame.
    pub before: f64,
    /// Of the other one.
    pub after: f64,
}

impl Attribution {
    fn new(what: &'static str, unit: &'static str, before: &[(&str, f64)], after: &[(&str, f64)]) -> Self {
        let mut parts: Vec<AttributedPart> = Vec::new();
        let mut add =
            |name: &str, before: f64, after: f64| match parts.iter_mut().find(|part| part.name == name) {
                Some(part) => {
                    part.before += before;
                    part.after += after;
                }
                None => parts.push(AttributedPart { name: name.to_owned(), before, after }),
            };
        before.iter().for_each(|&(name, figure)| add(name, figure, 0.0));
        after.iter().for_each(|&(name, figure)| add(name, 0.0, figure));
        parts.sort_by(|a, b| b.change().abs().total_cmp(&a.change().abs()));
        let sum = |parts: &[(&str, f64)]| parts.iter().map(|(_, figure)| figure).sum();
        Self { what, unit, before: sum(before), after: sum(after), parts }
    }

    /// The change of a part in percent of the first frame's total; none where that is 0.
    pub fn points(&self, part: &AttributedPart) -> Option<f64> {
        (self.before > 0.0).then(|| 100.0 * part.change() / self.before)
    }

    /// `DRAM bytes -18 %: primitives -31 % (-16.0), nodes -2.0 % (-1.6)`; none where the first frame has nothing, or nothing differs.
    pub fn sentence(&self) -> Option<String> {
        let whole = ratio(Some(self.after), Some(self.before))?;
        let told = |part: &AttributedPart| {
            let points = self.points(part).filter(|points| points.abs() >= LEAST_POINTS)?;
            let change = match ratio(Some(part.after), Some(part.before)) {
                Some(0.0) => "gone".to_owned(),
                Some(ratio) => difference(ratio, None),
                None => "new".to_owned(),
            };
            Some(format!("{} {change} ({points:+.1})", part.name))
        };
        let mut parts: Vec<String> = self.parts.iter().filter_map(told).collect();
        if parts.is_empty() {
            return None;
        }
        let more = parts.len().saturating_sub(MOST_PARTS);
        parts.truncate(MOST_PARTS);
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        Some(format!("{} {}: {}{more}", self.what, difference(whole, None), parts.join(", ")))
    }
}

impl AttributedPart {
    fn change(&self) -> f64 {
        self.after - self.before
    }
}

/// Bytes read from and written to DRAM by kind of buffer, in all passes.
fn bytes(report: &Report) -> Vec<(&str, f64)> {
    let moved = |traffic: &Traffic| (traffic.dram_read_bytes + traffic.dram_write_bytes) as f64;
    report.traffic.iter().map(|traffic| (traffic.buffer.as_str(), moved(traffic))).collect()
}

/// Milliseconds by what warps use or wait for.
fn times(report: &Report) -> Vec<(&str, f64)> {
    report.stack.iter().map(|part| (part.name.as_str(), 1e3 * part.seconds)).collect()
}

/// Milliseconds by pass.
fn passes(report: &Report) -> Vec<(&str, f64)> {
    report.passes.iter().filter_map(|pass| Some((pass.name.as_str(), pass_ms(pass)?))).collect()
}

fn pass_ms(pass: &Pass) -> Option<f64> {
    pass.counters.get("frame_time_ms")?.value.as_f64()
}

/// Milliseconds of the passes that trace rays or shade what they hit, and of all others, which prepare them.
fn traced_and_prepared(report: &Report) -> (f64, f64) {
    let traces = |pass: &&Pass| {
        let rays = pass.counters.get("rays").and_then(|rays| rays.value.as_f64());
        rays.is_some_and(|rays| rays > 0.0) || pass.name == PassKind::HitShading.name()
    };
    let (traced, prepared): (Vec<&Pass>, Vec<&Pass>) = report.passes.iter().partition(traces);
    let sum = |passes: &[&Pass]| passes.iter().filter_map(|pass| pass_ms(pass)).sum();
    (sum(&traced), sum(&prepared))
}

impl Comparison {
    /// Gross and net: what a variant gains over the first one in passes that trace rays or shade what they hit, and what it costs in those that
    /// prepare them, such as sorting rays into bins. A sentence; none where a frame has no time.
    pub fn gross_and_net(&self, variant: &Variant) -> Option<String> {
        let first = self.variants.first()?;
        let [before, after] = [first, variant].map(|variant| traced_and_prepared(&variant.report));
        let (whole, gross, own) = (before.0 + before.1, after.0 - before.0, after.1 - before.1);
        let told = |change: f64| format!("{change:+.4} ms ({:+.1} %)", 100.0 * change / whole);
        (whole > 0.0).then(|| {
            format!(
                "{}: rays and shading {}, what prepares them {}, net {}.",
                self.name(variant),
                told(gross),
                told(own),
                told(gross + own)
            )
        })
    }

    /// Of what the differences of a variant from the first one are made.
    pub fn attributions(&self, variant: &Variant) -> Vec<Attribution> {
        let Some(first) = self.variants.first() else { return Vec::new() };
        let (first, other) = (&first.report, &variant.report);
        vec![
            Attribution::new("DRAM bytes", "B", &bytes(first), &bytes(other)),
            Attribution::new("frame time", "ms", &times(first), &times(other)),
            Attribution::new("frame time by pass", "ms", &passes(first), &passes(other)),
        ]
    }

    /// The same in sentences, three for each variant.
    pub(crate) fn attributed(&self) -> Vec<String> {
        let of_variant = |variant: &Variant| -> Vec<String> {
            let sentences = self.attributions(variant).into_iter().filter_map(|made| made.sentence());
            sentences.map(|sentence| format!("{}: {sentence}.", self.name(variant))).collect()
        };
        self.variants.iter().skip(1).flat_map(of_variant).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_difference_add_up_to_it_and_the_largest_stands_first() {
        let before = [("nodes", 80.0), ("primitives", 100.0), ("stack", 20.0), ("frame", 0.0)];
        let after = [("primitives", 69.0), ("nodes", 78.0), ("stack", 10.0), ("image", 5.0)];
        let made = Attribution::new("DRAM bytes", "B", &before, &after);
        assert_eq!((made.before, made.after), (200.0, 162.0));
        let points: f64 = made.parts.iter().filter_map(|part| made.points(part)).sum();
        assert!((points + 19.0).abs() < 1e-12, "{points}");
        assert_eq!(
            made.sentence().as_deref(),
            Some(
                "DRAM bytes -19 %: primitives -31 % (-15.5), stack -50 % (-5.0), image new (+2.5), nodes -2.5 % (-1.0)"
            )
        );
    }

    #[test]
    fn what_does_not_differ_has_no_sentence() {
        let same = [("nodes", 80.0)];
        assert_eq!(Attribution::new("DRAM bytes", "B", &same, &same).sentence(), None);
        assert_eq!(Attribution::new("DRAM bytes", "B", &[], &same).sentence(), None);
    }
}
