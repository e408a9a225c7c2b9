//! Time of a phase under contention.
//!
//! The warps of a core are customers of a closed queueing network; one cycle is a warp's turn: it computes, issues its loads
//! and stores, and waits for the last of its lines. What a turn asks of each station is the phase's mean. The caches and the
//! memory that cores share are stations that as many like networks visit. The phase lasts, for each number of warps that were
//! resident together, as long as the turns issued meanwhile take at the throughput of that many; so the tail of the last warps
//! and cores that run dry are in it.

use super::bounds::Demand;
use crate::config::{CacheRole, Gpu};
use crate::counters::{Occupancy, PassCounters};
use crate::queueing::{Network, Part, Solution, Station, solve};

/// What the time of a phase is made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Contended {
    /// Seconds of the phase.
    pub(super) seconds: f64,
    /// Parts of it.
    pub(super) stack: Vec<StackPart>,
    /// Largest residual of a solved network.
    pub(super) residual: f64,
}

/// A part of the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StackPart {
    /// What warps wait for or use.
    pub name: &'static str,
    /// Seconds.
    pub seconds: f64,
}

const TAIL: &str = "tail";
const LATENCY: &str = "latency";
const IN_FLIGHT: &str = "lines in flight";

/// The time of a phase whose passes count `counters` together, and whose warps came and went as `occupancy` says.
pub(super) fn contended(
    counters: &PassCounters,
    demand: &Demand,
    occupancy: &[Occupancy],
    gpu: &Gpu,
) -> Contended {
    let turns = counters.issue.turns.max(1) as f64;
    let issued: u64 = occupancy.iter().map(|level| level.ticks * u64::from(level.cores)).sum();
    let mut result = Contended::default();
    let full = occupancy.iter().max_by_key(|level| (level.warps, level.cores));
    let Some(full) = full else { return result };
    let full_time = time(counters, demand, full, turns, gpu);
    for level in occupancy {
        let share = (level.ticks * u64::from(level.cores)) as f64 / issued as f64;
        let Some((seconds, solution)) = time(counters, demand, level, turns, gpu) else { continue };
        result.seconds += share * seconds;
        result.residual = result.residual.max(solution.residual);
    }
    if let Some((seconds, solution)) = full_time {
        result.stack = stack(seconds, &solution);
        result.stack.push(StackPart { name: TAIL, seconds: result.seconds - seconds });
    }
    result
}

/// Seconds that all turns would take at one level of occupancy.
fn time(
    counters: &PassCounters,
    demand: &Demand,
    level: &Occupancy,
    turns: f64,
    gpu: &Gpu,
) -> Option<(f64, Solution)> {
    let network = network(counters, demand, level, turns, gpu);
    let solution = solve(&network).ok()?;
    Some((turns / (solution.throughput * f64::from(level.cores)), solution))
}

/// The network of one core; times are of one turn.
fn network(counters: &PassCounters, demand: &Demand, level: &Occupancy, turns: f64, gpu: &Gpu) -> Network {
    let issue = &counters.issue;
    let traffic = counters.traffic.total();
    let cores = f64::from(gpu.cores.count);
    let per_turn = |seconds_of_all_cores: f64| seconds_of_all_cores * cores / turns;
    let width = f64::from(gpu.cores.warp_width);
    let servers = (gpu.cores.alu_lanes / width).floor().clamp(1.0, 1024.0);
    let own =
        |name, demand, servers, burst| Station { name, demand, servers, variability: 0.0, burst, sharers: 1 };
    let shared = |name, demand, servers, burst| Station {
        name,
        demand,
        servers,
        variability: 0.0,
        burst,
        sharers: level.cores,
    };
    let mut stations = vec![
        own("ALU", per_turn(demand.alu) * servers, servers as u32, 1.0),
        own("EFU", per_turn(demand.efu), 1, 1.0),
        own("load/store port", per_turn(demand.load_store), 1, 1.0),
    ];
    let lines = issue.line_requests as f64;
    let waits = (issue.memory_waits.max(1)) as f64;
    for (cache, served) in gpu.caches.iter().zip(traffic.levels) {
        let accesses = served.accesses as f64;
        if accesses == 0.0 {
            continue;
        }
        let line_seconds =
            cache.line_bytes as f64 * f64::from(cache.banks) / cache.bytes_per_clock / gpu.clock.hz;
        let name = match cache.role {
            CacheRole::L1 => "L1",
            CacheRole::Cluster => "cluster cache",
            CacheRole::L2 => "L2",
            CacheRole::Slc => "SLC",
        };
        let burst = (accesses / waits).max(1.0);
        let demand = line_seconds * accesses / turns;
        stations.push(if cache.copies > 1 {
            own(name, demand, cache.banks, burst)
        } else {
            shared(name, demand, cache.banks, burst)
        });
    }
    let misses = (traffic.dram_read_bytes as f64
        / gpu.caches.last().map_or(64.0, |cache| cache.line_bytes as f64))
    .max(1.0);
    stations.push(shared("DRAM", demand.dram / turns, 1, (misses / waits).max(1.0).min(lines.max(1.0))));
    stations.push(shared("triangle setup", demand.setup / turns, 1, 1.0));
    stations.push(shared("pixel rate", demand.pixels / turns, 1, 1.0));
    // A line is on its way for the latency of the place that it comes from; a turn waits for the farthest of its lines.
    let burst = (lines / waits).max(1.0);
    stations.push(own(IN_FLIGHT, demand.line_waits / turns, gpu.load_store.lines_in_flight, burst));
    let beyond = (demand.turn_waits - demand.line_waits / burst).max(0.0);
    Network {
        customers: (f64::from(level.warps) / f64::from(level.cores)).max(1.0),
        think_time: beyond / turns,
        stations,
    }
}

fn stack(seconds: f64, solution: &Solution) -> Vec<StackPart> {
    let mut parts: Vec<StackPart> = Vec::new();
    for share in solution.stack() {
        let name = match share.part {
            Part::Think => LATENCY,
            Part::Service(place) | Part::Queueing(place) => solution.stations[place].name,
        };
        let seconds = seconds * share.seconds / solution.cycle_time;
        match parts.iter_mut().find(|part| part.name == name) {
            Some(part) => part.seconds += seconds,
            None => parts.push(StackPart { name, seconds }),
        }
    }
    parts.retain(|part| part.seconds > 0.0);
    parts
}
