//! What events take on one GPU.

use super::{DramPower, Leakage};
use crate::config::{Boundary, CacheRole, EnergyTable, Gpu, Logic, LogicFigure, Process, Tag};
use crate::error::Error;
use cachesim::DramStandard;

/// Bytes of the array and of the access that the table's figure of SRAM is of.
const SRAM_BYTES: u64 = 8192;
const WORD_BYTES: u64 = 8;

/// What one event takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Price {
    /// Joules.
    pub joules: f64,
    /// What is inside of it.
    pub boundary: Boundary,
    /// How far it can be trusted: an estimate where it was scaled from another process or voltage.
    pub tag: Tag,
}

/// Supply voltage of a GPU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Supply {
    /// That of the GPU's operating points at its clock, in volts.
    OperatingPoints(f64),
    /// The reference voltage of its process, as its description gives none, in volts.
    Process(f64),
}

impl Supply {
    fn of(gpu: &Gpu, process: &Process) -> Self {
        gpu.supply_volts().map_or(Self::Process(process.volts), Self::OperatingPoints)
    }

    /// In volts.
    pub fn volts(self) -> f64 {
        match self {
            Self::OperatingPoints(volts) | Self::Process(volts) => volts,
        }
    }

    /// Where it is from, in reports.
    pub fn origin(self) -> &'static str {
        match self {
            Self::OperatingPoints(_) => "operating points",
            Self::Process(_) => "process",
        }
    }
}

/// What the events of a frame take on one GPU at its supply voltage.
#[derive(Clone, Debug)]
pub struct EnergyPrices {
    pub(super) logic: Logic<Price>,
    /// A line of each of [`Gpu::caches`], read or written.
    pub(super) lines: Vec<Price>,
    /// A byte of tile memory, read or written.
    pub(super) tile_byte: Price,
    pub(super) leakage: Leakage,
    pub(super) dram: DramPower,
    process: String,
    supply: Supply,
}

impl EnergyPrices {
    /// Those of `gpu` by `table`; `None` where the GPU's description names no process.
    ///
    /// # Errors
    /// When the table does not know the GPU's process or standard of memory.
    pub fn new(table: &EnergyTable, gpu: &Gpu) -> Result<Option<Self>, Error> {
        let Some(energy) = &gpu.energy else { return Ok(None) };
        let Some(process) = table.processes.iter().find(|process| process.name == energy.process) else {
            let known: Vec<&str> = table.processes.iter().map(|process| process.name.as_str()).collect();
            return Err(unknown(table, ["energy.process", &energy.process, "[[process]]"], &known, gpu));
        };
        let supply = Supply::of(gpu, process);
        let volts = supply.volts();
        let price = |figure: &LogicFigure, volts: f64| price(figure, &table.processes, process, volts);
        let logic = table.logic.map(|_, figure| Ok::<_, Error>(price(figure, volts)))?;
        // Bit lines and word lines grow with the edge of an array.
        let bytes = |word: Price, bytes: u64, array: u64| Price {
            joules: word.joules * bytes as f64 / WORD_BYTES as f64
                * (array as f64 / SRAM_BYTES as f64).sqrt(),
            tag: if array == SRAM_BYTES { word.tag } else { Tag::Estimate },
            ..word
        };
        let levels = gpu.caches.iter().zip(gpu.levels().as_slice());
        let word = price(&table.sram_word, volts);
        // The system cache is not on the GPU's supply.
        let word_of_chip = price(&table.sram_word, process.volts);
        let lines = levels.map(|(cache, level)| {
            let word = if cache.role == CacheRole::Slc { word_of_chip } else { word };
            bytes(word, cache.line_bytes, level.size.0)
        });
        let DramStandard { name: standard, .. } = &gpu.dram.standard;
        let Some(dram) = table.drams.iter().find(|dram| dram.standard == *standard) else {
            let known: Vec<&str> = table.drams.iter().map(|dram| dram.standard.as_str()).collect();
            return Err(unknown(table, ["dram.standard", standard, "[[dram]]"], &known, gpu));
        };
        Ok(Some(Self {
            logic,
            lines: lines.collect(),
            tile_byte: bytes(word, 1, u64::from(gpu.tiler.tile_memory_bytes)),
            leakage: Leakage::new(&table.leakage, f64::from(gpu.cores.count) * gpu.cores.alu_lanes),
            dram: DramPower::new(dram, &gpu.dram),
            process: process.name.clone(),
            supply,
        }))
    }

    /// Name of the GPU's process.
    pub fn process(&self) -> &str {
        &self.process
    }

    /// Supply voltage of the GPU, with the square of which the dynamic energies of its events go.
    pub fn supply(&self) -> Supply {
        self.supply
    }

    /// Power of the GPU while it does nothing.
    pub fn leakage(&self) -> &Leakage {
        &self.leakage
    }

    /// Power of the system's memory.
    pub fn dram(&self) -> &DramPower {
        &self.dram
    }
}

/// Of a figure in `process` at a supply of `volts`: an estimate unless it was found there.
fn price(figure: &LogicFigure, processes: &[Process], process: &Process, volts: f64) -> Price {
    let of = &processes[figure.process];
    let by_voltage = (volts / process.volts).powi(2);
    let tag = if of.name == process.name && by_voltage == 1.0 { figure.tag } else { Tag::Estimate };
    let joules = figure.picojoules * 1e-12 * process.energy / of.energy * by_voltage;
    Price { joules, boundary: figure.boundary, tag }
}

/// Of a key of the GPU, its value, and the tables that it should name one of.
fn unknown(table: &EnergyTable, [key, name, tables]: [&str; 3], known: &[&str], gpu: &Gpu) -> Error {
    Error::Config {
        file: gpu.name().to_owned(),
        line: None,
        key: format!("{key}: "),
        problem: format!("is '{name}', and {} has: {}", table.file, known.join(", ")),
        remedy: format!("name one of these, or add it to the {tables} of an --energy table"),
    }
}
