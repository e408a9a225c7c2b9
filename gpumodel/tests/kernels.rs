//! Do kernels whose time is known in closed form take that time?

use gpumodel::kernel::{Kernel, KernelTurn, LaneAccess, Pattern, Route, run_kernel};
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

/// One lane follows pointers around a ring of lines.
struct Ring {
    route: Route,
    lines: u32,
    loads: u32,
}

impl Kernel for Ring {
    fn warps(&self) -> u32 {
        1
    }

    fn registers(&self) -> u32 {
        1
    }

    fn turn(&self, _: u32, turn: u32, out: &mut KernelTurn) -> bool {
        let addresses = vec![u64::from(turn % self.lines) * 64];
        out.accesses.push(LaneAccess { route: self.route, write: false, bytes: 4, per_lane: 1, addresses });
        turn < self.loads
    }
}

/// Seconds of each load of a ring of lines that no cache before `place` of the path ever holds.
fn chain_seconds(gpu: &Gpu, route: Route, place: usize, fidelity: Fidelity) -> f64 {
    // Twice what the caches before it hold all together.
    let before: u64 = path(gpu, route)[..place].iter().map(|&level| size(gpu, level)).sum();
    let lines = (2 * before).max(1024).div_ceil(64) as u32;
    let rounds = 4096_u32.div_ceil(lines).max(2);
    let seconds = |rounds: u32| {
        run_kernel(&Ring { route, lines, loads: rounds * lines }, gpu, fidelity).unwrap().seconds
    };
    (seconds(2 * rounds) - seconds(rounds)) / f64::from(rounds * lines)
}

fn path(gpu: &Gpu, route: Route) -> &[usize] {
    match route {
        Route::Buffer => &gpu.paths.ssbo,
        Route::Texture => &gpu.paths.texture,
    }
}

const CHAINS: [&str; 4] = ["adreno-540", "adreno-640", "mali-g78", "mali-g57"];

#[test]
fn a_dependent_chain_has_the_latency_of_the_level_that_holds_it() {
    for name in CHAINS {
        let gpu = gpu(name);
        for route in [Route::Buffer, Route::Texture] {
            let path = path(&gpu, route);
            for place in 0..=path.len() {
                let expected = gpu.latency_cycles(path, place) / gpu.clock.hz;
                for fidelity in Fidelity::ALL {
                    if place == path.len() && fidelity == Fidelity::Timed {
                        // Memory has rows and refresh.
                        continue;
                    }
                    let found = chain_seconds(&gpu, route, place, fidelity);
                    let what = format!("{name} {route:?} place {place} {}", fidelity.name());
                    assert_within(1.0, found, expected, &what);
                }
            }
        }
    }
}

/// Seconds of each load of a ring of lines in order that only memory holds, where a load of a shut row takes `shut`.
///
/// The ring comes back to a bank later than refresh does, so rows are shut when it gets to them. Later lines of a row
/// find it open, and need no activate, unless its bank was refreshed since the line before: once per tREFI, at any time.
/// Whoever comes during a refresh waits for its end: tRFC and, where the row was open, the precharge before it.
fn chain_to_memory_seconds(gpu: &Gpu, shut: f64) -> f64 {
    let config = gpu.dram.simulated();
    let timings = config.timings().unwrap();
    let seconds = |ps: u64| ps as f64 * 1e-12;
    let (refi, rcd) = (seconds(timings.refi), seconds(timings.rcd));
    let refresh = seconds(timings.rp + timings.rfc);
    let wait = refresh * refresh / (2.0 * refi);
    // The lines of a block of a channel share a row where there is one bank group, and have one each where there are four.
    let block = (config.standard.channel_bytes() / 64) as f64;
    let round = block * f64::from(config.channels);
    let one_group = config.standard.banks_and_groups().1 == 1;
    let later_lines = 1.0 - 64.0 / config.standard.row_bytes() as f64;
    let mut load = shut;
    for _ in 0..20 {
        let still_open = |loads: f64| 1.0 - (loads * load / refi).min(1.0);
        let hits = if one_group {
            ((block - 1.0) * still_open(1.0) + still_open(round - block + 1.0)) / block
        } else {
            still_open(round)
        };
        load = shut + wait - rcd * hits * later_lines;
    }
    load
}

