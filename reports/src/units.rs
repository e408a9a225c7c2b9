//! Figures as people read them: four digits, scaled units, separated thousands.

use crate::counters::Value;
use gpumodel::{COUNTERS, CounterInfo};

/// Name, group and definition of a counter.
pub(crate) fn counter_info(id: &str) -> Option<&'static CounterInfo> {
    COUNTERS.iter().find(|info| info.id == id)
}

/// What a unit is scaled by where figures reach `largest`, and its name then. The name is empty where a counter's name
/// says what is counted.
pub(crate) fn scale(unit: &str, largest: f64) -> (f64, &'static str) {
    const BINARY: [(f64, &str); 3] =
        [(1024.0 * 1024.0 * 1024.0, "GiB"), (1024.0 * 1024.0, "MiB"), (1024.0, "KiB")];
    const RATES: [(f64, &str); 3] = [(1e9, "GB/s"), (1e6, "MB/s"), (1e3, "kB/s")];
    const OPERATIONS: [(f64, &str); 3] = [(1e9, "Gops/s"), (1e6, "Mops/s"), (1e3, "kops/s")];
    const MEASURES: [&str; 7] = ["ms", "1/s", "Mrays/s", "mJ", "nJ", "mW", "%"];
    let largest_step = |steps: [(f64, &'static str); 3], least: &'static str| {
        steps.into_iter().find(|(size, _)| largest >= *size).unwrap_or((1.0, least))
    };
    match unit {
        "B" => largest_step(BINARY, "B"),
        "B/s" => largest_step(RATES, "B/s"),
        "ops/s" => largest_step(OPERATIONS, "ops/s"),
        "ratio" => (0.01, "%"),
        _ => (1.0, MEASURES.into_iter().find(|measure| *measure == unit).unwrap_or("")),
    }
}

/// A figure and its unit, scaled; `None` where there is none.
pub(crate) fn scaled(value: &Value, unit: &str) -> Option<(String, String)> {
    let number = value.as_f64()?;
    let (size, name) = scale(unit, number.abs());
    let shown = match *value {
        // Bytes below 1024 stand beside scaled ones, which have no separators.
        Value::Count(count) if name == "B" => count.to_string(),
        Value::Count(count) if size == 1.0 => grouped(count),
        _ => digits(number / size),
    };
    Some((shown, name.to_owned()))
}

/// Four significant digits, more before the point where the number has them, without an exponent where it is readable.
pub fn digits(number: f64) -> String {
    let magnitude = number.abs();
    if magnitude == 0.0 {
        return "0".to_owned();
    }
    if !(1e-6..1e15).contains(&magnitude) {
        return format!("{number:.3e}");
    }
    let decimals = (3 - magnitude.log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{number:.decimals$}");
    match text.split_once('.') {
        Some((whole, fraction)) => format!("{}.{fraction}", separated(whole)),
        None => separated(&text),
    }
}

/// A figure in as few characters as four digits allow: millions and more with a suffix, what is tiny or huge with an
/// exponent.
pub(crate) fn short(number: f64) -> String {
    let magnitude = number.abs();
    if magnitude != 0.0 && !(1e-3..1e15).contains(&magnitude) {
        return exponent(number, 2);
    }
    let (size, suffix) = suffix(magnitude);
    let text = digits(number / size);
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text}{suffix}")
}

/// Labels of evenly spaced ticks, with as many decimals each.
pub(crate) fn tick_labels(ticks: &[f64]) -> Vec<String> {
    let largest = ticks.iter().fold(0.0, |largest: f64, tick| largest.max(tick.abs()));
    if largest != 0.0 && !(1e-3..1e15).contains(&largest) {
        return ticks.iter().map(|&tick| exponent(tick, 8)).collect();
    }
    let (size, suffix) = suffix(largest);
    let step = ticks.windows(2).map(|pair| pair[1] - pair[0]).next().unwrap_or(largest) / size;
    // The step has one digit; a hair less room for its rounding.
    let decimals = if step > 0.0 { (-(step * 1.001).log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    let label = |&tick: &f64| match format!("{:.decimals$}", tick / size) {
        text if tick == 0.0 => text,
        text => match text.split_once('.') {
            Some((whole, fraction)) => format!("{}.{fraction}{suffix}", separated(whole)),
            None => format!("{}{suffix}", separated(&text)),
        },
    };
    ticks.iter().map(label).collect()
}

/// In what thousands a magnitude is written.
fn suffix(magnitude: f64) -> (f64, &'static str) {
    const SIZES: [(f64, &str); 3] = [(1e12, "T"), (1e9, "G"), (1e6, "M")];
    // What would be rounded up to a million is one.
    let size = SIZES.into_iter().find(|(size, _)| magnitude >= size * (1.0 - 5e-7));
    size.unwrap_or((1.0, ""))
}

/// Rounded to that many decimals of the mantissa.
pub(crate) fn rounded(number: f64, decimals: usize) -> f64 {
    format!("{number:.decimals$e}").parse().expect("a number is read as it was written")
}

/// With an exponent, rounded to some decimals of the mantissa, without trailing zeros.
fn exponent(number: f64, decimals: usize) -> String {
    if number == 0.0 { "0".to_owned() } else { format!("{:e}", rounded(number, decimals)) }
}

/// A whole number with separated thousands.
pub(crate) fn grouped(count: u64) -> String {
    separated(&count.to_string())
}

fn separated(digits: &str) -> String {
    let (sign, digits) = digits.strip_prefix('-').map_or(("", digits), |digits| ("-", digits));
    let mut text = String::from(sign);
    for (index, digit) in digits.char_indices() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(value: &Value, unit: &str) -> String {
        let (number, unit) = scaled(value, unit).expect("a figure");
        format!("{number} {unit}")
    }

    #[test]
    fn bytes_change_their_unit_at_powers_of_1024_and_not_one_byte_before() {
        assert_eq!(shown(&Value::Count(0), "B"), "0 B");
        assert_eq!(shown(&Value::Count(1023), "B"), "1023 B");
        assert_eq!(shown(&Value::Count(1024), "B"), "1.000 KiB");
        assert_eq!(shown(&Value::Count((1 << 20) - 1), "B"), "1,024 KiB");
        assert_eq!(shown(&Value::Count(1 << 20), "B"), "1.000 MiB");
    }

    #[test]
    fn rates_are_decimal() {
        assert_eq!(shown(&Value::Real(29.8e9), "B/s"), "29.80 GB/s");
        assert_eq!(shown(&Value::Real(999.0), "B/s"), "999.0 B/s");
        assert_eq!(shown(&Value::Real(96.04e9), "ops/s"), "96.04 Gops/s");
        assert_eq!(shown(&Value::Real(12.5), "%"), "12.50 %");
    }

    #[test]
    fn counts_keep_every_digit_and_reals_show_four() {
        assert_eq!(shown(&Value::Count(1_234_567), "fetches"), "1,234,567 ");
        assert_eq!(shown(&Value::Real(12.3456), "ms"), "12.35 ms");
        assert_eq!(shown(&Value::Real(-0.012_345_6), "ms"), "-0.01235 ms");
        assert_eq!(shown(&Value::Real(1e-9), "ms"), "1.000e-9 ms");
    }

    #[test]
    fn ratios_are_shown_in_percent() {
        assert_eq!(shown(&Value::Real(0.123_45), "ratio"), "12.35 %");
    }

    #[test]
    fn short_figures_change_their_form_at_a_million_and_a_thousandth() {
        let cases = [
            (0.0, "0"),
            (12.0, "12"),
            (12.345_67, "12.35"),
            (-0.5, "-0.5"),
            (123_456.7, "123,457"),
            (999_999.0, "999,999"),
            (999_999.9, "1M"),
            (1e6, "1M"),
            (1_234_567.0, "1.235M"),
            (3.3e12, "3.3T"),
            (1e15, "1e15"),
            (0.001, "0.001"),
            (0.000_999, "9.99e-4"),
            (1.25e-9, "1.25e-9"),
        ];
        for (number, text) in cases {
            assert_eq!(short(number), text);
        }
    }

    #[test]
    fn ticks_have_as_many_decimals_each_as_their_step_needs() {
        assert_eq!(tick_labels(&[0.0, 0.05, 0.1]), ["0.00", "0.05", "0.10"]);
        assert_eq!(tick_labels(&[0.0, 1000.0, 2000.0]), ["0", "1,000", "2,000"]);
        assert_eq!(tick_labels(&[0.0, 500_000.0, 1e6]), ["0.0", "0.5M", "1.0M"]);
        assert_eq!(tick_labels(&[0.0, 1e-9, 2e-9]), ["0", "1e-9", "2e-9"]);
        assert_eq!(tick_labels(&[12.0, 12.02]), ["12.00", "12.02"]);
        assert_eq!(tick_labels(&[]), [""; 0]);
    }

    #[test]
    fn an_absent_figure_has_no_number() {
        assert_eq!(scaled(&Value::Absent { reason: "no texture".into() }, "B"), None);
    }
}
