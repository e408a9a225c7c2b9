//! The memory behind rows of power.

use gpumodel::energy::{DramPower, EnergyPrices};
use gpumodel::{EnergyTable, Error, Gpu};

/// The memory of a GPU that comes with the program, as a consumer of power; `None` where its description names no process.
///
/// # Errors
/// When there is no such GPU, or the table of energies does not know its process or memory.
pub(super) fn memory_of(gpu: &str) -> Result<Option<DramPower>, Error> {
    match Gpu::builtin(gpu) {
        Some(gpu) => power_of(&gpu?),
        None => Ok(None),
    }
}

/// Gives the memory of `gpu` the peak at which so many 10^9 bytes per second go through each of its interfaces.
///
/// # Errors
/// When the table of energies does not know the GPU's process or memory.
pub fn set_interface_rate(gpu: &mut Gpu, gbs: f64) -> Result<(), Error> {
    if let Some(memory) = power_of(gpu)? {
        gpu.dram.peak_bytes_per_second = gbs * 1e9 * memory.interfaces() / gpu.dram.efficiency;
    }
    Ok(())
}

fn power_of(gpu: &Gpu) -> Result<Option<DramPower>, Error> {
    Ok(EnergyPrices::new(&EnergyTable::builtin()?, gpu)?.map(|prices| prices.dram().clone()))
}
