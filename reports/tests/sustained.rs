//! Does the section on a warm phone say what became of the load?

use reports::sustained::{self, Sustained};
use thermal::{BUILTIN, LeakageLaw, OperatingPoint, Phone, Run, Settings};

fn points(gpu_watts: f64, leakage: f64) -> Vec<OperatingPoint> {
    let point = |mhz: f64| OperatingPoint {
        mhz,
        frames_per_second: mhz / 10.0,
        gpu_watts: gpu_watts * (mhz / 700.0).powi(3),
        dram_watts: 0.4,
        leakage: LeakageLaw { watts: leakage, celsius: 50.0, per_kelvin: 0.03 },
    };
    [700.0, 500.0, 300.0].map(point).to_vec()
}

fn followed(phone: &Phone, points: &[OperatingPoint], seconds: f64) -> (Run, Sustained) {
    let run = phone.simulate(points, &Settings::over(seconds)).expect("a run");
    let volts = [0.9, 0.8, 0.7];
    let section = Sustained::new(phone, points, &volts[..points.len()], &run, seconds);
    (run, section)
}

fn phone() -> Phone {
    Phone::parse(BUILTIN, "phone.toml").expect("the built-in phone")
}

#[test]
fn minutes_points_and_the_whole_add_up() {
    let phone = phone();
    let (run, section) = followed(&phone, &points(4.0, 0.3), 630.0);
    assert_eq!((section.outcome.as_str(), section.ended_after_s), ("completed", 630.0));
    assert_eq!(section.peak_fps, 70.0);
    assert!(section.throttled_after_s.is_some() && section.switches > 0);
    assert!(section.sustained_fps < section.peak_fps);
    assert_eq!(section.minutes.len(), 11);
    let last = run.samples.last().expect("samples");
    let frames: f64 = (0_u32..)
        .zip(&section.minutes)
        .map(|(minute, of)| of.fps * (of.until_s - 60.0 * f64::from(minute)))
        .sum();
    assert!((frames / last.frames - 1.0).abs() < 1e-9, "{frames} and {}", last.frames);
    let seconds: f64 = section.operating_points.iter().map(|point| point.seconds).sum();
    assert!((seconds - 630.0).abs() < 1e-9, "{seconds}");
    let by_points: f64 = section.operating_points.iter().map(|point| point.seconds * point.fps).sum();
    assert!((by_points / last.frames - 1.0).abs() < 1e-9, "{by_points} and {}", last.frames);
    // Other parts of the phone take the same each minute.
    let other: f64 = phone.other_watts.iter().sum();
    for minute in &section.minutes[..10] {
        assert!((minute.energy_j - minute.frame_energy_j - 60.0 * other).abs() < 1e-9, "{minute:?}");
    }
}

#[test]
fn a_load_that_ends_early_says_when_and_why() {
    let phone = Phone { zones: Vec::new(), ..phone() };
    let (_, hot) = followed(&phone, &points(12.0, 0.0001)[..1], 600.0);
    assert_eq!(hot.outcome, "shut_down");
    assert!(hot.ended_after_s < 600.0 && hot.seconds == 600.0 && hot.throttled_after_s.is_none());
    assert!(
        hot.operating_points[0].settles_at_celsius.is_some_and(|celsius| celsius > phone.shutdown.celsius)
    );
    let (_, leaking) = followed(&phone, &points(2.0, 3.0)[..1], 600.0);
    assert_eq!(
        (leaking.outcome.as_str(), leaking.operating_points[0].settles_at_celsius),
        ("ran_away", None)
    );
}

#[test]
fn the_series_have_a_row_for_each_sample_and_a_chart_with_units() {
    let phone = phone();
    let points = points(4.0, 0.3);
    let (run, _) = followed(&phone, &points, 120.0);
    let csv = sustained::csv_text(&phone, &points, &run);
    assert_eq!(csv.lines().count(), 122);
    assert!(
        csv.lines().nth(1).is_some_and(|row| row.starts_with("0,700,70,") && row.ends_with(",25")),
        "{csv}"
    );
    let chart = sustained::chart(&phone, &points, &run, "a scene".to_owned()).svg().expect("a chart");
    for label in ["power of the phone, W", "temperature, degrees Celsius", "time, minutes", "skin"] {
        assert!(chart.contains(label), "{label}");
    }
}
