//! The integrators against each other, against closed forms and against what they promise.

use super::WorkPoint;
use super::problem::Problem;
use crate::case::{Case, Limit};
use thermal::{HeatEquation, Integrator, Method, State, Steps};

/// The methods whose steps the fastest time constant does not limit.
const STIFF: [Method; 2] = [Method::Implicit, Method::Exponential];

pub(super) fn cases(problem: &Problem, points: &[WorkPoint]) -> Vec<Case> {
    let mut cases = vec![agreement(problem), exact(problem)];
    cases.extend(Method::ALL.map(|method| order(problem, method)));
    cases.extend(STIFF.map(|method| tolerance(points, method)));
    cases.extend(Method::ALL.map(|method| balance(problem, method)));
    cases.extend(STIFF.map(|method| cost(problem, method)));
    cases.push(scaling(problem));
    cases
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Follows an equation from the temperature of the air; answers the state and all steps.
fn follow(equation: &HeatEquation<'_>, method: Method, steps: Steps, seconds: f64) -> (State, u64) {
    let mut state = State::cold(equation.network);
    let mut integrator = Integrator::new(method, steps, equation.network).expect("steps above 0");
    integrator.advance(equation, &mut state, seconds, &[]).expect("the equation has a solution");
    let counts = integrator.counts();
    (state, counts.steps + counts.rejected)
}

fn agreement(problem: &Problem) -> Case {
    let of = |method| {
        let (found, counts) = problem.solve(method, Steps::Tolerance(1e-10)).expect("a solution");
        (problem.error(&found), counts.steps)
    };
    let [(explicit, most), (exponential, few)] = [Method::Explicit, Method::Exponential].map(of);
    Case::new(
        "thermal/reference",
        "the explicit and the exponential method at a tolerance of 1e-10 K come to the implicit one's reference at 1e-11 K",
        "K",
        Limit::AtMost(1e-7),
        explicit.max(exponential),
    )
    .because(format!("explicit {explicit:.1e} K in {most} steps, exponential {exponential:.1e} K in {few}"))
}

/// Without leakage the solution is a matrix exponential: from nothing to all of the way in one step, or in two.
fn exact(problem: &Problem) -> Case {
    let equation = HeatEquation { leakage: None, ..problem.equation(problem.network(), 4.0) };
    let settled = problem.network().settled(&equation.power);
    let worst = [1e-3, 1.0, 1e3, 1e5]
        .map(|seconds| {
            let (one, _) = follow(&equation, Method::Exponential, Steps::Fixed(seconds), seconds);
            let (many, _) = follow(&equation, Method::Exponential, Steps::Fixed(seconds / 64.0), seconds);
            apart(one.temperatures(), many.temperatures())
        })
        .into_iter()
        .fold(0.0, f64::max);
    let (last, _) = follow(&equation, Method::Exponential, Steps::Fixed(1e5), 1e5);
    let rest = apart(last.temperatures(), &settled);
    Case::new(
        "thermal/exact",
        "without leakage one exponential step equals 64, over a millisecond as over a day, and ends at the solution of the linear system",
        "K",
        Limit::AtMost(1e-10),
        worst.max(rest),
    )
    .because(format!("{worst:.1e} K between one step and 64, {rest:.1e} K from the linear system after 1e5 s"))
}

/// A slower die, so that all methods can take steps at which their error is above rounding.
fn order(problem: &Problem, method: Method) -> Case {
    const SECONDS: f64 = 20.0;
    let (expected, step) = match method {
        Method::Explicit => (5.0, 0.5),
        Method::Implicit => (4.0, 0.5),
        Method::Exponential => (4.0, 1.25),
    };
    let network = problem.network().with_capacity(problem.gpu(), 3.0).expect("a capacity");
    let equation = problem.equation(&network, 4.0);
    let (reference, _) = follow(&equation, Method::Implicit, Steps::Fixed(step / 64.0), SECONDS);
    let error = |step| {
        let (state, _) = follow(&equation, method, Steps::Fixed(step), SECONDS);
        apart(state.temperatures(), reference.temperatures())
    };
    let (coarse, fine) = (error(step), error(0.5 * step));
    let found = (coarse / fine).log2();
    Case::new(
        format!("thermal/order/{}", method.name()),
        "halving the step divides the error by 2 to the power of the method's order",
        "difference of orders",
        Limit::AtMost(0.6),
        (found - expected).abs(),
    )
    .because(format!("order {found:.2}, expected {expected}: {coarse:.1e} and {fine:.1e} K"))
}

fn tolerance(points: &[WorkPoint], method: Method) -> Case {
    let share = |point: &WorkPoint| match point.steps {
        Steps::Tolerance(tolerance) => Some((point.error.unwrap_or(f64::INFINITY) / tolerance, tolerance)),
        Steps::Fixed(_) => None,
    };
    let largest = |method| {
        let of_method = points.iter().filter(|point| point.method == method);
        of_method.filter_map(share).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0.0))
    };
    let worst = largest(method);
    Case::new(
        format!("thermal/tolerance/{}", method.name()),
        "on the stiff load, at tolerances over six decades, the error after all steps is at most the tolerance of each",
        "error / tolerance",
        Limit::AtMost(1.0),
        worst.0,
    )
    .because(format!(
        "largest at a tolerance of {:.0e} K; explicit {:.2}, where its steps are at the edge of stability",
        worst.1,
        largest(Method::Explicit).0
    ))
}

