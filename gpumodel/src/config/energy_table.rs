//! What events take: `configs/energy.toml`.

use super::sourced::{File, Sourced, Tag};
use crate::error::Error;
use serde::Deserialize;
use std::ops::RangeInclusive;
use toml::Spanned;

const BUILTIN: &str = include_str!("../../../configs/energy.toml");

/// Figures of energy are refused outside of this: both ends are far from any hardware, and from where f64 loses them.
const ENERGY: RangeInclusive<f64> = 0.0..=1e9;
/// Relative energies of processes.
const RELATIVE: RangeInclusive<f64> = 1e-6..=1e6;
/// Supply voltages.
const VOLTS: RangeInclusive<f64> = 0.1..=10.0;
/// Temperatures of a chip in degrees Celsius.
const CELSIUS: RangeInclusive<f64> = -40.0..=150.0;
/// Coefficients of a polynomial of the temperature, in millionths.
const COEFFICIENT: RangeInclusive<f64> = -1e9..=1e9;

/// What events take in each process, and what memory of each standard takes.
#[derive(Clone, Debug)]
pub struct EnergyTable {
    /// As the caller named it.
    pub(crate) file: String,
    pub(crate) processes: Vec<Process>,
    pub(crate) logic: Logic<LogicFigure>,
    /// 64 bits of an array of 8 KiB.
    pub(crate) sram_word: LogicFigure,
    pub(crate) leakage: LeakageFigures,
    pub(crate) drams: Vec<DramFigures>,
}

/// A process of the table.
#[derive(Clone, Debug)]
pub(crate) struct Process {
    pub(crate) name: String,
    /// Relative to 45 nm at 0.9 V.
    pub(crate) energy: f64,
    pub(crate) volts: f64,
}

/// What is inside a figure of energy or power.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
pub enum Boundary {
    /// An arithmetic unit alone.
    #[serde(rename = "unit")]
    Unit,
    /// Memory cells on the chip with their decoders and sense amplifiers.
    #[serde(rename = "array")]
    Array,
    /// A shader core.
    #[serde(rename = "core")]
    Core,
    /// The whole GPU.
    #[serde(rename = "GPU")]
    Gpu,
    /// The supply of the memory's devices.
    #[serde(rename = "DRAM rails")]
    DramRails,
    /// The supply of the memory interface on the chip's side.
    #[serde(rename = "PHY rail")]
    PhyRail,
    /// Devices, interface and controller.
    #[serde(rename = "whole path")]
    WholePath,
}

impl Boundary {
    /// Its name in files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unit => "unit",
            Self::Array => "array",
            Self::Core => "core",
            Self::Gpu => "GPU",
            Self::DramRails => "DRAM rails",
            Self::PhyRail => "PHY rail",
            Self::WholePath => "whole path",
        }
    }
}

/// Picojoules of an event in one process.
#[derive(Clone, Debug)]
pub(crate) struct LogicFigure {
    pub(crate) picojoules: f64,
    /// Index into the table's processes.
    pub(crate) process: usize,
    pub(crate) boundary: Boundary,
    pub(crate) tag: Tag,
}

/// The events of cores and ray units.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Logic<T> {
    pub(crate) alu_operation: T,
    pub(crate) efu_operation: T,
    pub(crate) issue: T,
    pub(crate) register_byte: T,
    pub(crate) box_test: T,
    pub(crate) triangle_test: T,
}

impl<T> Logic<T> {
    pub(crate) fn map<U, E>(&self, of: impl Fn(&str, &T) -> Result<U, E>) -> Result<Logic<U>, E> {
        let Self { alu_operation, efu_operation, issue, register_byte, box_test, triangle_test } = self;
        Ok(Logic {
            alu_operation: of("alu_operation", alu_operation)?,
            efu_operation: of("efu_operation", efu_operation)?,
            issue: of("issue", issue)?,
            register_byte: of("register_byte", register_byte)?,
            box_test: of("box_test", box_test)?,
            triangle_test: of("triangle_test", triangle_test)?,
        })
    }
}

/// Power of a chip that does nothing.
#[derive(Clone, Debug)]
pub(crate) struct LeakageFigures {
    pub(crate) milliwatts_per_lane: f64,
    /// Coefficients of 1, T, T^2 and T^3, in millionths.
    pub(crate) temperature_scale: [f64; 4],
    pub(crate) reference_celsius: f64,
    /// Two temperatures that an exponential law goes through, the lower first.
    pub(crate) fit_celsius: [f64; 2],
    pub(crate) tag: Tag,
}

/// Memory of one standard.
#[derive(Clone, Debug)]
pub(crate) struct DramFigures {
    pub(crate) standard: String,
    pub(crate) interface_bits: u32,
    pub(crate) activate_nanojoules: f64,
    pub(crate) activate_tag: Tag,
    pub(crate) rails: Vec<RailFigures>,
}

