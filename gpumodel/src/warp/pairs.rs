//! Which triangles come with the record of another.

use std::sync::Arc;
use tracer::Topology;

/// The second triangles of pairs: a fetch of the first one has brought them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Seconds {
    /// A bit for each position in the leaves; empty without pairs.
    positions: Arc<[u64]>,
}

impl Seconds {
    pub(crate) fn new(topology: &Topology) -> Self {
        let words = topology.seconds.last().map_or(0, |&last| last as usize / 64 + 1);
        let mut positions = vec![0; words];
        for &second in &topology.seconds {
            positions[second as usize / 64] |= 1 << (second % 64);
        }
        Self { positions: positions.into() }
    }

    /// Whether there are any.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    #[inline(always)]
    pub(crate) fn contains(&self, position: u32) -> bool {
        self.positions.get(position as usize / 64).is_some_and(|word| word >> (position % 64) & 1 != 0)
    }
}
