//! The two streams of a warp: what it asks of the tree and its stacks, and all else.
//!
//! Variants of a frame in which the tree lies alike, whatever their triangles do, have the first in common.

use super::stream::{Share, StreamWriter, TileStream};
use crate::counters::{IssueCounters, Pass};

/// Where the turns on the tree go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TreeTurns {
    /// Into one stream with all others.
    Joined,
    /// Into a stream of their own.
    Apart,
    /// Nowhere: they are in the stream of another variant.
    Elsewhere,
}

/// One of the two streams.
#[derive(Default)]
pub(super) struct Half {
    pub(super) writer: StreamWriter,
    pub(super) warp_ends: Vec<usize>,
    pub(super) issue: [IssueCounters; Pass::COUNT],
}

impl Half {
    pub(super) fn take(&mut self) -> TileStream {
        TileStream {
            words: self.writer.take(),
            warp_ends: std::mem::take(&mut self.warp_ends),
            issue: std::mem::take(&mut self.issue),
            ..TileStream::default()
        }
    }
}

/// Where the turns of a warp go over from one stream to the other.
pub(super) struct Seam {
    tree_turns: TreeTurns,
    /// The stream of the warp's latest turn.
    at: Option<Share>,
    /// Where the warp's own words begin.
    own_start: usize,
}

impl Seam {
    pub(super) fn new(tree_turns: TreeTurns) -> Self {
        Self { tree_turns, at: None, own_start: 0 }
    }

    #[inline(always)]
    pub(super) fn tree_turns(&self) -> TreeTurns {
        self.tree_turns
    }

    /// The next warp begins, its own words at `own_start`.
    pub(super) fn end_warp(&mut self, own_start: usize) {
        (self.at, self.own_start) = (None, own_start);
    }

    /// The latest turn is in the stream of `share`.
    #[inline(always)]
    pub(super) fn turn(&mut self, share: Share, tree: &mut StreamWriter, own: &mut StreamWriter) {
        if self.at == Some(share) || self.tree_turns == TreeTurns::Joined {
            return;
        }
        match (self.at, share) {
            (None, Share::Own) => own.begin(self.own_start),
            (Some(_), Share::Tree) => own.cross(),
            (Some(_), Share::Own) if self.tree_turns == TreeTurns::Apart => tree.cross(),
            _ => {}
        }
        self.at = Some(share);
    }
}
