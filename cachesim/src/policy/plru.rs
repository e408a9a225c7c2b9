//! Tree pseudo-LRU: a binary tree over the ways whose bits point away from recent accesses.

use super::Replacement;

/// Per set one bit per inner node, numbered as in a heap from 1; a set bit points to the upper half.
#[derive(Clone, Debug)]
pub(crate) struct TreePlru {
    trees: Vec<u64>,
    depth: u32,
}

impl TreePlru {
    /// `ways`: a power of two up to 64.
    pub(crate) fn new(sets: usize, ways: usize) -> Self {
        Self { trees: vec![0; sets], depth: ways.trailing_zeros() }
    }
}

impl Replacement for TreePlru {
    fn touched(&mut self, set: usize, way: usize) {
        let tree = &mut self.trees[set];
        let mut node = 1;
        for level in (0..self.depth).rev() {
            let upper = way >> level & 1;
            *tree = *tree & !(1 << node) | ((1 - upper) as u64) << node;
            node = 2 * node + upper;
        }
    }

    fn filled(&mut self, set: usize, way: usize) {
        self.touched(set, way);
    }

    fn victim(&mut self, set: usize) -> usize {
        let mut node = 1;
        for _ in 0..self.depth {
            node = 2 * node + (self.trees[set] >> node & 1) as usize;
        }
        node - (1 << self.depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bits_point_away_from_the_last_accesses() {
        let mut tree = TreePlru::new(1, 4);
        for way in 0..4 {
            tree.filled(0, way);
        }
        assert_eq!(tree.victim(0), 0, "after 0 1 2 3 the root points down, and there to way 0");
        tree.touched(0, 0);
        assert_eq!(tree.victim(0), 2, "the root now points up, where 3 was last");
        tree.touched(0, 2);
        assert_eq!(tree.victim(0), 1);
        tree.touched(0, 1);
        assert_eq!(tree.victim(0), 3);
        tree.touched(0, 3);
        assert_eq!(tree.victim(0), 0, "true LRU agrees here: 0 2 1 3");
    }

    #[test]
    fn it_differs_from_lru_where_a_tree_must() {
        let mut tree = TreePlru::new(1, 4);
        for way in [0, 1, 2, 3, 0] {
            tree.touched(0, way);
        }
        assert_eq!(tree.victim(0), 2, "LRU would take 1, in the half of the last access");
    }
}
