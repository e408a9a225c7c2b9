//! Leakage: power that a die takes only because it is warm.

use crate::phi::phi;

/// Leakage of a node, exponential in its temperature: `watts = at_reference exp(per_kelvin (T - reference))`.
///
/// Measurements of mobile application processors show such a law from 20 to 85 degrees Celsius (De Vogeleer et al. 2014). It holds
/// nowhere near infinity: simulations end at a temperature at which the die shuts down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leakage {
    /// The node, by place in the network.
    pub node: usize,
    /// At the reference temperature, in W.
    pub at_reference: f64,
    /// Rise above the air at which the figure holds, in K.
    pub reference: f64,
    /// Relative growth per kelvin.
    pub per_kelvin: f64,
}

impl Leakage {
    /// Power at a rise above the air, in W.
    pub fn watts(&self, rise: f64) -> f64 {
        self.at_reference * (self.per_kelvin * (rise - self.reference)).exp()
    }

    /// Its derivative, in W/K.
    pub fn slope(&self, rise: f64) -> f64 {
        self.per_kelvin * self.watts(rise)
    }

    /// How far the power at `rise + change` is above the tangent at `rise`, in W; nothing cancels.
    pub(crate) fn above_tangent(&self, rise: f64, change: f64) -> f64 {
        let x = self.per_kelvin * change;
        self.watts(rise) * x * x * phi(x)[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_above_the_tangent_is_what_the_law_says() {
        let leakage = Leakage { node: 0, at_reference: 0.5, reference: 30.0, per_kelvin: 0.04 };
        assert_eq!(leakage.watts(30.0), 0.5);
        for change in [25.0, -40.0, 100.0] {
            let direct = leakage.watts(50.0 + change) - leakage.watts(50.0) - change * leakage.slope(50.0);
            assert!((leakage.above_tangent(50.0, change) / direct - 1.0).abs() < 1e-13);
        }
        // Far below the rounding of the direct form: half the curvature times the square.
        let expected = 0.5 * 0.04 * leakage.slope(50.0) * 1e-18;
        assert!((leakage.above_tangent(50.0, 1e-9) / expected - 1.0).abs() < 1e-10);
    }
}
