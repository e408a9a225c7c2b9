//! A frame's energy by cause and by pass.

use super::{EnergyPrices, Price};
use crate::config::{Boundary, CacheRole, Gpu, Logic, Tag};
use crate::counters::{BufferTraffic, IssueCounters, Pass, PassCounters};
use crate::replay::{ReplayConfig, Replayed};

/// Whose supply an energy comes from, and so how it scales.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Domain {
    /// The GPU's events: with the square of its voltage.
    Gpu,
    /// The system cache, on the chip's supply: not with the GPU's voltage.
    SystemCache,
    /// Memory: its traffic, and its floor for as long as the frame takes.
    Dram,
    /// The GPU's leakage, for as long as the frame takes: see [`Leakage`](super::Leakage).
    Leakage,
}

impl Domain {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gpu => "GPU",
            Self::SystemCache => "system cache",
            Self::Dram => "DRAM",
            Self::Leakage => "leakage",
        }
    }
}

/// What one cause takes in the whole frame.
#[derive(Clone, Debug, PartialEq)]
pub struct CauseEnergy {
    /// What takes it.
    pub cause: String,
    /// Whose supply it comes from.
    pub domain: Domain,
    /// Joules at the GPU's supply voltage and at the reference temperature.
    pub joules: f64,
    /// What is inside of the figure.
    pub boundary: Boundary,
    /// How far the figure can be trusted.
    pub tag: Tag,
}

/// What a pass takes: its events, its bytes' share of the memory's traffic, and leakage and memory's floor for its time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassEnergy {
    /// Joules of all causes.
    pub joules: f64,
    /// Of these, memory's.
    pub dram_joules: f64,
}

/// The energy of a frame. The sums over causes and over passes are the same up to the rounding of floating-point sums.
#[derive(Clone, Debug)]
pub struct FrameEnergy {
    /// What takes it, in the order of reports; those that take nothing are left out.
    pub causes: Vec<CauseEnergy>,
    /// By [`Pass`]; those that the frame does not have are zero.
    pub passes: [PassEnergy; Pass::COUNT],
    /// What the events of the frame take on its GPU, the supply voltage that they hold at, and its powers by voltage, temperature and traffic.
    pub prices: EnergyPrices,
    /// Bytes read from and written to memory.
    pub dram_bytes: u64,
}

/// A cause with what it takes in each pass.
struct Row {
    cause: String,
    domain: Domain,
    boundary: Boundary,
    tag: Tag,
    joules: [f64; Pass::COUNT],
}

impl FrameEnergy {
    /// Of a frame whose passes take so many seconds.
    pub(crate) fn new(
        prices: EnergyPrices,
        replayed: &Replayed,
        config: &ReplayConfig,
        seconds: &[f64; Pass::COUNT],
    ) -> Self {
        let mut passes = replayed.counters.passes;
        // The write-back at the end belongs to the pass whose time it is in.
        passes[config.technique.last_shading() as usize].traffic.stack += replayed.counters.flush;
        let bytes = passes.each_ref().map(dram_bytes);
        let dram_bytes = bytes.iter().sum();
        let mut rows = of_events(&prices, &passes, &config.gpu);
        rows.extend(of_traffic(&prices, replayed, &bytes, seconds));
        rows.extend(of_time(&prices, seconds));
        let mut of_passes = [PassEnergy::default(); Pass::COUNT];
        for row in &rows {
            for (pass, joules) in of_passes.iter_mut().zip(row.joules) {
                pass.joules += joules;
                pass.dram_joules += if row.domain == Domain::Dram { joules } else { 0.0 };
            }
        }
        let cause = |Row { cause, domain, boundary, tag, joules }| CauseEnergy {
            cause,
            domain,
            joules: joules.iter().sum(),
            boundary,
            tag,
        };
        let causes = rows.into_iter().map(cause).filter(|cause| cause.joules > 0.0).collect();
        Self { causes, passes: of_passes, prices, dram_bytes }
    }

    /// Joules of all passes.
    pub fn total(&self) -> PassEnergy {
        self.passes.iter().fold(PassEnergy::default(), |sum, pass| PassEnergy {
            joules: sum.joules + pass.joules,
            dram_joules: sum.dram_joules + pass.dram_joules,
        })
    }

    /// Joules that come from one supply.
    pub fn of_domain(&self, domain: Domain) -> f64 {
        self.causes.iter().filter(|cause| cause.domain == domain).map(|cause| cause.joules).sum()
    }
}

