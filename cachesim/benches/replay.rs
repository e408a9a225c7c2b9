//! How fast is a replay? Accesses per CPU-second, one thread, per instruction set, on the three
//! synthetic streams.

mod cpu_time;

use std::hint::black_box;
use std::time::Duration;

use cachesim::synthetic::{Stream, lines};
use cachesim::{
    Aet, Bytes, Hierarchy, Isa, LevelConfig, Levels, LineId, LineSize, PathId, Policy, StackDistances, Ways,
};
use cpu_time::CpuTime;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const STREAMS: [(&str, Stream); 3] = [("bvh", Stream::Bvh), ("rnd", Stream::Rnd), ("seq", Stream::Seq)];
const COUNT: usize = 24_000_000;
const SHORT: usize = 4_000_000;

fn hierarchy(sizes: &[(u64, u32)]) -> (Hierarchy, PathId) {
    let line = LineSize::new(64).expect("64 is a power of two");
    let level = |&(kib, ways): &(u64, u32)| {
        LevelConfig::new(&format!("{kib} KiB"), Bytes(kib << 10), line, Ways::Count(ways), Policy::Lru)
    };
    let levels = Levels::new(sizes.iter().map(level).collect()).expect("a plain hierarchy");
    Hierarchy::chain(&levels).expect("a plain hierarchy")
}

/// A 16 KiB 4-way LRU cache before a 1 MiB 16-way one, a whole stream at once.
fn two_levels(criterion: &mut Criterion<CpuTime>) {
    let mut group = criterion.benchmark_group("two levels");
    group.throughput(Throughput::Elements(COUNT as u64));
    for (name, stream) in STREAMS {
        let trace = lines(stream, COUNT);
        for isa in Isa::available() {
            let (hierarchy, path) = hierarchy(&[(16, 4), (1024, 16)]);
            let mut hierarchy = hierarchy.on(isa);
            group.bench_function(format!("{name}/{isa}"), |bencher| {
                bencher.iter(|| {
                    hierarchy.reset();
                    hierarchy.read(path, 0, black_box(&trace))
                });
            });
        }
    }
    group.finish();
}

/// The same in runs of four lines, as the instructions of a warp come, on one 128 KiB 16-way level.
fn runs_of_four(criterion: &mut Criterion<CpuTime>) {
    let mut group = criterion.benchmark_group("runs of four");
    group.throughput(Throughput::Elements(SHORT as u64));
    for (name, stream) in STREAMS {
        let trace = lines(stream, SHORT);
        for isa in Isa::available() {
            let (hierarchy, path) = hierarchy(&[(128, 16)]);
            let mut hierarchy = hierarchy.on(isa);
            group.bench_function(format!("{name}/{isa}"), |bencher| {
                bencher.iter(|| {
                    hierarchy.reset();
                    let runs = black_box(&trace).chunks_exact(4);
                    runs.map(|run| hierarchy.read(path, 0, run).levels[0].misses).sum::<u64>()
                });
            });
        }
    }
    group.finish();
}

/// Misses of all sizes at once: exact from stack distances, and by average eviction times.
fn miss_curves(criterion: &mut Criterion<CpuTime>) {
    let mut group = criterion.benchmark_group("miss curves");
    group.throughput(Throughput::Elements(COUNT as u64));
    for (name, stream) in STREAMS {
        let trace: Vec<LineId> = lines(stream, COUNT);
        group.bench_function(format!("{name}/exact"), |bencher| {
            bencher.iter(|| {
                let mut distances = StackDistances::new();
                black_box(&trace).iter().for_each(|&line| distances.touch(line));
                distances.curve()
            });
        });
        group.bench_function(format!("{name}/aet"), |bencher| {
            bencher.iter(|| {
                let mut aet = Aet::new();
                aet.extend(black_box(&trace).iter().copied());
                aet.curve()
            });
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .with_measurement(CpuTime)
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(2));
    targets = two_levels, runs_of_four, miss_curves
}
criterion_main!(benches);
