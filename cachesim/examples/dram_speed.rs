//! How many requests of 64 bytes per second the DRAM model simulates, with 64 outstanding, by pattern:
//! `dram_speed [REQUESTS]`.

use std::error::Error;
use std::time::Instant;

use cachesim::synthetic::{Stream, lines};
use cachesim::{DRAM_STANDARDS, Dram, DramConfig, DramStandard};

const OUTSTANDING: usize = 64;

fn main() -> Result<(), Box<dyn Error>> {
    let count = std::env::args().nth(1).map_or(Ok(2_000_000), |count| count.parse())?;
    for standard in DRAM_STANDARDS {
        for stream in [Stream::Seq, Stream::Bvh, Stream::Rnd] {
            let standard = DramStandard::builtin(standard.name)?;
            let channels = 4;
            let bytes_per_second = standard.fastest_channel() * f64::from(channels);
            let config = DramConfig { standard, channels, bytes_per_second, queue: 32 };
            let lines = lines(stream, count);
            let mut dram = Dram::new(&config)?;
            let start = Instant::now();
            let (mut now, mut outstanding, mut done) = (0, 0, Vec::new());
            for (number, line) in (0..).zip(&lines) {
                while outstanding == OUTSTANDING {
                    now = dram.next_event().ok_or("requests are outstanding")?;
                    dram.advance(now, &mut done);
                    outstanding -= done.len();
                    done.clear();
                }
                dram.submit(now, line.get() * 64, 64, number % 5 == 0, number);
                outstanding += 1;
            }
            dram.advance(u64::MAX, &mut done);
            let seconds = start.elapsed().as_secs_f64();
            let stats = dram.stats();
            let rows = stats.rows;
            println!(
                "{:8} {stream:?}: {:.2} M requests/s; {:.1} GB/s of {:.1}, row hits {:.0} %",
                config.standard.name,
                count as f64 / seconds * 1e-6,
                count as f64 * 64e3 / now as f64,
                bytes_per_second * 1e-9,
                100.0 * rows.hits as f64 / (rows.hits + rows.misses + rows.conflicts) as f64,
            );
        }
    }
    Ok(())
}
