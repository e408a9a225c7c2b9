//! Time of a phase under contention.
//!
//! The warps of a core are customers of a closed queueing network; one cycle is a warp's turn: it computes, issues its loads
//! and stores, and waits for the last of its lines. Caches and memory that cores share are stations that as many like networks
//! visit. What a turn asks of the ALU, the elementary function unit and the load/store unit is the phase's mean; what it asks
//! of caches and memory, and how many warps are resident, is the mean of its [`Window`], and the time of the phase is the sum
//! over its windows. So cold caches, cores that run dry and the tail of the last warps are in it.

use super::bounds::Demand;
use super::in_flight::InFlight;
use super::time::{PhaseTime, StackPart, add};
use crate::config::{CacheRole, Gpu};
use crate::counters::{PassCounters, WaitCounters};
use crate::error::Error;
use crate::queueing::{Network, NetworkError, Part, Solution, Station, solve};
use crate::timed::servers;
use crate::windows::Window;
use cachesim::MAX_LEVELS;

/// Places of the load/store port and of the ray unit's own among the stations.
const LOAD_STORE_PORT: usize = 2;
const UNIT_PORT: usize = 3;
/// How well the time that the port is held up is known, as a part of the time that it works.
const HOLD_TOLERANCE: f64 = 1e-6;
/// Time beyond the last cache, and the wait for a place to spend it in.
const MSHRS: &str = "memory latency";
/// Time that nothing but the distance causes.
pub(super) const LATENCY: &str = "latency";

/// A phase: what its passes count together, what they need of each resource, and the way of its loads through the caches.
pub(super) struct InPhase<'a> {
    pub(super) counters: &'a PassCounters,
    pub(super) demand: &'a Demand,
    pub(super) path: &'a [usize],
    pub(super) gpu: &'a Gpu,
}

