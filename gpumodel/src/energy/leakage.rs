//! Power of a GPU that does nothing.

use crate::config::{LeakageFigures, Tag};

/// Leakage of a whole GPU, by voltage and temperature.
#[derive(Clone, Debug)]
pub struct Leakage {
    figures: LeakageFigures,
    lanes: f64,
}

impl Leakage {
    pub(super) fn new(figures: &LeakageFigures, lanes: f64) -> Self {
        Self { figures: figures.clone(), lanes }
    }

    /// Watts at a supply of `volts` and a chip of `celsius` degrees: lanes x a figure x V^3 x a polynomial of the temperature, as Arm's simple power
    /// model has it. Never negative, where the polynomial would be.
    pub fn watts(&self, volts: f64, celsius: f64) -> f64 {
        let scale = self.figures.scale_at(celsius).max(0.0);
        self.lanes * self.figures.milliwatts_per_lane * 1e-3 * volts.powi(3) * scale
    }

    /// The temperature from which on an exponential law has its figures, in degrees Celsius.
    pub fn fitted_from_celsius(&self) -> f64 {
        self.figures.fit_celsius[0]
    }

    /// The warmer temperature at which an exponential law has its figures, in degrees Celsius.
    pub fn fitted_to_celsius(&self) -> f64 {
        self.figures.fit_celsius[1]
    }

    /// Relative growth per kelvin of the exponential law through its figures at [`Self::fitted_from_celsius`] and [`Self::fitted_to_celsius`]: above zero, and
    /// the same at any voltage.
    pub fn growth_per_kelvin(&self) -> f64 {
        let [cool, warm] = self.figures.fit_celsius;
        (self.figures.scale_at(warm) / self.figures.scale_at(cool)).ln() / (warm - cool)
    }

    /// The temperature that reports assume, in degrees Celsius.
    pub fn reference_celsius(&self) -> f64 {
        self.figures.reference_celsius
    }

    /// How far its figure can be trusted.
    pub fn tag(&self) -> Tag {
        self.figures.tag
    }
}
