//! What a probe measures.

use super::{KernelResult, Pattern, run_kernel};
use crate::config::{CacheRole, Gpu};
use crate::error::Error;
use crate::replay::Fidelity;

/// A probe in its steady state: what its second half cost, so that cold caches and the first warps are in no figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Seconds.
    pub seconds: f64,
    /// Loads of lanes: pointers, elements, samples or texels.
    pub loads: u64,
    /// Bytes that lanes asked for, read and written.
    pub bytes: u64,
    /// Bytes of lines that caches of each role delivered or took.
    cache_bytes: Vec<(CacheRole, u64)>,
    /// Bytes read from memory.
    pub memory_read_bytes: u64,
    /// Bytes written to memory.
    pub memory_write_bytes: u64,
}

impl Pattern {
    /// Measures it on a GPU that does nothing else.
    ///
    /// # Errors
    /// When the GPU's memory cannot be as described.
    pub fn observe(&self, gpu: &Gpu, fidelity: Fidelity) -> Result<Observation, Error> {
        let warps = self.whole(gpu);
        let half = run_kernel(&self.on(gpu, warps), gpu, fidelity)?;
        let whole = run_kernel(&self.on(gpu, 2 * warps), gpu, fidelity)?;
        let of = |result: &KernelResult, role| {
            let levels = gpu.caches.iter().zip(result.traffic.levels).filter(|(cache, _)| cache.role == role);
            levels.map(|(cache, served)| served.accesses * cache.line_bytes).sum::<u64>()
        };
        let roles = [CacheRole::L1, CacheRole::Cluster, CacheRole::L2, CacheRole::Slc];
        Ok(Observation {
            seconds: whole.seconds - half.seconds,
            loads: self.loads_per_warp(gpu) * u64::from(warps),
            bytes: self.bytes_per_warp(gpu) * u64::from(warps),
            cache_bytes: roles.map(|role| (role, of(&whole, role) - of(&half, role))).to_vec(),
            memory_read_bytes: whole.traffic.dram_read_bytes - half.traffic.dram_read_bytes,
            memory_write_bytes: whole.traffic.dram_write_bytes - half.traffic.dram_write_bytes,
        })
    }
}

impl Observation {
    /// Seconds per load of a lane.
    pub fn seconds_per_load(&self) -> f64 {
        self.seconds / self.loads as f64
    }

    /// Bytes that lanes asked for, per second.
    pub fn bytes_per_second(&self) -> f64 {
        self.bytes as f64 / self.seconds
    }

    /// Bytes of lines through the caches of a role, per second.
    pub fn cache_bytes_per_second(&self, role: CacheRole) -> f64 {
        let of_role = self.cache_bytes.iter().filter(|&&(of, _)| of == role);
        of_role.map(|&(_, bytes)| bytes as f64).sum::<f64>() / self.seconds
    }

    /// Bytes read from memory, per second.
    pub fn memory_bytes_per_second(&self) -> f64 {
        self.memory_read_bytes as f64 / self.seconds
    }

    /// Bytes read from memory and written to it, per second.
    pub fn memory_traffic_per_second(&self) -> f64 {
        (self.memory_read_bytes + self.memory_write_bytes) as f64 / self.seconds
    }
}
