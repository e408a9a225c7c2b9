//! Energy of a frame: what its events take, what its memory takes, and what leaks meanwhile.
//!
//! Counts times picojoules, from the counters alone, so every rung and every sample has it. [`EnergyPrices`] are those of one GPU, from an
//! [`EnergyTable`](crate::EnergyTable) and the GPU's process; [`FrameEnergy`] is the sum, by cause and by pass. What scales with the GPU's
//! voltage, what does not, and what time alone takes are kept apart ([`Domain`]).

mod dram;
mod frame;
mod leakage;
mod prices;
#[cfg(test)]
mod tests;

pub use dram::{DramPower, Rail};
pub use frame::{CauseEnergy, Domain, FrameEnergy, PassEnergy};
pub use leakage::Leakage;
pub use prices::{EnergyPrices, Price, Supply};
