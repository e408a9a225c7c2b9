//! Power of system memory.

use crate::config::{Boundary, Dram, DramFigures, RailFigures, RailLaw, Tag};
use cachesim::RowCounts;

/// The memory of a GPU's system as a consumer of power: as many interfaces of a measured width as its channels make, which share the traffic.
#[derive(Clone, Debug)]
pub struct DramPower {
    interfaces: f64,
    activate_joules: f64,
    activate_tag: Tag,
    row_bytes: u64,
    rails: Vec<Rail>,
}

/// One supply of all interfaces together.
#[derive(Clone, Debug)]
pub struct Rail {
    figures: RailFigures,
    interfaces: f64,
}

impl DramPower {
    pub(super) fn new(figures: &DramFigures, dram: &Dram) -> Self {
        let bits = f64::from(dram.channels) * f64::from(dram.standard.width_bits());
        let interfaces = bits / f64::from(figures.interface_bits);
        let rail = |figures: &RailFigures| Rail { figures: figures.clone(), interfaces };
        Self {
            interfaces,
            activate_joules: figures.activate_nanojoules * 1e-9,
            activate_tag: figures.activate_tag,
            row_bytes: dram.standard.row_bytes(),
            rails: figures.rails.iter().map(rail).collect(),
        }
    }

    /// Its supplies.
    pub fn rails(&self) -> &[Rail] {
        &self.rails
    }

    /// Interfaces that share the traffic.
    pub fn interfaces(&self) -> f64 {
        self.interfaces
    }

    /// Watts of all supplies while so many bytes are read and written per second; rows opened beyond those of a stream are not in it.
    pub fn watts(&self, bytes_per_second: f64) -> f64 {
        self.rails.iter().map(|rail| rail.floor_watts() + rail.traffic_watts(bytes_per_second)).sum()
    }

    /// Joules of the rows that were opened beyond those that a stream of `bytes` opens.
    pub(super) fn activate_joules(&self, rows: &RowCounts, bytes: u64) -> f64 {
        let opened = rows.misses + rows.conflicts;
        opened.saturating_sub(bytes.div_ceil(self.row_bytes)) as f64 * self.activate_joules
    }

    pub(super) fn activate_tag(&self) -> Tag {
        self.activate_tag
    }
}

impl Rail {
    /// What it supplies.
    pub fn name(&self) -> &str {
        &self.figures.name
    }

    /// What is inside of its power.
    pub fn boundary(&self) -> Boundary {
        self.figures.boundary
    }

    /// How far the law of its traffic can be trusted.
    pub fn tag(&self) -> Tag {
        self.figures.tag
    }

    /// How far its floor can be trusted.
    pub fn floor_tag(&self) -> Tag {
        self.figures.floor_tag
    }

    /// Watts without traffic: refresh, and clocks that run.
    pub fn floor_watts(&self) -> f64 {
        self.interfaces * self.figures.floor_milliwatts * 1e-3
    }

    /// Watts beyond the floor while so many bytes are read and written per second.
    pub fn traffic_watts(&self, bytes_per_second: f64) -> f64 {
        let gbs = bytes_per_second * 1e-9 / self.interfaces;
        let milliwatts = match self.figures.law {
            RailLaw::Linear(per_gbs) => per_gbs * gbs,
            RailLaw::Root(per_root) => per_root * gbs.sqrt(),
        };
        self.interfaces * milliwatts * 1e-3
    }
}
