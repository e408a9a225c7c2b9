//! Does the energy of a frame close, scale as its supplies do, and come back by hand?

use super::{Domain, EnergyPrices, FrameEnergy, PassEnergy, Supply};
use crate::config::{EnergyTable, Gpu};
use crate::counters::{Pass, Value};
use crate::estimate::{Estimate, estimate};
use crate::mock::{MockRay, Recorded, config, gpu};
use crate::replay::{Fidelity, Maps, ReplayConfig, Replayed, replay};
use tracer::{Accel, NO_HIT, Op};

const MILLISECOND: [f64; Pass::COUNT] = {
    let mut seconds = [0.0; Pass::COUNT];
    seconds[Pass::Primary as usize] = 1e-3;
    seconds
};

fn source() -> Recorded {
    let rays: Vec<MockRay> = (0..640)
        .map(|ray| {
            let hit = if ray % 3 == 0 { NO_HIT } else { ray % 64 };
            (vec![(Op::Node, ray % 127), (Op::Primitive, ray % 64)], hit)
        })
        .collect();
    Recorded::list(Accel::Bvh, "stack", 64, &rays)
}

fn replayed(config: &ReplayConfig) -> Replayed {
    replay(&source(), config, Maps::Dropped, &|_, _| {}).expect("the mock is valid")
}

fn estimated(config: &ReplayConfig) -> Estimate {
    let source = source();
    estimate(&replayed(config), &source.header, &source.topology, config).expect("solvable")
}

fn of_frame(config: &ReplayConfig) -> FrameEnergy {
    estimated(config).energy.expect("the GPU has a process")
}

fn prices(gpu: &Gpu) -> EnergyPrices {
    let table = EnergyTable::builtin().expect("it is sound");
    EnergyPrices::new(&table, gpu).expect("the table knows it").expect("it has a process")
}

fn builtin(name: &str) -> Gpu {
    Gpu::builtin(name).expect("built in").expect("sound")
}

fn close(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-12 * expected.abs(), "{value}, expected {expected}");
}

#[test]
fn causes_passes_and_supplies_add_up_to_the_frame() {
    for fidelity in Fidelity::ALL {
        let config = ReplayConfig { fidelity, ..config(gpu(&[])) };
        let estimate = estimated(&config);
        let energy = estimate.energy.as_ref().expect("the GPU has a process");
        let number = |value: Option<&Value>| value.and_then(Value::number).expect("it is there");
        let frame = number(estimate.frame.get("energy_mj")) * 1e-3;
        assert!(frame > 0.0);
        close(energy.causes.iter().map(|cause| cause.joules).sum(), frame);
        let of_passes = estimate.passes.iter().map(|pass| number(pass.counters.get("energy_mj")) * 1e-3);
        close(of_passes.sum(), frame);
        let domains = [Domain::Gpu, Domain::SystemCache, Domain::Dram, Domain::Leakage];
        close(domains.map(|domain| energy.of_domain(domain)).iter().sum(), frame);
        close(number(estimate.frame.get("dram_energy_share")) * frame, energy.of_domain(Domain::Dram));
        let seconds = number(estimate.frame.get("frame_time_ms")) * 1e-3;
        close(number(estimate.frame.get("power_mw")) * 1e-3 * seconds, frame);
        close(number(estimate.frame.get("energy_nj_per_ray")) * 1e-9 * 640.0, frame);
    }
}

#[test]
fn twice_the_clock_and_bandwidth_halve_what_time_takes_and_leave_what_events_take() {
    let twice = [
        ("mhz = { value = 710", "mhz = { value = 1420"),
        ("peak_gbs = { value = 29.8", "peak_gbs = { value = 59.6"),
        ("latency_ns = { value = 300", "latency_ns = { value = 150"),
    ];
    let slow = of_frame(&config(gpu(&[])));
    let fast = of_frame(&config(gpu(&twice)));
    assert_eq!(slow.causes.len(), fast.causes.len());
    for (slow, fast) in slow.causes.iter().zip(&fast.causes) {
        assert_eq!(slow.cause, fast.cause);
        let of_time = slow.domain == Domain::Leakage || slow.cause.ends_with("refresh and idle");
        let factor = if of_time { 0.5 } else { 1.0 };
        // The times of two solved networks are alike up to what their solver leaves.
        let tolerance = if of_time { 1e-6 } else { 1e-12 } * slow.joules;
        assert!((fast.joules - factor * slow.joules).abs() <= tolerance, "{slow:?} {fast:?}");
    }
}

#[test]
fn a_root_law_makes_traffic_in_half_the_time_cheaper_by_the_root_of_two() {
    let lpddr5 = [("standard = { value = \"lpddr4x\"", "standard = { value = \"lpddr5\"")];
    let gpu = gpu(&lpddr5);
    let mut replayed = Replayed { ..replayed(&config(gpu.clone())) };
    replayed.timed = None;
    let traffic = |seconds: &[f64; Pass::COUNT]| {
        let energy = FrameEnergy::new(prices(&gpu), &replayed, &config(gpu.clone()), seconds);
        let of = energy.causes.iter().filter(|cause| cause.cause.ends_with("reads and writes"));
        of.map(|cause| cause.joules).sum::<f64>()
    };
    close(traffic(&MILLISECOND.map(|seconds| seconds / 2.0)), traffic(&MILLISECOND) / 2.0_f64.sqrt());
}

