//! The section of a report that tells of a warm phone.

use super::{Battery, Heat, Minute, NodeHeat, Sustained, SustainedPoint};
use crate::text::Style;
use crate::units::digits;
use std::fmt::Write;

macro_rules! line {
    ($out:expr) => { $out.push('\n') };
    ($out:expr, $($args:tt)*) => { writeln!($out, $($args)*).expect("a string takes every write") };
}

pub(crate) fn write(out: &mut String, sustained: Option<&Sustained>, style: Style) {
    let Some(sustained) = sustained else { return };
    let Sustained { phone, ambient_celsius, peak_fps, sustained_fps, stability, .. } = sustained;
    line!(out);
    let title =
        format!("Over {}, on {phone} in air of {ambient_celsius} degrees Celsius", span(sustained.seconds));
    line!(out, "{}", style.bold(&title));
    line!(
        out,
        "  {} frames per second at first, {} in the last minute: {:.1} %",
        digits(*peak_fps),
        digits(*sustained_fps),
        100.0 * stability
    );
    match sustained.throttled_after_s {
        None => line!(out, "  The clock is never lowered."),
        Some(after) => {
            let changes = if sustained.switches == 1 { "change" } else { "changes" };
            line!(
                out,
                "  The clock is lowered first after {}; {} {changes}.",
                span(after),
                sustained.switches
            );
        }
    }
    match sustained.outcome.as_str() {
        "shut_down" => line!(out, "  The phone shuts down after {}.", span(sustained.ended_after_s)),
        "ran_away" => line!(
            out,
            "  Leakage runs away, and the phone shuts down after {}: its exponential law has no balance, however warm.",
            span(sustained.ended_after_s)
        ),
        _ => {}
    }
    line!(out);
    line!(
        out,
        "  {:>8}  {:>7}  {:>9}  {:>8}  {:>8}  {:>10}  {:>16}  {:>8}",
        "clock",
        "supply",
        "rate",
        "GPU",
        "memory",
        "leakage",
        "settles at",
        "time"
    );
    for point in &sustained.operating_points {
        let SustainedPoint { mhz, volts, fps, gpu_w, dram_w, leakage_w, settles_at_celsius, seconds, .. } =
            point;
        let settles = settles_at_celsius.map_or("no balance".to_owned(), |celsius| format!("{celsius:.1} C"));
        line!(
            out,
            "  {:>4} MHz  {volts:>5.3} V  {:>5} 1/s  {gpu_w:>6.3} W  {dram_w:>6.3} W  {leakage_w:>8.3} W  {settles:>16}  {:>6.1} s",
            digits(*mhz).trim_end_matches(".0"),
            digits(*fps),
            seconds
        );
    }
    if let Some(first) = sustained.operating_points.first() {
        line!(
            out,
            "  Leakage at {} degrees Celsius; settles at: the GPU, if nothing lowered the clock, by the exponential law of leakage.",
            first.leakage_celsius
        );
    }
    line!(out);
    line!(out, "  {:>10}  {:>10}  {:>12}  {:>26}", "until", "frames/s", "energy", "of which GPU and memory");
    for Minute { until_s, fps, energy_j, frame_energy_j } in &sustained.minutes {
        line!(
            out,
            "  {:>10}  {:>10}  {:>10} J  {:>24} J",
            span(*until_s),
            digits(*fps),
            digits(*energy_j),
            digits(*frame_energy_j)
        );
    }
    line!(out);
    let nodes = sustained.nodes.iter().map(|NodeHeat { name, peak_celsius, last_celsius }| {
        format!("{name} {peak_celsius:.1} ({last_celsius:.1})")
    });
    line!(
        out,
        "  Highest temperatures, and those at the end, in degrees Celsius: {}",
        nodes.collect::<Vec<_>>().join(", ")
    );
    let Heat { in_j, stored_j, to_air_j } = sustained.heat;
    line!(
        out,
        "  Heat: {} J in, {} J kept, {} J to the air",
        digits(in_j),
        digits(stored_j),
        digits(to_air_j)
    );
    if let Some(battery) = &sustained.battery {
        line!(out, "  Battery: {}", charge(battery));
    }
}

/// What the load takes from a battery, in words.
pub(crate) fn charge(Battery { watt_hours, used, lasts_hours }: &Battery) -> String {
    format!(
        "{:.1} % of {} Wh, which would last {} h at this power",
        100.0 * used,
        digits(*watt_hours),
        digits(*lasts_hours)
    )
}

/// A time in minutes and seconds.
pub(crate) fn span(seconds: f64) -> String {
    let minutes = (seconds / 60.0).floor();
    let rest = seconds - 60.0 * minutes;
    match (minutes > 0.0, rest >= 0.05) {
        (true, true) => format!("{minutes} min {rest:.1} s"),
        (true, false) => format!("{minutes} min"),
        (false, _) => format!("{rest:.1} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::span;

    #[test]
    fn times_are_told_in_minutes_and_seconds() {
        assert_eq!([600.0, 61.5, 59.0, 0.25].map(span), ["10 min", "1 min 1.5 s", "59.0 s", "0.2 s"]);
    }
}
