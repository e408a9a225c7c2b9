//! What does a load do to a phone?

use thermal::{
    BUILTIN, LeakageLaw, LongRun, Method, OperatingPoint, Outcome, Phone, Rule, Run, Settings, Trip, Zone,
    long_run,
};

fn phone() -> Phone {
    Phone::parse(BUILTIN, "phone.toml").expect("the built-in phone")
}

fn law(watts: f64) -> LeakageLaw {
    LeakageLaw { watts, celsius: 55.0, per_kelvin: 0.035 }
}

/// `watts` at the highest clock, by the square of a voltage that falls with the clock.
fn points(watts: f64) -> Vec<OperatingPoint> {
    let point = |(mhz, volts): (f64, f64)| OperatingPoint {
        mhz,
        frames_per_second: mhz / 10.0,
        gpu_watts: watts * (mhz / 710.0) * (volts / 0.92_f64).powi(2),
        dram_watts: 0.5,
        leakage: law(0.2 * (volts / 0.92_f64).powi(3)),
    };
    [(710.0, 0.92), (596.0, 0.82), (414.0, 0.71), (342.0, 0.65), (257.0, 0.62)].map(point).to_vec()
}

fn run(phone: &Phone, watts: f64, seconds: f64) -> Run {
    phone.simulate(&points(watts), &Settings::over(seconds)).expect("a run")
}

/// A phone whose only zone is at the skin and told by its sensor.
fn told(hysteresis: f64) -> Phone {
    let mut phone = phone();
    let sensor = phone.network.node("skin").expect("skin");
    let cap = |celsius, clock_share| thermal::Cap { trip: Trip { celsius, hysteresis }, clock_share };
    phone.zones = vec![Zone {
        name: "skin".to_owned(),
        sensor,
        polling: 0.0,
        polling_passive: 1.0,
        rule: Rule::Monitor(vec![cap(38.0, 0.5), cap(42.0, 0.4)]),
    }];
    phone
}

#[test]
fn a_light_load_stays_at_the_highest_clock() {
    let run = run(&phone(), 1.0, 600.0);
    assert_eq!((run.outcome, run.switches.len(), run.samples.len()), (Outcome::Completed, 0, 601));
    let last = run.samples.last().expect("samples");
    assert!((last.frames - 71.0 * 600.0).abs() < 1e-6);
}

#[test]
fn a_heavy_load_is_slowed_and_keeps_every_limit() {
    let phone = phone();
    let run = run(&phone, 5.0, 3600.0);
    assert_eq!(run.outcome, Outcome::Completed);
    assert!(!run.switches.is_empty());
    let hottest = run.samples.iter().map(|sample| sample.celsius[phone.gpu]).fold(0.0, f64::max);
    assert!(hottest < phone.shutdown.celsius, "{hottest}");
}

#[test]
fn the_heat_of_a_governed_hour_adds_up() {
    let run = run(&phone(), 5.0, 3600.0);
    let joules = run.samples.last().expect("samples").joules;
    let balance = joules - run.joules_to_air - run.joules_stored;
    assert!(balance.abs() <= 1e-9 * joules, "{balance:e} of {joules} J");
    // The same from the power at the samples, which the integration does not use. Between samples the clock may change.
    let mean = |pair: &[thermal::Sample]| 0.5 * (pair[0].watts + pair[1].watts) * (pair[1].at - pair[0].at);
    let by_samples: f64 = run.samples.windows(2).map(mean).sum();
    assert!((by_samples / joules - 1.0).abs() < 5e-3, "{by_samples} and {joules}");
}

/// Where no clock changes the heat is the integral of the power at samples, to the accuracy of Simpson's rule.
#[test]
fn the_heat_of_an_ungoverned_run_is_the_integral_of_its_power() {
    let mut phone = phone();
    phone.zones.clear();
    let settings = Settings { sample_seconds: 0.01, tolerance: 1e-6, ..Settings::over(60.0) };
    let run = phone.simulate(&points(3.0)[..1], &settings).expect("a run");
    let simpson: f64 = run
        .samples
        .windows(3)
        .step_by(2)
        .map(|three| {
            (three[2].at - three[0].at) / 6.0 * (three[0].watts + 4.0 * three[1].watts + three[2].watts)
        })
        .sum();
    let joules = run.samples.last().expect("samples").joules;
    assert!((simpson / joules - 1.0).abs() < 1e-6, "{simpson} and {joules}");
}

#[test]
fn a_constant_load_ends_where_its_balance_is() {
    let mut phone = phone();
    phone.zones.clear();
    let points = points(2.0);
    let LongRun::Settles(expected) = long_run(&phone.equation(&points[0])) else { panic!("2 W settle") };
    let run = phone.simulate(&points[..1], &Settings::over(30_000.0)).expect("a run");
    let last = run.samples.last().expect("samples");
    for (found, expected) in last.celsius.iter().zip(expected) {
        assert!((found - phone.ambient_celsius - expected).abs() < 1e-6, "{found}");
    }
}

#[test]
fn leakage_above_the_gain_of_the_network_runs_away_and_says_so() {
    let mut phone = phone();
    phone.zones.clear();
    let mut points = points(3.0);
    points[0].leakage = law(3.0);
    assert_eq!(long_run(&phone.equation(&points[0])), LongRun::RunsAway);
    for method in Method::ALL {
        let settings = Settings { method, ..Settings::over(600.0) };
        let run = phone.simulate(&points[..1], &settings).expect("a run");
        let Outcome::RanAway { at } = run.outcome else { panic!("{}: {:?}", method.name(), run.outcome) };
        assert!(at > 0.0 && at < 600.0, "{at}");
        let last = run.samples.last().expect("samples");
        assert!(last.celsius[phone.gpu] >= phone.shutdown.celsius && last.watts.is_finite());
    }
}

