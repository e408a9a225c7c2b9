//! How far are the quick answers from the exact ones? Errors in miss ratio, on the synthetic streams, of
//! AET by size, and of the correction for associativity by geometry: `curve_errors [ACCESSES]`.

use std::error::Error;

use cachesim::synthetic::{Stream, lines};
use cachesim::{
    Aet, Bytes, Hierarchy, LevelConfig, Levels, LineId, LineSize, MissCurve, Policy, StackDistances, Ways,
};

/// Sizes per doubling.
const STEPS: u32 = 16;

fn main() -> Result<(), Box<dyn Error>> {
    let count = std::env::args().nth(1).map_or(Ok(24_000_000), |count| count.parse())?;
    for stream in [Stream::Bvh, Stream::Rnd, Stream::Seq] {
        let trace = lines(stream, count);
        let (mut distances, mut aet) = (StackDistances::new(), Aet::new());
        for &line in &trace {
            distances.touch(line);
            aet.touch(line);
        }
        let (exact, aet) = (distances.curve(), aet.curve());
        println!("{stream:?}: {count} accesses, {} lines", exact.cold_misses());
        println!("  AET, fully associative: largest error among {STEPS} sizes per doubling");
        for octave in 0..18 {
            let (at, error) = (octave * STEPS..(octave + 1) * STEPS)
                .map(|step| (f64::from(step) / f64::from(STEPS)).exp2() as u64)
                .map(|lines| (lines, ratio(aet.misses(lines), count) - ratio(exact.misses(lines), count)))
                .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
                .ok_or("there are sizes")?;
            println!(
                "    from {:>8} B: {error:+.5} at {at} lines, where the exact miss ratio is {:.5}",
                64_u64 << octave,
                ratio(exact.misses(at), count)
            );
        }
        println!(
            "  set-associative: {:>10} {:>4} {:>9} {:>9} {:>9} {:>9}",
            "bytes", "ways", "simulated", "full", "exact", "AET"
        );
        for kib in [4, 16, 64, 256, 1024, 4096] {
            for ways in [1, 2, 4, 8, 16] {
                let simulated = simulated(kib << 10, ways, &trace)?;
                let sets = (kib << 10) / 64 / u64::from(ways);
                let error = |misses: f64| (misses - simulated as f64) / count as f64;
                let estimate = |curve: &MissCurve| error(curve.set_associative(sets, ways.into()));
                println!(
                    "{:>29} {ways:>4} {:>9.5} {:>+9.5} {:>+9.5} {:>+9.5}",
                    kib << 10,
                    ratio(simulated, count),
                    error(exact.misses(sets * u64::from(ways)) as f64),
                    estimate(&exact),
                    estimate(&aet)
                );
            }
        }
    }
    Ok(())
}

fn ratio(misses: u64, accesses: usize) -> f64 {
    misses as f64 / accesses as f64
}

fn simulated(bytes: u64, ways: u32, trace: &[LineId]) -> Result<u64, Box<dyn Error>> {
    let line = LineSize::new(64).ok_or("64 is a power of two")?;
    let level = LevelConfig::new("cache", Bytes(bytes), line, Ways::Count(ways), Policy::Lru);
    let (mut hierarchy, path) = Hierarchy::chain(&Levels::new(vec![level])?)?;
    hierarchy.read(path, 0, trace);
    Ok(hierarchy.counts(0).misses)
}
