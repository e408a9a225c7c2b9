//! Rays of a pass appended to a buffer without holes.

use super::{Address, AtomicStrategy, AtomicTally, Binning, MOST_BINS, check_arrivals, refuse};
use crate::error::Error;

/// Most lanes of a workgroup.
const MOST_LANES: usize = 1024;

/// How a workgroup's bins are counted in shared memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Counters {
    /// A word each.
    Words,
    /// Four to a word: a bin can hold 255.
    Packed,
}

impl Counters {
    /// Most lanes of a workgroup: all may be in one bin.
    pub fn most_lanes(self) -> usize {
        match self {
            Self::Words => MOST_LANES,
            Self::Packed => 255,
        }
    }

    /// Words of shared memory that `bins` take, and so the stores that set them to zero and the loads of a prefix sum.
    pub fn words(self, bins: u32) -> u32 {
        match self {
            Self::Words => bins,
            Self::Packed => bins.div_ceil(4),
        }
    }
}

/// A workgroup of a compute shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Workgroup {
    lanes: usize,
    warp_width: usize,
}

impl Workgroup {
    /// Of `lanes`, in warps of `warp_width`, which counts its bins in `counters`.
    ///
    /// # Errors
    /// When there are no lanes, or more than the counters allow.
    pub fn new(lanes: usize, warp_width: usize, counters: Counters) -> Result<Self, Error> {
        let most = counters.most_lanes();
        if !(1..=most).contains(&lanes) {
            let problem = format!("a workgroup has {lanes} lanes, expected 1 to {most}");
            let remedy = match counters {
                Counters::Words => "choose another size",
                Counters::Packed => {
                    "choose another size, or do not pack its counters: four to a word, they end at 255"
                }
            };
            return Err(refuse(problem, remedy));
        }
        if warp_width == 0 {
            return Err(refuse("a warp has 0 lanes, expected at least 1", "give the GPU's warp width"));
        }
        Ok(Self { lanes, warp_width })
    }
}

/// How a pass appends rays to a buffer, and how many workgroups it asks for to trace them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Compaction {
    /// Into which bins a workgroup puts its rays; [`Binning::None`] appends warp by warp.
    pub binning: Binning,
    /// The pass's workgroup.
    pub workgroup: Workgroup,
    /// How lanes count: to a global counter where there are no bins, otherwise to the bins in shared memory.
    pub strategy: AtomicStrategy,
    /// Lanes of a workgroup that traces.
    pub consumer: u32,
}

/// Rays in their new order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Compacted {
    /// By place in the buffer, the ray.
    pub order: Vec<usize>,
    /// Workgroups of the dispatch that traces.
    pub dispatch: u32,
    /// Adds to the counters in shared memory.
    pub shared: AtomicTally,
    /// Adds to the global counter; there are as many maxima, for the size of the dispatch.
    pub global: AtomicTally,
}

impl Compaction {
    /// How many warps, or with bins workgroups, arrive at the global counter.
    pub fn units(&self, lanes: usize) -> usize {
        lanes.div_ceil(self.unit_lanes())
    }

    fn unit_lanes(&self) -> usize {
        let Workgroup { lanes, warp_width } = self.workgroup;
        if self.binning == Binning::None { warp_width } else { lanes }
    }

    /// Appends the rays of a pass: for each of its lanes, the bin of its ray if it has one.
    ///
    /// `arrivals` are its warps, or with bins its workgroups, in the order in which they get to the global counter. A workgroup's rays lie by bin,
    /// those of a bin in the order of its lanes; workgroups lie one after the other.
    ///
    /// # Errors
    /// When a bin is not below [`Binning::bins`], or there are too many, or `arrivals` do not name each unit once.
    pub fn run(&self, lanes: &[Option<u32>], arrivals: &[usize]) -> Result<Compacted, Error> {
        let bins = self.binning.bins();
        if !(1..=MOST_BINS).contains(&bins) {
            let problem = format!("binning '{}' has {bins} bins, expected 1 to {MOST_BINS}", self.binning);
            return Err(refuse(problem, "choose fewer: a workgroup counts its bins in shared memory"));
        }
        if let Some(bin) = lanes.iter().flatten().find(|&&bin| bin >= bins) {
            let problem =
                format!("a ray is in bin {bin}, expected one below the {bins} of '{}'", self.binning);
            return Err(refuse(problem, "take bins from the same binning"));
        }
        if self.consumer == 0 {
            let remedy = "say how many lanes the workgroups have that trace";
            return Err(refuse("a workgroup has 0 lanes, expected at least 1", remedy));
        }
        let what = if self.binning == Binning::None { "warps" } else { "workgroups" };
        check_arrivals(what, arrivals, self.units(lanes.len()))?;
        let mut compacted = Compacted::default();
        for &unit in arrivals {
            let first = unit * self.unit_lanes();
            let unit = &lanes[first..lanes.len().min(first + self.unit_lanes())];
            match self.binning {
                Binning::None => self.append_warp(first, unit, &mut compacted),
                _ => self.append_workgroup(first, unit, &mut compacted),
            }
        }
        Ok(compacted)
    }

    fn append_warp(&self, first: usize, lanes: &[Option<u32>], compacted: &mut Compacted) {
        let mut total = [compacted.order.len() as u32];
        let mut places = Vec::new();
        compacted.global += self.strategy.add(Address::Uniform, lanes, &mut total, &mut places);
        compacted.put(total[0], self.consumer, first, &places);
    }

    fn append_workgroup(&self, first: usize, lanes: &[Option<u32>], compacted: &mut Compacted) {
        let mut counts = vec![0; self.binning.bins() as usize];
        let mut places = Vec::with_capacity(lanes.len());
        let mut found = Vec::new();
        for warp in lanes.chunks(self.workgroup.warp_width) {
            compacted.shared += self.strategy.add(Address::PerLane, warp, &mut counts, &mut found);
            places.append(&mut found);
        }
        // One lane: the prefix sum of the bins, and the start of the group.
        let mut total = compacted.order.len() as u32;
        for count in &mut counts {
            total += std::mem::replace(count, total);
        }
        compacted.global += AtomicTally::ONE;
        for (place, bin) in places.iter_mut().zip(lanes) {
            *place = place.zip(*bin).map(|(rank, bin)| counts[bin as usize] + rank);
        }
        compacted.put(total, self.consumer, first, &places);
    }
}

impl Compacted {
    /// Writes the rays from `first` to their places, up to `total`, and raises the size of the dispatch.
    fn put(&mut self, total: u32, consumer: u32, first: usize, places: &[Option<u32>]) {
        self.order.resize(total as usize, 0);
        for (ray, place) in places.iter().enumerate() {
            if let Some(place) = place {
                self.order[*place as usize] = first + ray;
            }
        }
        self.dispatch = self.dispatch.max(total.div_ceil(consumer));
    }
}

#[cfg(test)]
mod tests;