fn balance(problem: &Problem, method: Method) -> Case {
    let equation = problem.equation(problem.network(), 4.0);
    let (state, _) = follow(&equation, method, Steps::Tolerance(1e-3), 60.0);
    let stored = problem.network().stored(state.temperatures());
    let rest = (state.heat_in() - stored - state.heat_out()).abs() / state.heat_in();
    Case::new(
        format!("thermal/balance/{}", method.name()),
        "heat in = heat stored + heat to the air, each integrated by itself",
        "relative",
        Limit::AtMost(1e-6),
        rest,
    )
    .because(format!("{:.3} J in, {stored:.3} J stored, {:.3} J out", state.heat_in(), state.heat_out()))
}

fn cost(problem: &Problem, method: Method) -> Case {
    let of = |method, decade: i32| {
        let capacity = 0.1 * 10_f64.powi(-decade);
        let network = problem.network().with_capacity(problem.gpu(), capacity).expect("a capacity");
        follow(&problem.equation(&network, 4.0), method, Steps::Tolerance(1e-3), 60.0).1
    };
    let steps: Vec<u64> = (0..=6).map(|decade| of(method, decade)).collect();
    let explicit: Vec<u64> = (0..=3).map(|decade| of(Method::Explicit, decade)).collect();
    let (least, most) = (steps.iter().min().copied().unwrap_or(1), steps.iter().max().copied().unwrap_or(1));
    Case::new(
        format!("thermal/cost/{}", method.name()),
        "a GPU of a million times less heat capacity costs at most twice the steps",
        "most steps / least",
        Limit::AtMost(2.0),
        most as f64 / least as f64,
    )
    .because(format!(
        "steps from 0.1 to 1e-7 J/K: {}; explicit from 0.1 to 1e-4 J/K: {}",
        list(&steps),
        list(&explicit)
    ))
}

fn list(steps: &[u64]) -> String {
    steps.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
}

fn scaling(problem: &Problem) -> Case {
    let slow = problem.network().slowed(4.0).expect("capacities");
    let differing = Method::ALL.into_iter().filter(|&method| {
        let of = |network, seconds| {
            let (state, steps) =
                follow(&problem.equation(network, 4.0), method, Steps::Tolerance(1e-4), seconds);
            (state.temperatures().to_vec(), steps)
        };
        of(problem.network(), 15.0) != of(&slow, 60.0)
    });
    Case::none_of(
        "thermal/scaling",
        "four times the heat capacities and four times the time give the same temperatures, to the last bit",
        "methods that differ",
        differing.count() as u64,
    )
}
