//! What is counted in the tiles of a trace as they pass to the replay. The metrics are defined in the claim file.

use std::sync::atomic::{AtomicU64, Ordering};
use tracer::{FrameTracer, NO_HIT, NOT_CAST, RayKind, Tile, TileSource, Topology, TraceHeader};

/// A count over all tiles of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Audit {
    LeavesTestedTwice,
    RestartsAbovePushDown,
    ReflectionHits,
    ReflectionMisses,
}

impl Audit {
    pub(super) const ALL: [Self; 4] =
        [Self::LeavesTestedTwice, Self::RestartsAbovePushDown, Self::ReflectionHits, Self::ReflectionMisses];

    /// The metric.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::LeavesTestedTwice => "leaves_tested_twice",
            Self::RestartsAbovePushDown => "restarts_above_push_down",
            Self::ReflectionHits => "reflection_hits",
            Self::ReflectionMisses => "reflection_misses",
        }
    }

    pub(super) fn named(metric: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|audit| audit.name() == metric)
    }

    /// Of one tile; `judge` is the same tile under a full stack.
    fn of_tile(self, header: &TraceHeader, topology: &Topology, tile: &Tile, judge: &Tile) -> u64 {
        let sets = tile.ray_sets.iter();
        let reflections = || {
            let of_kind = header.ray_sets.iter().zip(&tile.ray_sets);
            of_kind.filter(|(id, _)| id.kind == RayKind::Reflection).map(|(_, set)| set)
        };
        match self {
            Self::LeavesTestedTwice => {
                sets.map(|set| tracer::audit::leaves_tested_twice(topology, set)).sum()
            }
            Self::RestartsAbovePushDown => judge
                .ray_sets
                .iter()
                .zip(sets)
                .map(|(stack, set)| tracer::audit::restarts_above_push_down(topology, stack, set))
                .sum(),
            Self::ReflectionHits => {
                reflections().flat_map(|set| &set.hits).filter(|&&hit| hit < NOT_CAST).count() as u64
            }
            Self::ReflectionMisses => {
                let primary = &tile.ray_sets[0].hits;
                let of_hits = reflections().flat_map(|set| set.hits.iter().zip(primary));
                of_hits.filter(|&(&hit, &from)| hit == NO_HIT && from < NOT_CAST).count() as u64
            }
        }
    }
}

/// Tiles of a tracer, audited as they pass.
pub(super) struct Audited<'a> {
    tracer: FrameTracer<'a>,
    /// The same frame under a full stack, where an audit asks for it.
    stack: Option<FrameTracer<'a>>,
    audits: Vec<(Audit, AtomicU64)>,
}

impl<'a> Audited<'a> {
    pub(super) fn new(tracer: FrameTracer<'a>, stack: Option<FrameTracer<'a>>, audits: &[Audit]) -> Self {
        let audits = audits.iter().map(|&audit| (audit, AtomicU64::new(0))).collect();
        Self { tracer, stack, audits }
    }

    /// Makes every tile for the audits' sake alone.
    pub(super) fn drain(&self) -> Result<(), tracer::Error> {
        let mut tile = Tile::default();
        (0..self.header().frame.tiles()).try_for_each(|index| self.tile(index, &mut tile))
    }

    /// What was counted.
    pub(super) fn found(self) -> Vec<(Audit, u64)> {
        self.audits.into_iter().map(|(audit, found)| (audit, found.into_inner())).collect()
    }
}

impl TileSource for Audited<'_> {
    fn header(&self) -> &TraceHeader {
        self.tracer.header()
    }

    fn topology(&self) -> &Topology {
        self.tracer.topology()
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), tracer::Error> {
        self.tracer.tile(index, tile)?;
        if self.audits.is_empty() {
            return Ok(());
        }
        let mut judge = Tile::default();
        if let Some(stack) = &self.stack {
            stack.tile(index, &mut judge)?;
        }
        for (audit, sum) in &self.audits {
            let found = audit.of_tile(self.header(), self.topology(), tile, &judge);
            sum.fetch_add(found, Ordering::Relaxed);
        }
        Ok(())
    }

    fn stalls(&self) -> u64 {
        self.tracer.stalls()
    }
}