#[test]
fn a_chain_to_memory_meets_open_rows_and_refreshes_as_often_as_the_formula_says() {
    for name in CHAINS {
        for route in [Route::Buffer, Route::Texture] {
            // A chain may keep step with refresh and meet it always or never; chains of several latencies do not all.
            let latencies = (0..5).map(|step| 0.9 + 0.04 * f64::from(step));
            let ratios = latencies.map(|factor| {
                let mut gpu = gpu(name);
                gpu.dram.latency_seconds *= factor;
                let path = path(&gpu, route);
                let shut = gpu.latency_cycles(path, path.len()) / gpu.clock.hz;
                let found = chain_seconds(&gpu, route, path.len(), Fidelity::Timed);
                found / chain_to_memory_seconds(&gpu, shut)
            });
            let mean = ratios.sum::<f64>() / 5.0;
            assert_within(1.0, mean, 1.0, &format!("{name} {route:?}"));
        }
    }
}

/// A kernel of equal turns.
struct Plain {
    warps: u32,
    registers: u32,
    turns: u32,
    turn: KernelTurn,
}

impl Kernel for Plain {
    fn warps(&self) -> u32 {
        self.warps
    }

    fn registers(&self) -> u32 {
        self.registers
    }

    fn turn(&self, _: u32, turn: u32, out: &mut KernelTurn) -> bool {
        out.clone_from(&self.turn);
        turn < self.turns
    }
}

#[test]
fn a_kernel_of_arithmetic_takes_its_operations_by_the_lanes_on_every_gpu() {
    for preset in GPUS {
        let gpu = gpu(preset.name);
        let warps = gpu.cores.count * gpu.cores.warp_slots * 2;
        for (alu, efu) in [(1000, 0), (0, 1000), (1000, 50)] {
            let kernel = Plain {
                warps,
                registers: 1,
                turns: 8,
                turn: KernelTurn { alu, efu, ..KernelTurn::default() },
            };
            let per_core = f64::from(warps * 8 * gpu.cores.warp_width) / f64::from(gpu.cores.count);
            let rates = [(alu, gpu.cores.alu_lanes), (efu, gpu.cores.efu_lanes)];
            let cycles = rates.map(|(amount, lanes)| per_core * f64::from(amount) / lanes);
            let expected = cycles[0].max(cycles[1]) / gpu.clock.hz;
            for fidelity in Fidelity::ALL {
                let found = run_kernel(&kernel, &gpu, fidelity).unwrap().seconds;
                // The first warp computes before any asks for a function, the last one after.
                let percent = if efu == 50 { 2.0 } else { 1.0 };
                assert_within(
                    percent,
                    found,
                    expected,
                    &format!("{} {alu} {efu} {}", preset.name, fidelity.name()),
                );
            }
        }
    }
}

#[test]
fn streaming_through_a_cache_reaches_its_bandwidth_or_that_of_the_texture_unit() {
    // Where no level before allows less.
    for (name, route, footprint, level) in [
        ("adreno-640", Route::Buffer, 65536, "uche"),
        ("adreno-630", Route::Buffer, 65536, "uche"),
        ("adreno-630", Route::Texture, 1024, "tp_l1"),
        ("mali-g78", Route::Texture, 4096, "tex_l1"),
    ] {
        let gpu = gpu(name);
        let cache = gpu.caches.iter().find(|cache| cache.name == level).unwrap();
        // Turns of four loads each, in whole cycles.
        let samples = f64::from(4 * gpu.cores.warp_width);
        let of_unit = match route {
            Route::Texture => 16.0 * samples / (samples / gpu.texture.samples_per_clock).ceil(),
            Route::Buffer => f64::INFINITY,
        };
        let expected = cache.bytes_per_clock.min(of_unit) * f64::from(cache.copies) * gpu.clock.hz;
        let stream = Pattern::Stream { route, footprint, element: 16, copies: false };
        for fidelity in Fidelity::ALL {
            let found = stream.observe(&gpu, fidelity).unwrap().bytes_per_second();
            assert_within(1.0, found, expected, &format!("{name} {level} {}", fidelity.name()));
        }
    }
}

