//! A phone under load: where it ends up, when it trips, and that it neither chatters nor hangs.

use super::problem::{builtin, load};
use crate::case::{Case, Limit};
use std::time::Instant;
use thermal::{
    Cap, HeatEquation, LeakageLaw, LongRun, Method, OperatingPoint, Outcome, Phone, Rule, Settings, Trip,
    Zone, long_run,
};

const TEN_MINUTES: f64 = 600.0;
/// A load in W that trips the zone of the GPU.
const HEAVY: f64 = 4.0;

pub(super) fn cases() -> Vec<Case> {
    vec![
        steady_linear(),
        steady_leaking(),
        runaway_limit(),
        runaway_ends(),
        instants(),
        chatter(),
        governed_balance(),
        repeatable(),
        ten_minutes(),
    ]
}

fn ungoverned() -> Phone {
    Phone { zones: Vec::new(), ..builtin() }
}

/// A load at five clocks; power falls with the clock and the square of a voltage.
fn ladder(gpu_watts: f64) -> Vec<OperatingPoint> {
    let point = |(mhz, volts): (f64, f64)| OperatingPoint {
        mhz,
        frames_per_second: mhz / 10.0,
        gpu_watts: gpu_watts * (mhz / 700.0) * volts * volts,
        leakage: LeakageLaw { watts: load(0.0).leakage.watts * volts.powi(3), ..load(0.0).leakage },
        ..load(0.0)
    };
    [(700.0, 1.0), (600.0, 0.92), (500.0, 0.85), (400.0, 0.78), (300.0, 0.72)].map(point).to_vec()
}

/// A load whose leakage is so many watts at its reference temperature.
fn leaking(gpu_watts: f64, watts: f64) -> OperatingPoint {
    let load = load(gpu_watts);
    OperatingPoint { leakage: LeakageLaw { watts, ..load.leakage }, ..load }
}

