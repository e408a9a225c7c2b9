//! Do the methods solve the heat equation, as accurately as they say, at the cost that they promise?

mod common;

use common::{chain, heated};
use thermal::{Counts, HeatEquation, Integrator, Method, Reached, State, Steps};

const TEN_MINUTES: f64 = 600.0;
/// In W; at the end the die leaks a watt.
const LEAKAGE: f64 = 0.2;

fn follow(equation: &HeatEquation<'_>, method: Method, steps: Steps, seconds: f64) -> (State, Counts) {
    let mut state = State::cold(equation.network);
    let mut integrator = Integrator::new(method, steps, equation.network).expect("a method");
    let reached = integrator.advance(equation, &mut state, seconds, &[]).expect("an end");
    assert_eq!(reached, Reached::End);
    (state, integrator.counts())
}

fn apart(a: &State, b: &State) -> f64 {
    let pairs = a.temperatures().iter().zip(b.temperatures());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn one_exponential_step_is_exact_without_leakage() {
    let network = chain(0.003);
    let equation = heated(&network, 0.0);
    let (one, _) = follow(&equation, Method::Exponential, Steps::Fixed(TEN_MINUTES), TEN_MINUTES);
    let (many, _) = follow(&equation, Method::Exponential, Steps::Fixed(0.25), TEN_MINUTES);
    assert!(apart(&one, &many) < 1e-10, "{}", apart(&one, &many));
    let (explicit, _) = follow(&equation, Method::Explicit, Steps::Tolerance(1e-10), TEN_MINUTES);
    assert!(apart(&one, &explicit) < 1e-7, "{}", apart(&one, &explicit));
}

/// Halving a step divides the error by 2 to the power of the order, where the fastest time constant is resolved.
#[test]
fn each_method_has_its_order() {
    let network = chain(3.0);
    let equation = heated(&network, LEAKAGE);
    let (reference, _) = follow(&equation, Method::Implicit, Steps::Fixed(0.01), 20.0);
    for (method, order) in [(Method::Explicit, 5.0), (Method::Implicit, 4.0), (Method::Exponential, 4.0)] {
        let error = |step| apart(&follow(&equation, method, Steps::Fixed(step), 20.0).0, &reference);
        let steps = match method {
            Method::Exponential => [2.5, 1.25],
            _ => [1.0, 0.5],
        };
        let [coarse, fine] = steps.map(error);
        let found = (coarse / fine).log2();
        assert!((found - order).abs() < 0.5, "{} has order {found}: {coarse:e}, {fine:e}", method.name());
    }
}

#[test]
fn errors_stay_within_the_tolerance() {
    let network = chain(0.0003);
    let equation = heated(&network, LEAKAGE);
    let (reference, _) = follow(&equation, Method::Implicit, Steps::Tolerance(1e-11), 60.0);
    for method in Method::ALL {
        for tolerance in [1e-1, 1e-3, 1e-5] {
            let (state, counts) = follow(&equation, method, Steps::Tolerance(tolerance), 60.0);
            let error = apart(&state, &reference);
            assert!(error <= tolerance, "{} at {tolerance}: {error:e}, {counts:?}", method.name());
        }
    }
}

#[test]
fn heat_in_is_heat_stored_and_heat_out() {
    let network = chain(0.003);
    let equation = heated(&network, LEAKAGE);
    for method in Method::ALL {
        let (state, _) = follow(&equation, method, Steps::Tolerance(1e-3), TEN_MINUTES);
        let balance = state.heat_in() - network.stored(state.temperatures()) - state.heat_out();
        assert!(balance.abs() <= 1e-10 * state.heat_in(), "{}: {balance:e} J", method.name());
    }
}

/// A die that is a million times as fast costs a few steps more at the start, where it warms, and none later.
#[test]
fn steps_of_the_stiff_methods_do_not_depend_on_the_fastest_time_constant() {
    for method in [Method::Implicit, Method::Exponential] {
        let steps = |decade: i32| {
            let network = chain(1e-1 * 10_f64.powi(-decade));
            let equation = heated(&network, LEAKAGE);
            let (_, counts) = follow(&equation, method, Steps::Tolerance(1e-3), TEN_MINUTES);
            counts.steps + counts.rejected
        };
        let steps: Vec<u64> = (0..=6).map(steps).collect();
        let (least, most) = (steps.iter().min().expect("steps"), steps.iter().max().expect("steps"));
        assert!(*most <= 2 * least, "{}: {steps:?}", method.name());
    }
}

#[test]
fn time_scales_with_all_heat_capacities_to_the_last_bit() {
    let network = chain(0.003);
    let slow = network.slowed(4.0).expect("a network");
    for method in Method::ALL {
        let steps = Steps::Tolerance(1e-4);
        let (fast, cost) = follow(&heated(&network, LEAKAGE), method, steps, 60.0);
        let (slow, slow_cost) = follow(&heated(&slow, LEAKAGE), method, steps, 240.0);
        assert_eq!(fast.temperatures(), slow.temperatures(), "{}", method.name());
        assert_eq!((cost, 4.0 * fast.heat_in()), (slow_cost, slow.heat_in()), "{}", method.name());
    }
}

#[test]
fn a_fixed_step_beyond_stability_is_an_error_and_not_a_number() {
    let network = chain(1e-4);
    let equation = heated(&network, LEAKAGE);
    let mut state = State::cold(&network);
    let mut integrator = Integrator::new(Method::Explicit, Steps::Fixed(1.0), &network).expect("a method");
    let refused = integrator.advance(&equation, &mut state, TEN_MINUTES, &[]).expect_err("unstable");
    assert!(refused.to_string().contains("explicit at"), "{refused}");
    assert!(Integrator::new(Method::Explicit, Steps::Tolerance(0.0), &network).is_err());
}