/// All resident warps together read one line after the other.
struct InOrder {
    warps: u32,
    resident: u32,
    width: u32,
    turns: u32,
}

impl Kernel for InOrder {
    fn warps(&self) -> u32 {
        self.warps
    }

    fn registers(&self) -> u32 {
        1
    }

    fn turn(&self, warp: u32, turn: u32, out: &mut KernelTurn) -> bool {
        let (group, place) = (warp / self.resident, warp % self.resident);
        let row = u64::from((group * self.turns + turn) * self.resident + place);
        let addresses =
            (0..self.width).map(|lane| 16 * (row * u64::from(self.width) + u64::from(lane))).collect();
        out.accesses.push(LaneAccess {
            route: Route::Buffer,
            write: false,
            bytes: 16,
            per_lane: 1,
            addresses,
        });
        turn < self.turns
    }
}

#[test]
fn reads_in_order_reach_the_peak_of_memory_times_its_efficiency() {
    for name in ["adreno-540", "adreno-640", "mali-g57", "mali-g78"] {
        let gpu = gpu(name);
        let resident = gpu.cores.count * gpu.cores.warp_slots;
        let run = |groups: u32, fidelity| {
            let kernel =
                InOrder { warps: groups * resident, resident, width: gpu.cores.warp_width, turns: 8 };
            let result = run_kernel(&kernel, &gpu, fidelity).unwrap();
            (result.traffic.dram_read_bytes as f64, result.seconds)
        };
        let expected = gpu.dram.peak_bytes_per_second * gpu.dram.efficiency;
        for fidelity in Fidelity::ALL {
            let (short, long) = (run(4, fidelity), run(12, fidelity));
            let found = (long.0 - short.0) / (long.1 - short.1);
            assert_within(1.0, found, expected, &format!("{name} {}", fidelity.name()));
        }
    }
}

#[test]
fn occupancy_steps_where_the_register_formula_says() {
    // 48 vec4 registers shared out to pairs of warps, 16 slots; 512 to single warps in portions of 8 or 16, 64 slots.
    for (name, steps) in [
        (
            "adreno-540",
            &[(1, 16), (6, 16), (7, 12), (8, 12), (9, 10), (12, 8), (13, 6), (24, 4), (25, 2), (48, 2)][..],
        ),
        ("mali-g78", &[(1, 64), (8, 64), (9, 32), (16, 32), (17, 32)][..]),
    ] {
        let gpu = gpu(name);
        let latency = gpu.latency_cycles(&gpu.paths.ssbo, 0) / gpu.clock.hz;
        let access =
            LaneAccess { route: Route::Buffer, write: false, bytes: 4, per_lane: 1, addresses: vec![0] };
        let turn = KernelTurn { accesses: vec![access], ..KernelTurn::default() };
        for &(registers, resident) in steps {
            let warps = 4 * 16 * 12 * gpu.cores.count;
            let kernel = Plain { warps, registers, turns: 200, turn: turn.clone() };
            for fidelity in Fidelity::ALL {
                let result = run_kernel(&kernel, &gpu, fidelity).unwrap();
                let what = format!("{name} with {registers} registers, {}", fidelity.name());
                assert_eq!(result.resident_warps, resident, "{what}");
                if fidelity == Fidelity::Timed {
                    // Little's law, where the port is not the limit.
                    let rounds = f64::from(warps / gpu.cores.count).ceil() / f64::from(resident) * 200.0;
                    let port = f64::from(warps / gpu.cores.count) * 200.0 / gpu.clock.hz;
                    if port < 0.2 * rounds * latency {
                        assert_within(3.0, result.seconds, rounds * latency, &what);
                    }
                }
            }
        }
        let kernel = Plain { warps: 1, registers: 49, turns: 1, turn };
        assert_eq!(run_kernel(&kernel, &gpu, Fidelity::Timed).is_err(), name == "adreno-540");
    }
}