#[test]
fn a_frame_without_work_takes_what_leaks_and_what_idle_memory_takes() {
    let gpu = gpu(&[]);
    let mut replayed = replayed(&config(gpu.clone()));
    replayed.counters = crate::counters::FrameCounters::default();
    let energy = FrameEnergy::new(prices(&gpu), &replayed, &config(gpu.clone()), &MILLISECOND);
    let prices = prices(&gpu);
    let leakage = prices.leakage().watts(prices.supply().volts(), prices.leakage().reference_celsius());
    close(energy.of_domain(Domain::Leakage), leakage * 1e-3);
    close(energy.of_domain(Domain::Dram), prices.dram().watts(0.0) * 1e-3);
    close(energy.total().joules, (leakage + prices.dram().watts(0.0)) * 1e-3);
    let nothing = FrameEnergy::new(prices, &replayed, &config(gpu), &[0.0; Pass::COUNT]);
    assert_eq!(nothing.total(), PassEnergy::default());
}

#[test]
fn a_lower_clock_at_a_lower_voltage_takes_less_for_the_same_events() {
    let fast = gpu(&[]);
    let mut slow = fast.clone();
    slow.clock.hz = 257e6;
    let replayed = replayed(&config(fast.clone()));
    let [of_fast, of_slow] = [&fast, &slow]
        .map(|gpu| FrameEnergy::new(prices(gpu), &replayed, &config(gpu.clone()), &MILLISECOND));
    assert_eq!(of_fast.prices.supply(), Supply::OperatingPoints(0.922));
    assert_eq!(of_slow.prices.supply(), Supply::OperatingPoints(0.62));
    let ratio = |domain| of_slow.of_domain(domain) / of_fast.of_domain(domain);
    close(ratio(Domain::Gpu), (0.62_f64 / 0.922).powi(2));
    close(ratio(Domain::Leakage), (0.62_f64 / 0.922).powi(3));
    close(ratio(Domain::Dram), 1.0);
    let mut without = fast;
    without.operating_points.clear();
    assert_eq!(prices(&without).supply(), Supply::Process(0.8));
}

/// With the figures of the file written out: 10 nm at the 0.922 V of the Adreno 540 at 710 MHz, LPDDR4X, 64 bit.
#[test]
fn the_energy_of_counts_comes_back_by_hand() {
    let gpu = gpu(&[]);
    let mut replayed = replayed(&config(gpu.clone()));
    replayed.counters = crate::counters::FrameCounters::default();
    let pass = &mut replayed.counters.passes[Pass::Primary as usize];
    (pass.issue.alu_active, pass.issue.alu_issued) = (1000, 1600);
    (pass.issue.efu_active, pass.issue.efu_issued) = (100, 400);
    pass.issue.lane_bytes = 4096;
    pass.issue.output_bytes = 8000;
    pass.traffic.node.levels[1].accesses = 50;
    pass.traffic.node.levels[1].misses = 10;
    pass.traffic.node.dram_read_bytes = 640;
    let energy = FrameEnergy::new(prices(&gpu), &replayed, &config(gpu), &MILLISECOND);
    let joules = |name: &str| {
        let found = energy.causes.iter().find(|cause| cause.cause == name);
        found.unwrap_or_else(|| panic!("no cause is called {name}: {:?}", energy.causes)).joules
    };
    let by_voltage = (0.922_f64 / 0.8).powi(2);
    let of_45nm = 0.117 * 1e-12 * by_voltage;
    close(joules("ALU operations"), 1000.0 * 2.3 * of_45nm);
    close(joules("EFU operations"), 100.0 * 12.9 * of_45nm);
    close(joules("instructions, registers and clocks"), 2000.0 * 17.8e-12 * 0.117 / 0.124 * by_voltage);
    close(joules("loads and stores"), 4096.0 * 1.25 * of_45nm);
    // 128 KiB is sixteen times 8 KiB, and a line of 64 bytes eight words.
    close(joules("cache uche"), 60.0 * 8.0 * 4.0 * 10.0 * of_45nm);
    // 1 MiB, 128 times 8 KiB.
    close(joules("tile memory"), 16000.0 / 8.0 * 128.0_f64.sqrt() * 10.0 * of_45nm);
    // 8640 bytes at 90 mW per GB/s, however long it takes.
    close(joules("DRAM: reads and writes"), 8640.0 * 90e-12);
    close(joules("DRAM: refresh and idle"), 2.0 * 0.176 * 1e-3);
    let celsius: f64 = 50.0;
    let scale = (32499.0 + 20283.0 * celsius - 238.0 * celsius.powi(2) + 6.0 * celsius.powi(3)) * 1e-6;
    close(joules("leakage"), 256.0 * 1.85e-3 * 0.922_f64.powi(3) * scale * 1e-3);
    assert_eq!(energy.causes.len(), 9);
    assert_eq!(energy.dram_bytes, 8640);
}