/// One of its supplies.
#[derive(Clone, Debug)]
pub(crate) struct RailFigures {
    pub(crate) name: String,
    pub(crate) boundary: Boundary,
    pub(crate) floor_milliwatts: f64,
    pub(crate) floor_tag: Tag,
    pub(crate) law: RailLaw,
    pub(crate) tag: Tag,
}

/// How the power of an interface grows with its traffic, in 10^9 bytes per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RailLaw {
    /// Milliwatts per GB/s.
    Linear(f64),
    /// Milliwatts per square root of GB/s.
    Root(f64),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TableFile {
    process: Vec<ProcessFile>,
    logic: Logic<LogicFile>,
    sram: SramFile,
    leakage: LeakageFile,
    dram: Vec<DramFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProcessFile {
    name: Spanned<String>,
    energy: Sourced<f64>,
    volts: Sourced<f64>,
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct LogicFile {
    value: Spanned<f64>,
    process: Spanned<String>,
    boundary: Boundary,
    source: Spanned<String>,
    tag: Tag,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SramFile {
    word: LogicFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LeakageFile {
    milliwatts_per_lane: Sourced<f64>,
    temperature_scale: Sourced<[f64; 4]>,
    reference_celsius: Sourced<f64>,
    fit_celsius: Sourced<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DramFile {
    standard: Spanned<String>,
    interface_bits: Sourced<u32>,
    activate_nj: Sourced<f64>,
    rail: Vec<RailFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RailFile {
    name: Spanned<String>,
    boundary: Boundary,
    floor_mw: Sourced<f64>,
    mw_per_gbs: Option<Sourced<f64>>,
    mw_per_root_gbs: Option<Sourced<f64>>,
}

impl EnergyTable {
    /// Reads and checks a table; `file_name` is for messages.
    ///
    /// # Errors
    /// Names the file, the line, the key, what was expected and the remedy.
    pub fn parse(toml_text: &str, file_name: &str) -> Result<Self, Error> {
        let file = File::new(file_name, toml_text);
        let raw: TableFile = file.read()?;
        let processes =
            raw.process.iter().map(|raw| process(&file, raw)).collect::<Result<Vec<_>, Error>>()?;
        for (index, raw) in raw.process.iter().enumerate() {
            if processes[..index].iter().any(|known| known.name == *raw.name.get_ref()) {
                return Err(twice(&file, "process.name", &raw.name));
            }
        }
        let figure = |key: &str, raw: &LogicFile| logic_figure(&file, key, raw, &processes);
        let logic = raw.logic.map(|field, raw| figure(&format!("logic.{field}"), raw))?;
        let sram_word = figure("sram.word", &raw.sram.word)?;
        let drams = raw.dram.iter().map(|raw| dram(&file, raw)).collect::<Result<Vec<_>, Error>>()?;
        for (index, raw) in raw.dram.iter().enumerate() {
            if drams[..index].iter().any(|known| known.standard == *raw.standard.get_ref()) {
                return Err(twice(&file, "dram.standard", &raw.standard));
            }
        }
        Ok(Self {
            file: file_name.to_owned(),
            leakage: leakage(&file, &raw.leakage)?,
            processes,
            logic,
            sram_word,
            drams,
        })
    }

    /// The table that comes with the program.
    ///
    /// # Errors
    /// None that is known: a test reads it.
    pub fn builtin() -> Result<Self, Error> {
        Self::parse(BUILTIN, "configs/energy.toml")
    }

    /// The text of [`Self::builtin`].
    pub fn builtin_text() -> &'static str {
        BUILTIN
    }
}

fn twice(file: &File<'_>, key: &str, name: &Spanned<String>) -> Error {
    file.refuse(key, &name.span(), format!("'{}' stands twice", name.get_ref()), "remove one of the tables")
}

fn process(file: &File<'_>, raw: &ProcessFile) -> Result<Process, Error> {
    let name = raw.name.get_ref();
    Ok(Process {
        name: name.clone(),
        energy: file.within(&format!("process.{name}.energy"), &raw.energy, RELATIVE)?,
        volts: file.within(&format!("process.{name}.volts"), &raw.volts, VOLTS)?,
    })
}

fn logic_figure(
    file: &File<'_>,
    key: &str,
    raw: &LogicFile,
    processes: &[Process],
) -> Result<LogicFigure, Error> {
    file.said(key, &raw.source)?;
    let name = raw.process.get_ref();
    let Some(process) = processes.iter().position(|process| process.name == *name) else {
        let known: Vec<&str> = processes.iter().map(|process| process.name.as_str()).collect();
        let problem = format!("is '{name}', expected one of: {}", known.join(", "));
        let remedy = "name a [[process]] of this file";
        return Err(file.refuse(&format!("{key}.process"), &raw.process.span(), problem, remedy));
    };
    let picojoules = *raw.value.get_ref();
    if !ENERGY.contains(&picojoules) {
        let problem = format!("is {picojoules}, expected {} to {}", ENERGY.start(), ENERGY.end());
        return Err(file.refuse(key, &raw.value.span(), problem, "correct the value"));
    }
    Ok(LogicFigure { picojoules, process, boundary: raw.boundary, tag: raw.tag })
}

fn leakage(file: &File<'_>, raw: &LeakageFile) -> Result<LeakageFigures, Error> {
    let LeakageFile { milliwatts_per_lane, temperature_scale, reference_celsius, fit_celsius } = raw;
    let key = "leakage.temperature_scale";
    let scale = *file.sourced(key, temperature_scale)?;
    if let Some(wrong) = scale.iter().find(|coefficient| !COEFFICIENT.contains(coefficient)) {
        let problem = format!(
            "has a coefficient of {wrong}, expected {} to {}",
            COEFFICIENT.start(),
            COEFFICIENT.end()
        );
        return Err(file.refuse(key, &temperature_scale.value.span(), problem, "correct the coefficients"));
    }
    let fit = *file.sourced("leakage.fit_celsius", fit_celsius)?;
    if !(fit.iter().all(|celsius| CELSIUS.contains(celsius)) && fit[0] < fit[1]) {
        let problem = format!(
            "is {fit:?}, expected two temperatures of {} to {}, the lower first",
            CELSIUS.start(),
            CELSIUS.end()
        );
        return Err(file.refuse(
            "leakage.fit_celsius",
            &fit_celsius.value.span(),
            problem,
            "correct the temperatures",
        ));
    }
    let figures = LeakageFigures {
        milliwatts_per_lane: file.within("leakage.milliwatts_per_lane", milliwatts_per_lane, ENERGY)?,
        temperature_scale: scale,
        reference_celsius: file.within("leakage.reference_celsius", reference_celsius, CELSIUS)?,
        fit_celsius: fit,
        tag: milliwatts_per_lane.tag,
    };
    let at_reference = figures.scale_at(figures.reference_celsius);
    if at_reference <= 0.0 {
        let problem = format!(
            "gives {at_reference} at leakage.reference_celsius, expected coefficients of 1, T, T^2 and T^3 with a positive sum"
        );
        return Err(file.refuse(key, &temperature_scale.value.span(), problem, "correct the coefficients"));
    }
    let [cool, warm] = fit.map(|celsius| figures.scale_at(celsius));
    if !(cool > 0.0 && warm > cool) {
        let problem = format!(
            "gives {cool} and {warm} at the {} and {} degrees of leakage.fit_celsius, expected positive values that grow",
            fit[0], fit[1]
        );
        let remedy = "correct the coefficients, or fit where leakage grows";
        return Err(file.refuse(key, &temperature_scale.value.span(), problem, remedy));
    }
    Ok(figures)
}

impl LeakageFigures {
    /// Power at a temperature relative to that of [`Self::milliwatts_per_lane`].
    pub(crate) fn scale_at(&self, celsius: f64) -> f64 {
        let [constant, linear, square, cube] = self.temperature_scale;
        (constant + celsius * (linear + celsius * (square + celsius * cube))) * 1e-6
    }
}

fn dram(file: &File<'_>, raw: &DramFile) -> Result<DramFigures, Error> {
    let standard = raw.standard.get_ref();
    let key = |field: &str| format!("dram.{standard}.{field}");
    if raw.rail.is_empty() {
        let remedy = "give it at least one [[dram.rail]]";
        return Err(file.refuse(&key("rail"), &raw.standard.span(), "has no supply", remedy));
    }
    let rails = raw.rail.iter().map(|raw| rail(file, standard, raw)).collect::<Result<Vec<_>, Error>>()?;
    Ok(DramFigures {
        standard: standard.clone(),
        interface_bits: file.within(&key("interface_bits"), &raw.interface_bits, 1..=4096)?,
        activate_nanojoules: file.within(&key("activate_nj"), &raw.activate_nj, ENERGY)?,
        activate_tag: raw.activate_nj.tag,
        rails,
    })
}

fn rail(file: &File<'_>, standard: &str, raw: &RailFile) -> Result<RailFigures, Error> {
    let name = raw.name.get_ref();
    let key = |field: &str| format!("dram.{standard}.{name}.{field}");
    let (law, tag) = match (&raw.mw_per_gbs, &raw.mw_per_root_gbs) {
        (Some(linear), None) => {
            (RailLaw::Linear(file.within(&key("mw_per_gbs"), linear, ENERGY)?), linear.tag)
        }
        (None, Some(root)) => (RailLaw::Root(file.within(&key("mw_per_root_gbs"), root, ENERGY)?), root.tag),
        _ => {
            let problem = "expected one of mw_per_gbs and mw_per_root_gbs";
            return Err(file.refuse(&key("rail"), &raw.name.span(), problem, "give one law"));
        }
    };
    Ok(RailFigures {
        name: name.clone(),
        boundary: raw.boundary,
        floor_milliwatts: file.within(&key("floor_mw"), &raw.floor_mw, ENERGY)?,
        floor_tag: raw.floor_mw.tag,
        law,
        tag,
    })
}