impl InPhase<'_> {
    /// Adds time under contention to the time of the phase.
    ///
    /// # Errors
    /// When what a window asks for is beyond what can be computed with.
    pub(super) fn contended(&self, windows: &[Window], mut time: PhaseTime) -> Result<PhaseTime, Error> {
        for window in windows {
            let solution = self.solve(window).map_err(|refused| Error::Network {
                gpu: self.gpu.name().to_owned(),
                problem: refused.to_string(),
            })?;
            let cores = window.turns as f64 / window.ticks as f64;
            let seconds = window.turns as f64 / (solution.throughput * cores);
            time.seconds += seconds;
            time.residual = time.residual.max(solution.residual);
            add_stack(&mut time.stack, seconds, &solution);
        }
        Ok(time)
    }

    /// The network of a window in which the port of a core's path is held up by lines that wait for a free place in flight.
    ///
    /// The longer the port is held, the lower the throughput, and the less it would be held: so there is one time for which
    /// both agree. It is bracketed and halved.
    fn solve(&self, window: &Window) -> Result<Solution, NetworkError> {
        let (mut network, in_flight) = self.network(window);
        let port = if self.gpu.through_unit_port(self.path) { UNIT_PORT } else { LOAD_STORE_PORT };
        let free = network.stations[port].demand;
        let mut solution = solve(&network)?;
        if in_flight.hold(solution.throughput, free, 0.0) <= HOLD_TOLERANCE * free {
            return Ok(solution);
        }
        let (mut low, mut high) = (0.0, in_flight.longest_hold());
        while high - low > HOLD_TOLERANCE * (free + low) {
            let held = low.midpoint(high);
            network.stations[port].demand = free + held;
            solution = solve(&network)?;
            if in_flight.hold(solution.throughput, free, held) > held {
                low = held;
            } else {
                high = held;
            }
        }
        Ok(solution)
    }

    /// The network of one core during a window, and the lines that it has in flight; times are of one turn.
    fn network(&self, window: &Window) -> (Network, InFlight) {
        let Self { counters: PassCounters { issue, .. }, demand, path, gpu } = self;
        let turns = issue.turns.max(1) as f64;
        let window_turns = window.turns as f64;
        let cores = window_turns / window.ticks as f64;
        let of_all_cores = f64::from(gpu.cores.count) / turns;
        let servers = servers(gpu);
        let single = |name, demand| Station { variability: 0.0, ..Station::single(name, demand) };
        let alu = demand.alu * of_all_cores * f64::from(servers);
        // Lanes beyond those of whole warps take more instructions, and none of them sooner than in a cycle.
        let warps_in_lanes = gpu.cores.alu_lanes / f64::from(gpu.cores.warp_width);
        let result = alu * (warps_in_lanes / f64::from(servers) - 1.0).max(0.0);
        let sharers = cores.round().max(1.0) as u32;
        let mut stations = vec![
            Station { servers, ..single("ALU issue", alu) },
            single("EFU issue", demand.efu * of_all_cores),
            single("load/store port", demand.load_store * of_all_cores),
            single("ray unit: port", demand.unit_port * of_all_cores),
            single("ray unit: boxes", demand.unit_boxes * of_all_cores),
            single("ray unit: triangles", demand.unit_triangles * of_all_cores),
            Station { sharers, ..single("atomics", demand.atomics / turns) },
            Station { sharers, ..single("triangle setup", demand.setup / turns) },
            Station { sharers, ..single("pixel rate", demand.pixels / turns) },
        ];

        let waits = issue.memory_waits as f64 / turns * window_turns;
        let per_wait = |lines: f64| (lines / waits.max(1.0)).max(1.0);
        let repeats = (issue.line_accesses as f64 / issue.line_requests.max(1) as f64).max(1.0);
        let lines = path.first().map_or(0.0, |&first| window.levels[first].accesses as f64 / repeats);
        // Seconds that the port, the banks and the way to memory are busy with one line: its latency includes them.
        let mut of_a_line = (demand.load_store + demand.unit_port) * f64::from(gpu.cores.count)
            / issue.line_accesses.max(1) as f64;
        for (level, (cache, served)) in gpu.caches.iter().zip(window.levels).enumerate() {
            // The port of a ray unit is that of its own cache, and has been asked already.
            if path.first() == Some(&level) && gpu.through_unit_port(path) {
                continue;
            }
            let accesses = served.accesses as f64;
            let line_seconds =
                cache.line_bytes as f64 * f64::from(cache.banks) / (cache.bytes_per_clock * gpu.clock.hz);
            let cores_per_copy = (gpu.cores.count / cache.copies.max(1)).max(1);
            of_a_line += line_seconds * (accesses / lines.max(1.0) / repeats).min(1.0);
            stations.push(Station {
                servers: cache.banks,
                burst: per_wait(accesses),
                sharers: sharers.min(cores_per_copy),
                ..single(cache_name(cache.role), line_seconds * accesses / window_turns)
            });
        }
        let bandwidth = gpu.dram.peak_bytes_per_second * gpu.dram.efficiency;
        let past_caches = issue.output_bytes + issue.bin_list_bytes + issue.dma_write_bytes;
        let direct = past_caches as f64 / turns;
        let memory_bytes = window.memory_bytes as f64;
        let line = path.last().map_or(1.0, |&last| gpu.caches[last].line_bytes as f64);
        of_a_line += line / bandwidth * (memory_bytes / line / lines.max(1.0)).min(1.0);
        // A page walk holds up what comes behind it on the way to memory.
        let (name, walk_seconds) = match gpu.translation {
            Some(translation) => ("DRAM and page walks", translation.walk_seconds),
            None => ("DRAM", 0.0),
        };
        let walks = walk_seconds * window.page_walks as f64 / window_turns;
        stations.push(Station {
            sharers,
            burst: per_wait(memory_bytes / line),
            ..single(name, (memory_bytes / window_turns + direct) / bandwidth + walks)
        });

        // A line is on its way for the latency of the place that it comes from; a turn waits for the farthest of its lines.
        let Waits { line_cycles, mut turn_cycles, from_memory } = self.waits(window, lines);
        // The part of it beyond the last cache is spent in an MSHR of that cache.
        if let Some(&last) = path.last() {
            let cache = &gpu.caches[last];
            let beyond = gpu.latency_cycles(path, path.len()) - gpu.latency_cycles(path, path.len() - 1);
            let misses = window.levels[last].misses as f64;
            if from_memory > 0.0 && misses > 0.0 {
                turn_cycles -= from_memory * beyond;
                stations.push(Station {
                    servers: cache.mshrs,
                    burst: (misses / (from_memory * waits)).max(1.0),
                    sharers: sharers.min((gpu.cores.count / cache.copies.max(1)).max(1)),
                    ..single(MSHRS, misses * beyond / gpu.clock.hz / window_turns)
                });
            }
        }
        let latency = (turn_cycles / gpu.clock.hz - of_a_line).max(0.0);
        let network = Network {
            customers: (window.warp_ticks as f64 / window_turns).max(1.0),
            think_time: latency * waits / window_turns + result + self.away_seconds(),
            stations,
        };
        (network, self.in_flight(window, lines, line_cycles))
    }

    /// Seconds of a turn that a warp is on its way from the ray unit to its shader and back.
    fn away_seconds(&self) -> f64 {
        let Self { counters: PassCounters { issue, .. }, gpu, .. } = self;
        let cycles = gpu.ray_unit.as_ref().and_then(|unit| unit.return_cycles).unwrap_or(0.0);
        cycles * issue.unit_returns as f64 / issue.turns.max(1) as f64 / gpu.clock.hz
    }

    /// Lines that a core's own cache has are not on their way to it.
    fn in_flight(&self, window: &Window, lines: f64, line_cycles: f64) -> InFlight {
        let Self { path, gpu, .. } = self;
        let mut places = f64::from(gpu.lines_in_flight(path));
        let (mut on_way, mut latency) = (lines, line_cycles);
        let own = path.first().filter(|&&first| gpu.caches[first].copies == gpu.cores.count);
        if let Some(&first) = own {
            places = places.min(f64::from(gpu.caches[first].mshrs));
            on_way = (window.levels[first].misses as f64).min(lines);
            let near = gpu.latency_cycles(path, 0);
            latency = near + (line_cycles - near) * lines / on_way.max(1.0);
        }
        // The part of the lines that is on its way for longer than each latency.
        let (mut longer, mut squares, mut since) = (1.0, 0.0, 0.0);
        for place in usize::from(own.is_some())..=path.len() {
            let cycles = gpu.latency_cycles(path, place);
            squares += longer * longer * (cycles - since);
            since = cycles;
            let misses = path.get(place).map_or(0.0, |&level| window.levels[level].misses as f64);
            longer = (misses / on_way.max(1.0)).min(longer);
        }
        let WaitCounters { turns, lines: sampled, squares: sampled_squares, .. } = window.waits;
        let scattered = sampled_squares as f64 * turns as f64 / (sampled as f64 * sampled as f64) - 1.0;
        let lines = on_way / window.turns as f64;
        InFlight {
            places,
            lines,
            // Of single lines, where none was seen.
            variability: if sampled > 0 { scattered } else { 1.0 / lines.max(1.0) },
            latency: latency / gpu.clock.hz,
            evenness: if latency > 0.0 { squares / latency } else { 1.0 },
        }
    }

    /// With nothing else on the way.
    fn waits(&self, window: &Window, lines: f64) -> Waits {
        let Self { path, gpu, .. } = self;
        let mut line_cycles = 0.0;
        let mut arriving = 1.0;
        for place in 0..=path.len() {
            let cycles = gpu.latency_cycles(path, place);
            let passing =
                path.get(place).map_or(0.0, |&level| window.levels[level].misses as f64 / lines.max(1.0));
            let passing = passing.min(arriving);
            line_cycles += (arriving - passing) * cycles;
            arriving = passing;
        }
        let sampled: u64 = window.waits.from.iter().sum();
        if sampled == 0 {
            return Waits { line_cycles, turn_cycles: line_cycles, from_memory: 0.0 };
        }
        let of = |(level, &turns): (usize, &u64)| {
            let on_path = path.iter().position(|&on_path| on_path == level);
            let place = if level == MAX_LEVELS { path.len() } else { on_path.unwrap_or(0) };
            turns as f64 * gpu.latency_cycles(path, place)
        };
        let turn_cycles = window.waits.from.iter().enumerate().map(of).sum::<f64>() / sampled as f64;
        let from_memory = window.waits.from[MAX_LEVELS] as f64 / sampled as f64;
        Waits { line_cycles, turn_cycles, from_memory }
    }
}

