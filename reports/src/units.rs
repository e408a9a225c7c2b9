//! Figures as people read them: four digits, scaled units, separated thousands.

use crate::counters::Value;
use gpumodel::{COUNTERS, CounterInfo};

/// Name, group and definition of a counter.
pub(crate) fn counter_info(id: &str) -> Option<&'static CounterInfo> {
    COUNTERS.iter().find(|info| info.id == id)
}

/// A figure and its unit, scaled; `None` where there is none. The unit of what is counted is left out: a counter's name
/// says it.
pub(crate) fn scaled(value: &Value, unit: &str) -> Option<(String, String)> {
    const BINARY: [(f64, &str); 4] =
        [(1024.0 * 1024.0 * 1024.0, "GiB"), (1024.0 * 1024.0, "MiB"), (1024.0, "KiB"), (0.0, "B")];
    const RATES: [(f64, &str); 4] = [(1e9, "GB/s"), (1e6, "MB/s"), (1e3, "kB/s"), (0.0, "B/s")];
    const MEASURES: [&str; 5] = ["ms", "1/s", "Mrays/s", "mJ", "mW"];
    let number = value.as_f64()?;
    let steps = match unit {
        "B" => &BINARY,
        "B/s" => &RATES,
        "ratio" => return Some((digits(number * 100.0), "%".to_owned())),
        _ => {
            let shown = match *value {
                Value::Count(count) => grouped(count),
                _ => digits(number),
            };
            let unit = if MEASURES.contains(&unit) { unit } else { "" };
            return Some((shown, unit.to_owned()));
        }
    };
    let &(size, name) =
        steps.iter().find(|(size, _)| number.abs() >= *size).unwrap_or(&steps[steps.len() - 1]);
    let shown = match (value, size > 0.0) {
        (_, true) => digits(number / size),
        (Value::Count(count), false) => count.to_string(),
        (_, false) => digits(number),
    };
    Some((shown, name.to_owned()))
}

/// Four significant digits, more before the point where the number has them, without an exponent where it is readable.
pub(crate) fn digits(number: f64) -> String {
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
    fn an_absent_figure_has_no_number() {
        assert_eq!(scaled(&Value::Absent { reason: "no texture".into() }, "B"), None);
    }
}