/// What goes with the numbers of events.
fn of_events(prices: &EnergyPrices, passes: &[PassCounters; Pass::COUNT], gpu: &Gpu) -> Vec<Row> {
    let row = |cause: &str, domain: Domain, price: &Price, events: &dyn Fn(&PassCounters) -> u64| Row {
        cause: cause.to_owned(),
        domain,
        boundary: price.boundary,
        tag: price.tag,
        joules: passes.each_ref().map(|pass| events(pass) as f64 * price.joules),
    };
    let of_gpu = |cause: &str, price: &Price, events: &dyn Fn(&PassCounters) -> u64| {
        row(cause, Domain::Gpu, price, events)
    };
    let Logic { alu_operation, efu_operation, issue, register_byte, box_test, triangle_test } = &prices.logic;
    let mut rows = vec![
        of_gpu("ALU operations", alu_operation, &|pass| pass.issue.alu_active),
        of_gpu("EFU operations", efu_operation, &|pass| pass.issue.efu_active),
        of_gpu("instructions, registers and clocks", issue, &|pass| {
            pass.issue.alu_issued + pass.issue.efu_issued
        }),
        of_gpu("loads and stores", register_byte, &|pass| pass.issue.lane_bytes),
        of_gpu("ray unit: boxes", box_test, &|pass| pass.issue.unit_box_tests),
        of_gpu("ray unit: triangles", triangle_test, &|pass| {
            if pass.issue.unit_triangle_places > 0 { pass.issue.primitive_tests } else { 0 }
        }),
    ];
    for (index, (cache, line)) in gpu.caches.iter().zip(&prices.lines).enumerate() {
        let domain = if cache.role == CacheRole::Slc { Domain::SystemCache } else { Domain::Gpu };
        // A line that is not there is looked for, and later filled.
        rows.push(row(&format!("cache {}", cache.name), domain, line, &|pass| {
            let served = pass.traffic.total().levels[index];
            served.accesses + served.misses
        }));
    }
    // What leaves tile memory was written there and is read.
    rows.push(of_gpu("tile memory", &prices.tile_byte, &|pass| {
        2 * pass.issue.output_bytes + pass.issue.internal_bytes
    }));
    rows
}

/// What memory takes for its traffic, at the mean rate of the frame, shared out by bytes.
fn of_traffic(
    prices: &EnergyPrices,
    replayed: &Replayed,
    bytes: &[u64; Pass::COUNT],
    seconds: &[f64; Pass::COUNT],
) -> Vec<Row> {
    let all_bytes: u64 = bytes.iter().sum();
    let all_seconds: f64 = seconds.iter().sum();
    if all_bytes == 0 || all_seconds <= 0.0 {
        return Vec::new();
    }
    let row = |cause: String, boundary: Boundary, tag: Tag, joules: f64| Row {
        cause,
        domain: Domain::Dram,
        boundary,
        tag,
        joules: bytes.map(|of| joules * (of as f64 / all_bytes as f64)),
    };
    let dram = prices.dram();
    let rate = all_bytes as f64 / all_seconds;
    let of_rail = dram.rails().iter().map(|rail| {
        let joules = rail.traffic_watts(rate) * all_seconds;
        row(format!("{}: reads and writes", rail.name()), rail.boundary(), rail.tag(), joules)
    });
    let mut rows: Vec<Row> = of_rail.collect();
    if let Some(timed) = &replayed.timed {
        let joules = dram.activate_joules(&timed.dram.rows, all_bytes);
        let cause = "DRAM: rows opened beyond a stream's".to_owned();
        rows.push(row(cause, Boundary::DramRails, dram.activate_tag(), joules));
    }
    rows
}

/// What goes with time alone.
fn of_time(prices: &EnergyPrices, seconds: &[f64; Pass::COUNT]) -> Vec<Row> {
    let row = |cause: String, domain: Domain, boundary: Boundary, tag: Tag, watts: f64| Row {
        cause,
        domain,
        boundary,
        tag,
        joules: seconds.map(|seconds| seconds * watts),
    };
    let leakage = prices.leakage();
    let watts = leakage.watts(prices.supply().volts(), leakage.reference_celsius());
    let of_gpu = row("leakage".to_owned(), Domain::Leakage, Boundary::Gpu, leakage.tag(), watts);
    let of_rails = prices.dram().rails().iter().map(|rail| {
        let cause = format!("{}: refresh and idle", rail.name());
        row(cause, Domain::Dram, rail.boundary(), rail.floor_tag(), rail.floor_watts())
    });
    std::iter::once(of_gpu).chain(of_rails).collect()
}

fn dram_bytes(pass: &PassCounters) -> u64 {
    let BufferTraffic { dram_read_bytes, dram_write_bytes, .. } = pass.traffic.total();
    let IssueCounters { output_bytes, bin_list_bytes, dma_write_bytes, dma_read_bytes, .. } = pass.issue;
    dram_read_bytes + dram_write_bytes + output_bytes + bin_list_bytes + dma_write_bytes + dma_read_bytes
}