/// How far away the data of a window are.
struct Waits {
    /// Mean cycles that a line is on its way.
    line_cycles: f64,
    /// Cycles that a turn waits.
    turn_cycles: f64,
    /// Share of turns that wait for memory.
    from_memory: f64,
}

fn cache_name(role: CacheRole) -> &'static str {
    match role {
        CacheRole::L1 => "L1",
        CacheRole::Cluster => "cluster cache",
        CacheRole::L2 => "L2",
        CacheRole::Slc => "SLC",
    }
}

fn add_stack(stack: &mut Vec<StackPart>, seconds: f64, solution: &Solution) {
    for share in solution.stack() {
        let name = match share.part {
            Part::Think => LATENCY,
            Part::Service(place) | Part::Queueing(place) => solution.stations[place].name,
        };
        add(stack, name, seconds * share.seconds / solution.cycle_time);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counters::IssueCounters;
    use crate::mock::gpu;

    #[test]
    fn a_window_that_has_no_solution_is_an_error_that_names_the_gpu_and_the_figure() {
        let gpu = gpu(&[]);
        let issue = IssueCounters { turns: 1, alu_issued: 100, ..IssueCounters::default() };
        let counters = PassCounters { issue, ..PassCounters::default() };
        let demand = Demand::of(crate::counters::Pass::Primary, &counters, 1, &gpu);
        let phase = InPhase { counters: &counters, demand: &demand, path: &gpu.paths.ssbo, gpu: &gpu };
        let seconds = |warps: u64| {
            let window = Window { ticks: 1, turns: 1, warp_ticks: warps, ..Window::default() };
            let largest = demand.bounds(&gpu)[0];
            let time = PhaseTime { seconds: 0.0, largest, place: 0, stack: Vec::new(), residual: 0.0 };
            phase.contended(&[window], time).map(|time| time.seconds).map_err(|error| error.to_string())
        };
        let most = Network::MOST_CUSTOMERS as u64;
        assert!(seconds(most).is_ok_and(|seconds| seconds > 0.0));
        let refused = seconds(2 * most).unwrap_err();
        assert!(refused.contains("adreno-540: customers = 2000000000000000"), "{refused}");
    }
}
