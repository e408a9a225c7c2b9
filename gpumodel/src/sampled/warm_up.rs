//! What the caches hold before a block.
//!
//! The tiles that are run before a block fill the cores, but few caches. So the caches first see what the tiles before those read and
//! what images they write, each line once, tile after tile, in no time (functional warming; Wunderlich et al. 2003): backwards from the
//! block, as many tiles as fill the last cache. That takes half as long again, which only pays where variants are compared: what lines a
//! cold cache leaves in doubt is most of what is not known of a difference, and little of what is not known of a frame. Recorded tiles are
//! looked through; those that would have to be traced for it are not.

use crate::error::Error;
use crate::interleave::Interleaver;
use crate::layout::{BufferKind, VEC4_BYTES};
use crate::prepared::Prepared;
use crate::replay::refuse;
use crate::warp::{Emitter, Run, TreeTurns};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use tracer::{DECIDED_BY_MICROMAP, NOT_CAST, Op, Step, Tile, TileRect, TileSource, Topology, TraceHeader};

/// So many times as many tiles as are run before a block are looked through before these, at most.
const MOST_TIMES: u32 = 16;

/// What the rays of a tile read, each record once.
#[derive(Default)]
struct Touched {
    steps: Vec<Step>,
    /// Triangles that are shaded.
    shaded: Vec<u32>,
}

/// A set of numbers below a bound.
struct Bits(Vec<u64>);

impl Bits {
    fn below(bound: u64) -> Self {
        Self(vec![0; bound.div_ceil(64) as usize])
    }

    /// Whether the number is new; one beyond the bound is not.
    #[inline]
    fn insert(&mut self, number: u32) -> bool {
        let Self(words) = self;
        let bit = 1 << (number % 64);
        let Some(word) = words.get_mut(number as usize / 64) else { return false };
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }
}

/// A set of steps that read, and of triangles that are shaded.
struct Records {
    steps: [Bits; Op::ALL.len()],
    shaded: Bits,
    positions: u32,
}

impl Records {
    /// Of a frame, none.
    fn new(header: &TraceHeader, topology: &Topology) -> Self {
        let positions = topology.references.len() as u64;
        let ids = |op: Op| match op {
            Op::Node | Op::Up => topology.nodes.len() as u64,
            Op::Primitive => positions,
            // What a micromap decides, behind what a shader does.
            Op::AnyHit => 2 * positions,
            Op::Instance => topology.levels.as_ref().map_or(0, |levels| levels.meshes.len() as u64),
            Op::Push | Op::Pop | Op::Restart => 0,
        };
        Self {
            steps: Op::ALL.map(|op| Bits::below(ids(op))),
            shaded: Bits::below(header.triangles.into()),
            positions: positions as u32,
        }
    }

    #[inline]
    fn insert(&mut self, step: Step) -> bool {
        let id = match step.op() {
            Op::AnyHit if step.id() & DECIDED_BY_MICROMAP != 0 => {
                self.positions + (step.id() & !DECIDED_BY_MICROMAP)
            }
            _ => step.id(),
        };
        self.steps[step.op() as usize].insert(id)
    }
}

/// Tiles that blocks look back at; each is made once.
pub(super) struct WarmUp<'a, S> {
    source: &'a S,
    touched: Vec<OnceLock<Arc<Touched>>>,
    /// Tiles whose memory is used again.
    tiles: Mutex<Vec<Tile>>,
}

impl<'a, S: TileSource> WarmUp<'a, S> {
    pub(super) fn new(source: &'a S) -> Self {
        let tiles = source.header().frame.tiles();
        Self { source, touched: (0..tiles).map(|_| OnceLock::new()).collect(), tiles: Mutex::default() }
    }

