//! Do kernels whose time is known in closed form take that time?

use gpumodel::kernel::{Kernel, KernelTurn, LaneAccess, Pages, Pattern, Route, run_kernel};
use gpumodel::{Fidelity, GPUS, Gpu};

fn gpu(name: &str) -> Gpu {
    Gpu::builtin(name).expect("it is built in").expect("it is valid")
}

#[track_caller]
fn assert_within(percent: f64, found: f64, expected: f64, what: &str) {
    let error = found / expected - 1.0;
    assert!(
        100.0 * error.abs() <= percent,
        "{what}: {found:e}, expected {expected:e}: {:+.2} %",
        100.0 * error
    );
}

#[test]
fn a_dependent_chain_has_the_latency_of_the_level_that_holds_it() {
    for name in ["adreno-540", "adreno-640", "mali-g78", "mali-g57"] {
        let gpu = gpu(name);
        for (route, path) in [(Route::Buffer, &gpu.paths.ssbo), (Route::Texture, &gpu.paths.texture)] {
            for place in 0..=path.len() {
                // Twice what the caches before it hold all together, so that none of its lines is ever there.
                let before: u64 = path[..place].iter().map(|&level| size(&gpu, level)).sum();
                let footprint = (2 * before).max(1024);
                let chase = Pattern::Chase { route, footprint, stride: 64 };
                let expected = gpu.latency_cycles(path, place) / gpu.clock.hz;
                for fidelity in Fidelity::ALL {
                    let found = chase.observe(&gpu, fidelity).unwrap().seconds_per_load();
                    // The memory controller's refresh and closed rows are in the way of a chain of misses.
                    let what = format!("{name} {route:?} place {place} {}", fidelity.name());
                    assert_within(1.0, found, expected, &what);
                }
            }
        }
    }
}

fn size(gpu: &Gpu, level: usize) -> u64 {
    gpu.levels().as_slice()[level].size.get()
}