#[test]
fn rows_beyond_those_of_a_stream_cost_an_activate_each() {
    let mut config = config(gpu(&[]));
    config.fidelity = Fidelity::Timed;
    let mut replayed = replayed(&config);
    replayed.counters = crate::counters::FrameCounters::default();
    replayed.counters.passes[Pass::Primary as usize].traffic.node.dram_read_bytes = 4096;
    let of_rows = |misses: u64, conflicts: u64, replayed: &mut Replayed| {
        let rows = &mut replayed.timed.as_mut().expect("it was simulated").dram.rows;
        (rows.hits, rows.misses, rows.conflicts) = (7, misses, conflicts);
        FrameEnergy::new(prices(&config.gpu), replayed, &config, &MILLISECOND).total().joules
    };
    // A stream opens two rows of 2048 bytes.
    let stream = of_rows(2, 0, &mut replayed);
    close(of_rows(0, 1, &mut replayed), stream);
    let more = of_rows(3, 4, &mut replayed) - stream;
    assert!((more - 5.0 * 1.37e-9).abs() <= 1e-9 * more, "{more}");
}

#[test]
fn a_rail_takes_what_was_measured_of_one_interface() {
    // Four channels of 16 bits are two interfaces of 32, which share the traffic.
    let prices = prices(&builtin("adreno-650"));
    let dram = prices.dram();
    assert_eq!(dram.interfaces(), 2.0);
    for gbs in [0.1_f64, 1.0, 5.53, 10.86, 14.1] {
        let rate = 2.0 * gbs * 1e9;
        let devices = &dram.rails()[0];
        close(devices.floor_watts() + devices.traffic_watts(rate), 2.0 * (45.7 + 160.06 * gbs.sqrt()) * 1e-3);
        let interface = &dram.rails()[1];
        close(
            interface.floor_watts() + interface.traffic_watts(rate),
            2.0 * (118.9 + 144.4 * gbs.sqrt()) * 1e-3,
        );
    }
    let linear = self::prices(&builtin("adreno-540"));
    let [low, high] = [1e9, 11e9].map(|rate| linear.dram().watts(rate));
    assert!((high - low - 0.9).abs() < 1e-12, "90 mW per GB/s");
}

#[test]
fn leakage_rises_with_temperature_and_the_cube_of_the_voltage() {
    let prices = prices(&builtin("mali-g57"));
    let leakage = prices.leakage();
    // The chip that the figures are of has as many lanes: 118.279 mW per V^3.
    close(leakage.watts(1.0, 50.0), 64.0 * 1.85e-3 * 1.201_649);
    close(leakage.watts(0.8, 50.0), leakage.watts(1.0, 50.0) * 0.512);
    let rising: Vec<f64> = (0..=100).map(|celsius| leakage.watts(0.8, f64::from(celsius))).collect();
    assert!(rising.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(leakage.watts(0.8, -1e6), 0.0);
    // The exponential law has the polynomial's figures at both ends, and stays near to it beyond them.
    assert_eq!((leakage.fitted_from_celsius(), leakage.fitted_to_celsius()), (50.0, 95.0));
    let law =
        |celsius: f64| leakage.watts(0.8, 50.0) * (leakage.growth_per_kelvin() * (celsius - 50.0)).exp();
    close(law(95.0), leakage.watts(0.8, 95.0));
    assert!(
        (40..=100).all(|celsius| (law(f64::from(celsius)) / rising[celsius as usize] - 1.0).abs() < 0.04)
    );
}

#[test]
fn a_gpu_without_a_process_has_no_energy_and_says_why() {
    let mut gpu = gpu(&[]);
    gpu.energy = None;
    let estimate = estimated(&config(gpu));
    assert!(estimate.energy.is_none());
    for id in ["energy_mj", "power_mw", "energy_nj_per_ray", "dram_energy_share"] {
        let Some(Value::Absent { reason }) = estimate.frame.get(id) else { panic!("{id} is there") };
        assert!(reason.contains("[energy]"), "{reason}");
    }
    assert!(estimate.left_out.iter().any(|entry| entry.what == "energy"));
}

#[test]
fn a_process_or_memory_that_the_table_does_not_know_is_refused_with_those_that_it_knows() {
    let other = gpu(&[("process = { value = \"10nm\"", "process = { value = \"11nm\"")]);
    let table = EnergyTable::builtin().expect("it is sound");
    let error = EnergyPrices::new(&table, &other).expect_err("it is not there").to_string();
    assert!(error.contains("energy.process: is '11nm'") && error.contains("10nm, 8nm"), "{error}");
    let text = EnergyTable::builtin_text().replace("standard = \"lpddr4x\"", "standard = \"ddr\"");
    let table = EnergyTable::parse(&text, "my-energy.toml").expect("it is sound");
    let error = EnergyPrices::new(&table, &gpu(&[])).expect_err("it is not there").to_string();
    assert!(error.contains("dram.standard: is 'lpddr4x', and my-energy.toml has"), "{error}");
}