/// Both sides of the largest leakage that settles: `R per_kelvin watts(T) = 1/e` without it.
#[test]
fn the_largest_leakage_that_settles_is_that_of_theory() {
    let phone = phone();
    let mut point = points(1.0)[0];
    let without = thermal::HeatEquation { leakage: None, ..phone.equation(&point) };
    let LongRun::Settles(temperatures) = long_run(&without) else { panic!("nothing leaks") };
    let mut watt = vec![0.0; phone.network.size()];
    watt[phone.gpu] = 1.0;
    let resistance = phone.network.settled(&watt)[phone.gpu];
    let LeakageLaw { celsius, per_kelvin, .. } = point.leakage;
    let growth = (per_kelvin * (temperatures[phone.gpu] + phone.ambient_celsius - celsius)).exp();
    let largest = (-1.0_f64).exp() / (resistance * per_kelvin * growth);
    point.leakage = law(largest * (1.0 - 1e-12));
    let LongRun::Settles(balance) = long_run(&phone.equation(&point)) else { panic!("{largest} W settle") };
    // At the largest, the die is warmer by the temperature over which leakage grows by e.
    let rise = balance[phone.gpu] - temperatures[phone.gpu];
    assert!((rise * per_kelvin - 1.0).abs() < 1e-5, "{rise}");
    point.leakage = law(largest * (1.0 + 1e-12));
    assert_eq!(long_run(&phone.equation(&point)), LongRun::RunsAway);
}

#[test]
fn a_crossing_is_found_at_its_instant_by_every_method_and_tolerance() {
    let phone = told(1.0);
    let instant = |method, tolerance| {
        let settings = Settings { method, tolerance, ..Settings::over(900.0) };
        let run = phone.simulate(&points(2.5), &settings).expect("a run");
        run.switches[0].at
    };
    let reference = instant(Method::Implicit, 1e-9);
    for method in Method::ALL {
        for tolerance in [1e-2, 1e-4, 1e-6] {
            let found = instant(method, tolerance);
            // The skin warms by 0.03 K/s there.
            assert!(
                (found - reference).abs() < 40.0 * tolerance,
                "{} at {tolerance}: {found}, not {reference}",
                method.name()
            );
        }
    }
}

/// The clock may not change again before the sensor has moved by the hysteresis, at the largest rate that the sensor ever has.
#[test]
fn a_trip_with_hysteresis_does_not_chatter() {
    for hysteresis in [0.1, 1.0] {
        let phone = told(hysteresis);
        let skin = phone.network.node("skin").expect("skin");
        let settings = Settings { sample_seconds: 0.1, ..Settings::over(3600.0) };
        let run = phone.simulate(&points(2.5), &settings).expect("a run");
        let rate = run
            .samples
            .windows(2)
            .map(|pair| (pair[1].celsius[skin] - pair[0].celsius[skin]).abs() / (pair[1].at - pair[0].at))
            .fold(0.0, f64::max);
        let shortest =
            run.switches.windows(2).map(|pair| pair[1].at - pair[0].at).fold(f64::INFINITY, f64::min);
        assert!(run.switches.len() > 4, "{} switches", run.switches.len());
        assert!(shortest >= 0.99 * hysteresis / rate, "{shortest} s with {hysteresis} K at {rate} K/s");
    }
}

#[test]
fn a_run_is_the_same_each_time() {
    assert_eq!(run(&phone(), 5.0, 600.0), run(&phone(), 5.0, 600.0));
}

#[test]
fn a_gpu_that_does_not_leak_is_followed() {
    let leakage = LeakageLaw { watts: 0.0, ..law(1.0) };
    let cool = OperatingPoint { leakage, ..points(3.0)[0] };
    let LongRun::Settles(rises) = long_run(&phone().equation(&cool)) else { panic!("nothing runs away") };
    let run = phone().simulate(&[cool], &Settings::over(60.0)).expect("a run");
    let last = run.samples.last().expect("samples");
    assert!(last.celsius[phone().gpu] > phone().ambient_celsius);
    assert!(last.celsius[phone().gpu] < phone().ambient_celsius + rises[phone().gpu]);
}

#[test]
fn points_that_do_not_fall_are_refused() {
    let mut points = points(1.0);
    points.reverse();
    let refused = phone().simulate(&points, &Settings::over(1.0)).expect_err("refused").to_string();
    assert!(refused.contains("by falling clock"), "{refused}");
    points[0].gpu_watts = f64::NAN;
    assert!(phone().simulate(&points, &Settings::over(1.0)).is_err());
}

#[test]
fn a_charge_is_what_the_description_says_or_none() {
    let with = |charge: &str| {
        Phone::parse(&BUILTIN.replacen("[charge]\nwatt_hours = { value = 8.74,", charge, 1), "p.toml")
    };
    assert_eq!(phone().charge_watt_hours, Some(8.74));
    assert!(BUILTIN.contains("[charge]\nwatt_hours = { value = 8.74,"));
    for (watt_hours, fits) in [("0.001", true), ("0.0009", false), ("1e6", true), ("1.1e6", false)] {
        let read = with(&format!("[charge]\nwatt_hours = {{ value = {watt_hours},"));
        assert_eq!(read.is_ok(), fits, "{watt_hours}");
        if let Err(error) = read {
            assert!(error.to_string().contains("charge.watt_hours"), "{error}");
        }
    }
    let line = BUILTIN.lines().find(|line| line.starts_with("watt_hours")).expect("it has one");
    let without = BUILTIN.replacen(&format!("[charge]\n{line}\n"), "", 1);
    assert_eq!(Phone::parse(&without, "p.toml").expect("it is optional").charge_watt_hours, None);
}
