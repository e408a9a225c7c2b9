//! The nodes of a binary BVH, whatever its leaves hold: triangles, or the instances of a TLAS.

use super::tree::{NodePair, NodeRef};
use crate::aabb::Aabb;

/// The root and the pairs of siblings below it; nodes 1 and 2 are the first pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairTree<'a> {
    pub(crate) root_bounds: &'a Aabb,
    pub(crate) root: NodeRef,
    /// As [`NodePair::pack`] makes them of the nodes that the builder gives.
    pub(crate) pairs: &'a [NodePair],
}

impl<'a> PairTree<'a> {
    /// Box and links of node `index`.
    #[inline(always)]
    pub(crate) fn node(self, index: u32) -> (Aabb, NodeRef) {
        match index.checked_sub(1) {
            None => (*self.root_bounds, self.root),
            Some(below) => self.pairs[(below / 2) as usize].side((below % 2) as usize),
        }
    }

    /// The pair of nodes `left` and `left + 1`.
    #[inline(always)]
    pub(crate) fn pair(self, left: u32) -> &'a NodePair {
        debug_assert!(left % 2 == 1);
        let index = (left / 2) as usize;
        debug_assert!(index < self.pairs.len());
        // SAFETY: `left` is the link of an inner node. The builder, from which all trees come, gives every inner node a pair of
        // children that exists; `Bvh::validate` checks it in debug builds. The safe twin is `node`.
        unsafe { self.pairs.get_unchecked(index) }
    }
}
