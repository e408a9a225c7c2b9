//! Are the traces for other DRAM simulators, character by character, what those read?

use std::io::{self, Write};
use std::num::NonZeroU64;

use cachesim::{MissTraceFormat, MissTraceWriter};

const REQUESTS: [(u64, u64, bool); 4] =
    [(0, 0, false), (999, 0x40, true), (1000, 0xDEAD_BEC0, false), (1_250_000, u64::MAX, true)];

fn written(format: MissTraceFormat) -> String {
    let mut trace = MissTraceWriter::new(Vec::new(), format);
    for (at, address, write) in REQUESTS {
        trace.record(at, address, write).unwrap();
    }
    String::from_utf8(trace.finish().unwrap()).unwrap()
}

#[test]
fn dramsim3_reads_address_kind_and_cycle() {
    let clock_ps = NonZeroU64::new(500).unwrap();
    assert_eq!(
        written(MissTraceFormat::DramSim3 { clock_ps }),
        "0x0 READ 0\n0x40 WRITE 1\n0xdeadbec0 READ 2\n0xffffffffffffffff WRITE 2500\n"
    );
}

#[test]
fn ramulator_2_reads_kind_and_address() {
    assert_eq!(
        written(MissTraceFormat::Ramulator2),
        "LD 0x0\nST 0x40\nLD 0xdeadbec0\nST 0xffffffffffffffff\n"
    );
}

#[test]
fn a_failing_output_is_reported() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let mut trace = MissTraceWriter::new(Full, MissTraceFormat::Ramulator2);
    assert_eq!(trace.record(0, 0, false).unwrap_err().kind(), io::ErrorKind::StorageFull);
}
