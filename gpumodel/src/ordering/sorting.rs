//! Hits brought into buckets, one for each shader.

use super::{Address, AtomicStrategy, AtomicTally, check_arrivals, refuse};
use crate::error::Error;

/// The bucket of a ray, by the shader of what it hit.
pub fn bucket_of(shader: Option<u32>) -> u32 {
    shader.map_or(0, |shader| shader.saturating_add(1))
}

/// A sort in three passes: one counts the elements of each bucket, one takes a stretch of the buffer for each, one copies the elements'
/// numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BucketSort {
    /// Number of buckets.
    pub buckets: u32,
    /// Lanes of a warp.
    pub warp_width: usize,
    /// Lanes of a workgroup that shades.
    pub consumer: u32,
    /// How lanes add to the counters of the buckets.
    pub strategy: AtomicStrategy,
}

/// A bucket after the sort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bucket {
    /// Where its elements begin.
    pub start: u32,
    /// How many there are.
    pub size: u32,
    /// One past its last element, as its counter is after the copy.
    pub end: u32,
    /// Warps that have any: atomics on its counter in a pass where a warp's are one.
    pub warps: u32,
    /// Workgroups of the dispatch that shades it.
    pub dispatch: u32,
}

/// Elements by bucket.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sorted {
    /// By place, the element.
    pub order: Vec<usize>,
    /// By number.
    pub buckets: Vec<Bucket>,
    /// Atomics of the count; the copy has the same. The pass between has one for each bucket.
    pub atomics: AtomicTally,
}

impl BucketSort {
    /// Warps of the first and the last pass.
    pub fn warps(&self, elements: usize) -> usize {
        elements.div_ceil(self.warp_width.max(1))
    }

    /// Sorts elements, whose buckets are given: `offsets` are the buckets in the order in which they take their stretches, `copies` the warps in
    /// the order in which they copy. The order of the count leaves no trace.
    ///
    /// # Errors
    /// When a bucket is not below [`Self::buckets`], a width is 0, or an order does not name each once.
    pub fn run(&self, elements: &[u32], offsets: &[usize], copies: &[usize]) -> Result<Sorted, Error> {
        if self.warp_width == 0 || self.consumer == 0 {
            let problem = format!(
                "warps have {} lanes and workgroups {}, expected at least 1",
                self.warp_width, self.consumer
            );
            return Err(refuse(problem, "give the GPU's warp width, and the shader's workgroup"));
        }
        if let Some(bucket) = elements.iter().find(|&&bucket| bucket >= self.buckets) {
            let problem = format!("an element is in bucket {bucket}, expected one below {}", self.buckets);
            return Err(refuse(problem, "raise the number of buckets: one per shader, and one for misses"));
        }
        check_arrivals("buckets", offsets, self.buckets as usize)?;
        check_arrivals("warps", copies, self.warps(elements.len()))?;

        let mut sizes = vec![0; self.buckets as usize];
        let (mut lanes, mut found) = (Vec::new(), Vec::new());
        let mut atomics = AtomicTally::default();
        let mut buckets = vec![Bucket::default(); self.buckets as usize];
        for warp in elements.chunks(self.warp_width) {
            lanes.clear();
            lanes.extend(warp.iter().copied().map(Some));
            atomics += self.strategy.add(Address::PerLane, &lanes, &mut sizes, &mut found);
            for (lane, bucket) in warp.iter().enumerate() {
                buckets[*bucket as usize].warps += u32::from(!warp[..lane].contains(bucket));
            }
        }

        let mut total = 0;
        for &bucket in offsets {
            let size = sizes[bucket];
            let dispatch = size.div_ceil(self.consumer);
            buckets[bucket] = Bucket { start: total, size, dispatch, ..buckets[bucket] };
            total += size;
        }

        let mut order = vec![0; total as usize];
        let mut ends: Vec<u32> = buckets.iter().map(|bucket| bucket.start).collect();
        for &warp in copies {
            let first = warp * self.warp_width;
            lanes.clear();
            lanes.extend(elements[first..].iter().take(self.warp_width).copied().map(Some));
            self.strategy.add(Address::PerLane, &lanes, &mut ends, &mut found);
            for (element, place) in (first..).zip(found.iter().flatten()) {
                order[*place as usize] = element;
            }
        }
        buckets.iter_mut().zip(ends).for_each(|(bucket, end)| bucket.end = end);
        Ok(Sorted { order, buckets, atomics })
    }
}

#[cfg(test)]
mod tests;
