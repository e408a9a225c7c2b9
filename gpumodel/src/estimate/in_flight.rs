//! How long the load/store port is held up by lines that find no free place in flight.
//!
//! While a place is free, the port sends lines out as if there were no limit; once all are taken, the next line waits at its
//! head until one is free again. With Poisson arrivals the lines on their way are the queue M/M/c with room for one: `c`
//! places, and the line that holds the port. So the share of the time for which it is held is
//!
//! ```text
//! h = B r / (1 + B r),   r = a / c
//! ```
//!
//! where `a` lines would be on their way without a limit at the rate of a port that is not held, and `B` is the loss formula
//! of Erlang 1917. It has the limits that it must have: a port with nothing else to do sends out `c` lines per latency.
//!
//! Lines do not come one by one. The variance of the lines on their way without a limit, over their mean, is the peakedness `z`; as
//! Hayward found (Fredericks 1980), `c` places then serve `a` lines as `c / z` places serve `a / z` single ones.

/// Lines of a core on their way, of which there are so many at most.
#[derive(Clone, Copy, Debug)]
pub(super) struct InFlight {
    pub(super) places: f64,
    /// Lines of a turn.
    pub(super) lines: f64,
    /// Squared coefficient of variation of these.
    pub(super) variability: f64,
    /// Mean seconds that a line is on its way.
    pub(super) latency: f64,
    /// With `P(t)` the part of lines that is on its way for longer than `t`: the integral of `P²` over that of `P`. 1 where all
    /// are on their way for as long as each other, 1/2 where that is exponential.
    pub(super) evenness: f64,
}

/// `1 / B` above which nothing waits.
const NEVER: f64 = 1e15;

impl InFlight {
    /// Longer than a turn can hold the port: each of its lines waits for all of another's time on its way.
    pub(super) fn longest_hold(&self) -> f64 {
        self.lines * self.latency
    }

    /// Seconds that a turn would hold the port at so many turns per second, if each works at the port for `working` seconds and holds
    /// it for `held`.
    pub(super) fn hold(&self, turns_per_second: f64, working: f64, held: f64) -> f64 {
        let free = 1.0 - (turns_per_second * held).min(1.0 - f64::EPSILON);
        let busy = (turns_per_second * working / free).min(1.0);
        let peakedness = self.peakedness(busy);
        let offered = turns_per_second * self.lines * self.latency / free / peakedness;
        let places = self.places / peakedness;
        let blocked = offered / places / inverse_loss(places, offered);
        blocked / (1.0 + blocked) / turns_per_second
    }

    /// Of the lines on their way, at a port that works for the part `busy` of the time that it is not held: turns leave it
    /// evenly when it is always busy, and as they come when it is hardly ever (Whitt 1983, departures of a queue).
    fn peakedness(&self, busy: f64) -> f64 {
        let of_turns = 1.0 - busy * busy;
        let of_lines = self.lines * (self.variability + of_turns);
        1.0 + (of_lines - 1.0) * self.evenness
    }
}

/// `1 / B` of Erlang's loss formula. Between whole numbers of places by the parabola of Rapp 1964.
fn inverse_loss(places: f64, offered: f64) -> f64 {
    if offered <= 0.0 {
        return f64::INFINITY;
    }
    let part = places.fract();
    let scale = (1.0 + offered).powi(2) + offered;
    let mut inverse = 1.0 / (1.0 - part * (offered + 2.0) / scale + part * part / ((1.0 + offered) * scale));
    let mut place = part;
    while place + 0.5 < places && inverse < NEVER {
        place += 1.0;
        inverse = 1.0 + place / offered * inverse;
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erlang_s_table_is_met() {
        // Loss of 1 % and of 0.1 %: offered load by places, as tables of Erlang B print it.
        for (places, offered, loss) in
            [(1.0, 0.0101, 0.01), (10.0, 4.461, 0.01), (100.0, 84.06, 0.01), (20.0, 9.412, 0.001)]
        {
            let found = 1.0 / inverse_loss(places, offered);
            assert!(
                (found / loss - 1.0).abs() < 0.002,
                "{places} places, {offered} offered: {found}, table {loss}"
            );
        }
    }

    #[test]
    fn the_loss_falls_with_every_part_of_a_place() {
        for offered in [0.01, 1.0, 7.3, 100.0] {
            let losses: Vec<f64> =
                (1..400).map(|tenth| 1.0 / inverse_loss(f64::from(tenth) / 10.0, offered)).collect();
            for (tenth, pair) in losses.windows(2).enumerate() {
                assert!(
                    pair[1] < pair[0] || pair[0] < 10.0 / NEVER,
                    "{offered} offered, {} tenths: {pair:?}",
                    tenth + 1
                );
            }
        }
    }

    /// The hold with which throughput and hold agree, of a port that always has work.
    fn settled(lines: &InFlight, working: f64) -> f64 {
        let (mut low, mut high) = (0.0_f64, lines.longest_hold());
        for _ in 0..200 {
            let held = low.midpoint(high);
            let over = lines.hold(1.0 / (working + held), working, held) > held;
            (low, high) = if over { (held, high) } else { (low, held) };
        }
        low
    }

    const EVEN: InFlight =
        InFlight { places: 32.0, lines: 1.0, variability: 1.0, latency: 1.0, evenness: 1.0 };

    #[test]
    fn a_port_with_nothing_else_to_do_sends_out_as_many_lines_per_latency_as_there_are_places() {
        let per_turn = settled(&EVEN, 1e-6) + 1e-6;
        assert!((per_turn * EVEN.places - 1.0).abs() < 1e-3, "{per_turn}");
    }

    #[test]
    fn one_place_for_single_lines_is_held_as_long_as_a_machine_that_repairs_itself() {
        // Exact: of the states none, one, and one that another waits for, with rates 1/w up and 1/l down.
        let lines = InFlight { places: 1.0, ..EVEN };
        for working in [0.1, 1.0, 10.0] {
            let held = settled(&lines, working);
            let offered = 1.0 / working;
            let expected = offered * offered / (1.0 + offered) * working;
            assert!((held / expected - 1.0).abs() < 1e-9, "{working}: {held}, expected {expected}");
        }
    }

    #[test]
    fn lines_that_come_in_clumps_hold_the_port_for_longer_and_more_places_for_less() {
        let working = 1.0 / 24.0;
        let even = settled(&EVEN, working);
        assert!(settled(&InFlight { variability: 3.0, ..EVEN }, working) > 1.5 * even);
        assert!(settled(&InFlight { places: 48.0, ..EVEN }, working) < 0.1 * even);
        assert!(even > 0.0);
    }
}
