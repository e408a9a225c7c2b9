//! How long kernels wait for DMA that reads ahead of them.

use super::bounds::dram_bandwidth;
use crate::config::Gpu;
use crate::counters::IssueCounters;

/// Seconds that the kernel of a phase, which computes for `computing` seconds, waits for its reads.
///
/// While it works on what one read has brought, the next is under way (two buffers). All reads are taken to be of the mean size, and all
/// parts of the kernel to take as long: the first read is waited for as a whole, and of every other one what is longer than a part.
pub(super) fn exposed_seconds(issue: &IssueCounters, computing: f64, gpu: &Gpu) -> f64 {
    let Some(memory) = gpu.internal_memory.filter(|_| issue.dma_reads > 0) else { return 0.0 };
    let reads = issue.dma_reads as f64;
    let of_read = memory.dma_setup_seconds + issue.dma_read_bytes as f64 / dram_bandwidth(gpu) / reads;
    of_read + (reads - 1.0) * (of_read - computing / reads).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_read_is_waited_for_and_of_the_others_what_is_longer_than_a_part_of_the_kernel() {
        let gpu = Gpu::builtin("sgrt").expect("it is built in").expect("it is valid");
        let setup = gpu.internal_memory.expect("it has one").dma_setup_seconds;
        // A row of 2048 pixels of 12 bytes, 1024 times.
        let issue = IssueCounters { dma_read_bytes: 1024 * 2048 * 12, dma_reads: 1024, ..Default::default() };
        let of_row = setup + 2048.0 * 12.0 / (29.8e9 * 0.83);
        let exposed = |of_kernel_row: f64| exposed_seconds(&issue, 1024.0 * of_kernel_row, &gpu);
        let close = |found: f64, expected: f64| (found - expected).abs() < 1e-12 + 1e-9 * expected;
        assert!(close(exposed(0.0), 1024.0 * of_row));
        assert!(close(exposed(0.75 * of_row), of_row + 1023.0 * 0.25 * of_row));
        assert!(close(exposed(of_row), of_row), "covered");
        assert!(close(exposed(5.0 * of_row), of_row), "covered");
        assert_eq!(exposed_seconds(&IssueCounters::default(), 1.0, &gpu), 0.0);
    }
}
