//! The requests to DRAM as a trace for other DRAM simulators.

use std::io::{self, Write};
use std::num::NonZeroU64;

/// Whose trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissTraceFormat {
    /// DRAMsim3's trace-based CPU: `0xADDRESS READ|WRITE CYCLE` per line, as read by `operator>>` of its
    /// `src/common.cc`; the cycle is the memory's clock, counted from 0.
    DramSim3 {
        /// The length of that clock.
        clock_ps: NonZeroU64,
    },
    /// Ramulator 2's `LoadStoreTrace`: `LD|ST 0xADDRESS` per line, as read by `init_trace` of its
    /// `src/frontend/impl/memory_trace/loadstore_trace.cpp`. It has no times: the requests follow each other
    /// as the memory takes them.
    Ramulator2,
}

/// Writes a trace, a line per request, as the requests come.
#[derive(Debug)]
pub struct MissTraceWriter<W> {
    output: W,
    format: MissTraceFormat,
}

impl<W: Write> MissTraceWriter<W> {
    /// Writes to `output`, which should be buffered.
    pub fn new(output: W, format: MissTraceFormat) -> Self {
        Self { output, format }
    }

    /// Writes one request. Requests come in order of time.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn record(&mut self, at_ps: u64, address: u64, write: bool) -> io::Result<()> {
        match self.format {
            MissTraceFormat::DramSim3 { clock_ps } => {
                let kind = if write { "WRITE" } else { "READ" };
                writeln!(self.output, "{address:#x} {kind} {}", at_ps / clock_ps)
            }
            MissTraceFormat::Ramulator2 => {
                let kind = if write { "ST" } else { "LD" };
                writeln!(self.output, "{kind} {address:#x}")
            }
        }
    }

    /// Writes what is buffered and gives the output back.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn finish(mut self) -> io::Result<W> {
        self.output.flush()?;
        Ok(self.output)
    }
}