    fn touched(&self, index: u32) -> Result<Arc<Touched>, Error> {
        let place = &self.touched[index as usize];
        if let Some(touched) = place.get() {
            return Ok(Arc::clone(touched));
        }
        let free = || self.tiles.lock().unwrap_or_else(PoisonError::into_inner);
        let mut tile = free().pop().unwrap_or_default();
        self.source.tile(index, &mut tile)?;
        let header = self.source.header();
        let (mut touched, mut records) = (Touched::default(), Records::new(header, self.source.topology()));
        for (set, id) in tile.ray_sets.iter().zip(&header.ray_sets) {
            touched.steps.extend(set.steps.iter().copied().filter(|&step| records.insert(step)));
            if id.kind.is_shaded() {
                let hits = set.hits.iter().copied().filter(|&hit| hit < NOT_CAST);
                touched.shaded.extend(hits.filter(|&hit| records.shaded.insert(hit)));
            }
        }
        free().push(tile);
        Ok(Arc::clone(place.get_or_init(|| Arc::new(touched))))
    }

    /// Fills the caches of the engines of the variants before tile `end`, from which on `block_tiles` are run before a block. Answers
    /// whether the caches have seen the frame from its start.
    ///
    /// # Errors
    /// When a tile cannot be made, or contradicts itself.
    pub(super) fn fill(
        &self,
        (end, block_tiles): (u32, u32),
        variants: &[&Prepared<'_>],
        engines: &mut [Interleaver],
    ) -> Result<bool, Error> {
        if variants.len() < 2 || !self.source.is_recorded() {
            return Ok(end == 0);
        }
        let first = end.saturating_sub(MOST_TIMES * block_tiles);
        let frame = self.source.header().frame;
        let mut filling: Vec<Filling<'_>> = variants.iter().map(|variant| Filling::new(variant)).collect();
        let mut seen = Records::new(self.source.header(), self.source.topology());
        let mut from = end;
        while from > first && filling.iter().any(Filling::has_room) {
            from -= 1;
            let touched = self.touched(from)?;
            // The latest tile that reads a record decides when that was read last.
            let new = Touched {
                steps: touched.steps.iter().copied().filter(|&step| seen.insert(step)).collect(),
                shaded: touched.shaded.iter().copied().filter(|&id| seen.shaded.insert(id)).collect(),
            };
            for filling in filling.iter_mut().filter(|filling| filling.has_room()) {
                filling
                    .add(&new, from, frame.tile(from))
                    .map_err(|problem| refuse(self.source.header(), problem))?;
            }
        }
        for (engine, filling) in engines.iter_mut().zip(filling) {
            engine.touch(filling.accesses.into_iter().rev());
        }
        Ok(from == 0)
    }
}

/// What fills the caches of a variant.
struct Filling<'a> {
    variant: &'a Prepared<'a>,
    emitter: Emitter,
    lines: Bits,
    /// The latest first.
    accesses: Vec<(Run, u32)>,
}

impl<'a> Filling<'a> {
    fn new(variant: &'a Prepared<'a>) -> Self {
        let emitter = Emitter::new(TreeTurns::Joined);
        let buffers = &variant.program.buffers;
        let lines = Bits::below((buffers.end >> (buffers.tree.line_shift + VEC4_BYTES.ilog2())) + 1);
        Self { variant, emitter, lines, accesses: Vec::new() }
    }

    fn has_room(&self) -> bool {
        (self.accesses.len() as u64) < self.variant.last_cache_lines()
    }

    /// Adds what tile `index` writes, and reads that later tiles do not.
    fn add(&mut self, touched: &Touched, index: u32, rect: TileRect) -> Result<(), String> {
        let Touched { steps, shaded } = touched;
        let stream = self.emitter.touch(&self.variant.program, (steps, shaded), (index, rect))?;
        for (run, lines) in stream.runs() {
            // Texels have lines of another size.
            let Some((pass, kind, write)) =
                Run::of_key(run.key()).filter(|of| of.1 != BufferKind::Attachment)
            else {
                continue;
            };
            let new = lines.iter().copied().filter(|&line| self.lines.insert(line));
            self.accesses.extend(new.map(|line| (Run::new(pass, kind, write, 1, 1), line)));
        }
        Ok(())
    }
}