#[test]
fn kernels_that_ask_for_what_there_is_not_are_refused() {
    let gpu = gpu("adreno-540");
    let refusal = |bytes, lanes: u64| {
        let access = LaneAccess {
            route: Route::Buffer,
            write: false,
            bytes,
            per_lane: 1,
            addresses: (0..lanes).map(|lane| lane * 16).collect(),
        };
        let turn = KernelTurn { accesses: vec![access], ..KernelTurn::default() };
        run_kernel(&Plain { warps: 1, registers: 1, turns: 1, turn }, &gpu, Fidelity::Timed).map(|_| ())
    };
    assert!(refusal(16, 32).is_ok());
    for (bytes, lanes, expected) in
        [(17, 32, "17 bytes"), (0, 32, "0 bytes"), (16, 33, "33 lanes"), (16, 0, "0 lanes")]
    {
        let message = refusal(bytes, lanes).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

fn size(gpu: &Gpu, level: usize) -> u64 {
    gpu.levels().as_slice()[level].size.0
}

/// Each warp reads one word of a page that no other reads.
struct NewPages {
    warps: u32,
    page_bytes: u64,
}

impl Kernel for NewPages {
    fn warps(&self) -> u32 {
        self.warps
    }

    fn registers(&self) -> u32 {
        1
    }

    fn turn(&self, warp: u32, turn: u32, out: &mut KernelTurn) -> bool {
        out.accesses.push(word(u64::from(warp) * self.page_bytes));
        turn == 0
    }
}

/// One lane reads a word.
fn word(address: u64) -> LaneAccess {
    LaneAccess { route: Route::Buffer, write: false, bytes: 4, per_lane: 1, addresses: vec![address] }
}

#[test]
fn reads_of_new_pages_take_the_time_of_their_walks_and_lines_one_after_the_other() {
    let gpu = gpu("adreno-660");
    let translation = gpu.translation.expect("it has figures");
    let kernel = NewPages { warps: 20_000, page_bytes: translation.tlb.page_bytes };
    let line = 64.0 / (gpu.dram.peak_bytes_per_second * gpu.dram.efficiency);
    let expected = f64::from(kernel.warps) * (translation.walk_seconds + line);
    for fidelity in Fidelity::ALL {
        let found = run_kernel(&kernel, &gpu, fidelity).unwrap().seconds;
        assert_within(1.0, found, expected, fidelity.name());
    }
}

/// One warp loads a line twice, then another line, and waits for all.
struct Again;

impl Kernel for Again {
    fn warps(&self) -> u32 {
        1
    }

    fn registers(&self) -> u32 {
        1
    }

    fn turn(&self, _: u32, turn: u32, out: &mut KernelTurn) -> bool {
        out.accesses.extend([0, 0, 1].map(|line| word(line * 64)));
        turn < 1
    }
}

#[test]
fn a_load_that_joins_a_line_on_its_way_to_its_core_takes_no_place_in_flight() {
    let seconds = |places: u32| {
        let text = GPUS.iter().find(|preset| preset.name == "mali-g78").unwrap().toml;
        let line = "lines_in_flight = { value = 16";
        assert!(text.contains(line));
        let gpu = Gpu::parse(&text.replace(line, &format!("lines_in_flight = {{ value = {places}")), "g78")
            .unwrap();
        run_kernel(&Again, &gpu, Fidelity::Timed).unwrap().seconds
    };
    let (one, two, three) = (seconds(1), seconds(2), seconds(3));
    assert_within(1e-9, two, three, "two lines fill two places, whoever waits for them");
    // Little more than one latency, or two: both lines come from memory, the second from the row that the first opened.
    assert!(one > 1.5 * two, "one place for two lines: {one:e}, two places: {two:e}");
}