/// After a hundred of the longest time constants.
fn after_long(phone: &Phone, point: OperatingPoint) -> Vec<f64> {
    let seconds = 100.0 * phone.network.time_constants()[0];
    let settings = Settings { sample_seconds: seconds, ..Settings::over(seconds) };
    let run = phone.simulate(&[point], &settings).expect("a load");
    let last = run.samples.last().expect("a sample");
    last.celsius.iter().map(|celsius| celsius - phone.ambient_celsius).collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn steady_linear() -> Case {
    let phone = ungoverned();
    let point = leaking(2.0, 0.0);
    let expected = phone.network.settled(&phone.equation(&point).power);
    Case::new(
        "thermal/steady/linear",
        "without leakage a phone ends at the solution of the linear system",
        "K",
        Limit::AtMost(1e-6),
        apart(&after_long(&phone, point), &expected),
    )
    .because(format!("the GPU at {:.2} K above the air", expected[phone.gpu]))
}

/// The root is also put into the balance itself, whose terms are the power in and the heat out.
fn steady_leaking() -> Case {
    let phone = ungoverned();
    let point = load(1.5);
    let equation = phone.equation(&point);
    let (found, residual, gpu) = match long_run(&equation) {
        LongRun::Settles(expected) => {
            let residual = equation.to_air(&expected) / equation.power_in(&expected) - 1.0;
            (apart(&after_long(&phone, point), &expected), residual.abs(), expected[phone.gpu])
        }
        LongRun::RunsAway => (f64::INFINITY, f64::INFINITY, f64::INFINITY),
    };
    Case::new(
        "thermal/steady/leaking",
        "with leakage it ends at the bracketed root of u = a e^u, and there the air takes what comes in",
        "K",
        Limit::AtMost(1e-6),
        found,
    )
    .with_residual(residual)
    .because(format!("the GPU at {gpu:.2} K above the air"))
}

/// Leakage at which the gain of the loop is one, and how far it is from where the answer changes.
fn largest_leakage(phone: &Phone, point: &OperatingPoint) -> f64 {
    let without = HeatEquation { leakage: None, ..phone.equation(point) };
    let temperatures = phone.network.settled(&without.power);
    let mut watt = vec![0.0; phone.network.size()];
    watt[phone.gpu] = 1.0;
    let resistance = phone.network.settled(&watt)[phone.gpu];
    let LeakageLaw { celsius, per_kelvin, .. } = point.leakage;
    let above = temperatures[phone.gpu] + phone.ambient_celsius - celsius;
    (-1.0 - per_kelvin * above).exp() / (resistance * per_kelvin)
}

fn runaway_limit() -> Case {
    let phone = ungoverned();
    let wrong = (1..=16).map(|step| {
        let watts = 0.25 * f64::from(step);
        let largest = largest_leakage(&phone, &load(watts));
        let runs_away =
            |factor: f64| long_run(&phone.equation(&leaking(watts, factor * largest))) == LongRun::RunsAway;
        u64::from(runs_away(1.0 - 1e-12)) + u64::from(!runs_away(1.0 + 1e-12))
    });
    Case::none_of(
        "thermal/runaway/limit",
        "a phone settles up to a leakage of 1/(e R k e^(k T)) and runs away beyond it, told apart at one part in 1e12, for 16 loads",
        "wrong answers",
        wrong.sum(),
    )
}

fn runaway_ends() -> Case {
    let phone = ungoverned();
    let leaking = leaking(3.0, 1.5 * largest_leakage(&phone, &load(3.0)));
    let mut ends = Vec::new();
    for method in Method::ALL {
        let settings = Settings { method, ..Settings::over(1e5) };
        if let Ok(run) = phone.simulate(&[leaking], &settings) {
            let finite =
                run.samples.iter().flat_map(|sample| &sample.celsius).all(|celsius| celsius.is_finite());
            if let (Outcome::RanAway { at }, true) = (run.outcome, finite) {
                ends.push(at);
            }
        }
    }
    Case::none_of(
        "thermal/runaway/ends",
        "beyond it every method stops at the temperature of shutdown, with finite numbers, and says that nothing would have ended it",
        "methods that do not",
        (Method::ALL.len() - ends.len()) as u64,
    )
    .because(format!("after {:.3} s", ends.first().copied().unwrap_or(f64::NAN)))
}

/// A phone whose sensor at the skin tells by itself when it crosses 38 degrees.
fn told(hysteresis: f64) -> Phone {
    let phone = ungoverned();
    let sensor = phone.network.node("skin").expect("the built-in phone has a skin");
    let trip = Trip { celsius: 38.0, hysteresis };
    let zone = Zone {
        name: "skin".to_owned(),
        sensor,
        polling: 0.0,
        polling_passive: 1.0,
        rule: Rule::Monitor(vec![Cap { trip, clock_share: 0.5 }]),
    };
    Phone { zones: vec![zone], ..phone }
}

fn instants() -> Case {
    let phone = told(1.0);
    let instant = |method, tolerance, sample_seconds| {
        let settings = Settings { method, tolerance, sample_seconds, seconds: 900.0 };
        let run = phone.simulate(&ladder(2.5), &settings).expect("a load");
        run.switches.first().map_or(f64::INFINITY, |switch| switch.at)
    };
    let reference = instant(Method::Exponential, 1e-9, 1.0);
    let found: Vec<f64> =
        [0.1, 1.0, 10.0, 100.0, 900.0].map(|sample| instant(Method::default(), 1e-3, sample)).to_vec();
    let worst = found.iter().map(|at| (at - reference).abs()).fold(0.0, f64::max);
    Case::new(
        "thermal/instants",
        "the instant of a trip does not depend on where steps and samples end: from 0.1 to 900 s apart, against the exponential method at 1e-9 K",
        "seconds",
        Limit::AtMost(0.05),
        worst,
    )
    .because(format!("first trip at {reference:.6} s; a sensor that warms by 0.02 K/s and a tolerance of 1e-3 K make 0.05 s"))
}

fn chatter() -> Case {
    let mut least = f64::INFINITY;
    let mut switches = 0;
    for hysteresis in [0.1, 0.5, 1.0] {
        let phone = told(hysteresis);
        let skin = phone.zones[0].sensor;
        let settings = Settings { sample_seconds: 0.1, ..Settings::over(3600.0) };
        let run = phone.simulate(&ladder(2.5), &settings).expect("a load");
        let rate = run
            .samples
            .windows(2)
            .map(|pair| (pair[1].celsius[skin] - pair[0].celsius[skin]).abs() / (pair[1].at - pair[0].at))
            .fold(0.0, f64::max);
        let dwell = run.switches.windows(2).map(|pair| pair[1].at - pair[0].at).fold(f64::INFINITY, f64::min);
        least = least.min(dwell / (hysteresis / rate));
        switches += run.switches.len();
    }
    Case::new(
        "thermal/chatter",
        "a clock never changes again before its sensor could pass through the hysteresis at the largest rate it ever has",
        "shortest time between switches / that time",
        Limit::AtLeast(0.99),
        least,
    )
    .because(format!("{switches} switches in three hours, with a hysteresis of 0.1, 0.5 and 1 K"))
}

fn governed_balance() -> Case {
    let phone = builtin();
    let run = phone.simulate(&ladder(HEAVY), &Settings::over(TEN_MINUTES)).expect("a load");
    let joules = run.samples.last().map_or(f64::NAN, |sample| sample.joules);
    Case::new(
        "thermal/balance/governed",
        "over ten governed minutes heat in = heat stored + heat to the air",
        "relative",
        Limit::AtMost(1e-6),
        (joules - run.joules_stored - run.joules_to_air).abs() / joules,
    )
    .because(format!("{joules:.1} J in, {} switches, {:?}", run.switches.len(), run.outcome))
}

fn repeatable() -> Case {
    let phone = builtin();
    let run = || phone.simulate(&ladder(HEAVY), &Settings::over(TEN_MINUTES)).expect("a load");
    let first = run();
    let differing = std::thread::scope(|scope| {
        let others: Vec<_> = (0..4).map(|_| scope.spawn(run)).collect();
        let found = others.into_iter().map(|other| other.join().ok());
        found.filter(|other| other.as_ref() != Some(&first)).count()
    });
    Case::none_of(
        "thermal/repeatable",
        "four threads at once find the same ten minutes, to the last bit",
        "runs that differ",
        differing as u64,
    )
}

fn ten_minutes() -> Case {
    let phone = builtin();
    /// To an instant and to a crossing before it.
    const STEPS_PER_INSTANT: f64 = 2.0;
    // Samples, and readings of a sensor that is read all the time.
    let instants = TEN_MINUTES * (1.0 + 4.0);
    let mut best = f64::INFINITY;
    let mut steps = 0;
    for _ in 0..5 {
        let begun = Instant::now();
        let run = phone.simulate(&ladder(HEAVY), &Settings::over(TEN_MINUTES)).expect("a load");
        best = best.min(1e3 * begun.elapsed().as_secs_f64());
        steps = run.counts.steps + run.counts.rejected + run.counts.located;
    }
    Case::new(
        "thermal/ten-minutes",
        "ten minutes of a load that trips the GPU's zone, whose sensor is read four times a second from then on, with a sample each second",
        "steps",
        Limit::AtMost(STEPS_PER_INSTANT * instants),
        steps as f64,
    )
    .because(format!("{best:.2} ms, the best of five runs, which decides nothing"))
}
