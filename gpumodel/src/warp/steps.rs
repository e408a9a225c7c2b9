//! What the warps of a tile do before anything has an address: which lanes take which step together, and on which records.
//!
//! This part of a replay does not depend on layouts, caches or costs, so that many variants of a frame share it. A step is kept
//! as a header and its distinct ids; steps on a stack as its distinct entries, each with the lanes that use it.

use super::distinct::Distinct;
use super::levels::Levels;
use super::lockstep::{AnyHits, Body, Lockstep};
use super::pairs::Seconds;
use super::ray_unit::{UnitTally, UnitTests};
use crate::replay::ReplayConfig;
use crate::schedule::{HELPER, LaneMap};
use std::ops::Range;
use tracer::{
    DECIDED_BY_MICROMAP, LoopStructure, NOT_CAST, Op, Query, RaySet, Tile, TileRect, Topology, TraceHeader,
};

/// Steps and trips of a ray set, by how many warps and how many lanes took them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    /// Steps of whole warps, by [`Op`].
    pub(crate) warp_steps: [u64; Op::ALL.len()],
    /// Steps of single lanes, by [`Op`].
    pub(crate) lane_steps: [u64; Op::ALL.len()],
    /// Lanes in a node step at a root or a wide BLAS's node: they have no sibling to read.
    pub(crate) root_lanes: u64,
    /// Node steps of whole warps in the TLAS, and of single lanes; where both levels are of one kind, steps that are in either.
    pub(crate) tlas_steps: (u64, u64),
    /// Triangle steps of whole warps, and of single lanes, that read no record, as the other triangle of a pair had brought it.
    pub(crate) second_steps: (u64, u64),
    /// Node steps in which some lane had a sibling to read.
    pub(crate) sibling_steps: u64,
    pub(crate) warp_trips: u64,
    pub(crate) lane_trips: u64,
    pub(crate) unit: UnitTally,
    /// Any-hit steps in which some lane ran the shader, and those lanes.
    pub(crate) any_hit_shaders: (u64, u64),
    /// Rays whose last step was one, as its hit answers the query.
    pub(crate) answered_rays: u64,
    /// Warps that traced any ray of the set, and those rays.
    pub(crate) warps: u64,
    pub(crate) rays: u64,
    /// Warps with a hit to shade, and those hits.
    pub(crate) shaded_warps: u64,
    pub(crate) shaded_lanes: u64,
}

impl Tally {
    fn all_lane_steps(&self) -> u64 {
        self.lane_steps.iter().sum()
    }
}

/// How the rays of a warp go through their steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Walk {
    loops: (LoopStructure, AnyHits),
    stack_in_memory: bool,
    levels: Levels,
    seconds: Seconds,
    unit: Option<UnitTests>,
}

impl Walk {
    pub(crate) fn new(header: &TraceHeader, topology: &Topology, config: &ReplayConfig) -> Self {
        let (levels, seconds) = (Levels::new(header, topology), Seconds::new(topology));
        let Some(unit) = config.gpu.ray_unit_for(header) else {
            let stack_in_memory = header.stack_entries > 0;
            let loops = (header.loop_structure, AnyHits::InLoop);
            return Self { loops, stack_in_memory, levels, seconds, unit: None };
        };
        // A unit that walks tests nodes and triangles as its rays come to them, and keeps their stacks itself.
        let by_shader = !unit.walks();
        Self {
            loops: (if by_shader { header.loop_structure } else { LoopStructure::IfIf }, AnyHits::OnReturn),
            stack_in_memory: by_shader && header.stack_entries > 0,
            levels,
            seconds,
            unit: Some(UnitTests::new(unit, config.gpu.cores.warp_width, topology)),
        }
    }

    /// Whether lanes wait while others step: not where a unit takes each ray by itself.
    pub(crate) fn in_lockstep(&self) -> bool {
        self.unit.as_ref().is_none_or(UnitTests::in_lockstep)
    }
}

/// Sums over the warps of a tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct TileTally {
    /// By ray set.
    pub(crate) sets: Vec<Tally>,
    pub(crate) warps: u64,
    /// Lanes that have a pixel.
    pub(crate) lanes: u64,
}

/// One warp's steps.
#[derive(Debug, Default)]
pub(crate) struct WarpSteps {
    /// The first `used` are those of the steps.
    words: Vec<u32>,
    used: usize,
    pub(crate) sets: Vec<SetSteps>,
    /// Triangles to shade, set by set.
    shaded: Vec<u32>,
    /// The ray of each lane within the tile, or [`HELPER`].
    pub(crate) rays: Vec<u32>,
}

/// The steps of one ray set.
#[derive(Debug, Default)]
pub(crate) struct SetSteps {
    words: Range<usize>,
    /// Whether the warp traced any ray of the set.
    pub(crate) traced: bool,
    /// Steps of the warp times lanes that traced a ray of the set, and steps of these lanes.
    pub(crate) lane_slots: [u64; 2],
    /// Trips of loops.
    pub(crate) trips: u64,
    /// Steps by [`Op`], those among them that touch no memory and so are not in the words.
    pub(crate) taken: [u64; Op::ALL.len()],
    /// Distinct triangles to shade, and for how many lanes.
    shaded: Range<usize>,
    pub(crate) shaded_lanes: u32,
}

/// A step of a warp.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WarpStep<'a> {
    pub(crate) op: Op,
    /// Lanes that take it.
    pub(crate) lanes: u32,
    /// Of them, those that read no sibling, at a root or at a wide BLAS's node; and those at the second triangle of a pair, which read nothing.
    pub(crate) root_lanes: u32,
    /// Of them, those that run an any-hit shader.
    pub(crate) shader_lanes: u32,
    /// Distinct ids in order of first appearance; for Push and Pop three words each: entry and lane mask, low half first.
    pub(crate) records: &'a [u32],
}

const OP_SHIFT: u32 = 29;
/// Lanes that read nothing or less than others, or run a shader.
const PART_SHIFT: u32 = 16;
const LANES_SHIFT: u32 = 8;
const FIELD: u32 = 0x7F;
/// The most words of a step: the header, and three for each stack entry.
const STEP_WORDS: usize = 1 + 3 * 64;

impl WarpSteps {
    /// The distinct triangles that the hits of a ray set shade.
    pub(crate) fn shaded(&self, set: usize) -> &[u32] {
        &self.shaded[self.sets[set].shaded.clone()]
    }

    /// The steps of one ray set.
    #[inline]
    pub(crate) fn steps(&self, set: usize) -> impl Iterator<Item = WarpStep<'_>> {
        let mut words = &self.words[self.sets[set].words.clone()];
        std::iter::from_fn(move || {
            let (&header, rest) = words.split_first()?;
            let op = Op::ALL[(header >> OP_SHIFT) as usize];
            let count = (header & FIELD) as usize;
            let per_record = if matches!(op, Op::Push | Op::Pop) { 3 } else { 1 };
            let (records, rest) = rest.split_at(count * per_record);
            words = rest;
            let (lanes, part) = (header >> LANES_SHIFT & FIELD, header >> PART_SHIFT & FIELD);
            let (root_lanes, shader_lanes) = if op == Op::AnyHit { (0, part) } else { (part, 0) };
            Some(WarpStep { op, lanes, root_lanes, shader_lanes, records })
        })
    }
}

/// Runs the warps of tiles in lockstep.
pub(crate) struct Stepper {
    lockstep: Lockstep,
    distinct: Distinct,
    warp: WarpSteps,
}

impl Stepper {
    pub(crate) fn new() -> Self {
        Self { lockstep: Lockstep::new(), distinct: Distinct::new(), warp: WarpSteps::default() }
    }

    /// Hands every warp of a checked tile to `take`; ray sets that are not `wanted` are passed over.
    ///
    /// # Errors
    /// A sentence when the tile holds steps that no modelled shader takes, or what `take` says.
    pub(crate) fn run(
        &mut self,
        header: &TraceHeader,
        (walk, wanted): (&Walk, &[bool]),
        lane_map: &LaneMap,
        (tile, rect): (&Tile, TileRect),
        mut take: impl FnMut(&WarpSteps) -> Result<(), String>,
    ) -> Result<TileTally, String> {
        let sets = header.ray_sets.len();
        let mut tally = TileTally { sets: vec![Tally::default(); sets], ..TileTally::default() };
        for rays in lane_map.warps(rect) {
            self.warp(header, (walk, wanted), tile, rays, &mut tally)?;
            take(&self.warp)?;
        }
        Ok(tally)
    }

    fn warp(
        &mut self,
        header: &TraceHeader,
        (walk, wanted): (&Walk, &[bool]),
        tile: &Tile,
        rays: Vec<u32>,
        tally: &mut TileTally,
    ) -> Result<(), String> {
        let Self { lockstep, distinct, warp } = self;
        let ids = &header.ray_sets;
        warp.used = 0;
        warp.sets.clear();
        warp.shaded.clear();
        warp.rays = rays;
        let lanes = || (0_usize..).zip(&warp.rays).filter(|&(_, &ray)| ray != HELPER);
        for (index, (set, &id)) in tile.ray_sets.iter().zip(ids).enumerate() {
            let start = warp.used;
            let source = id.source(ids).map(|source| tile.ray_sets[source].hits.as_slice());
            // As a mask of lanes.
            let traced = if wanted[index] {
                let traced = lanes().filter(|&(_, &ray)| is_traced(set, source, ray as usize));
                traced.fold(0_u64, |mask, (lane, _)| mask | 1 << lane)
            } else {
                0
            };
            let count = u64::from(traced.count_ones());
            let tally = &mut tally.sets[index];
            let (trips, taken, lane_steps) = (tally.warp_trips, tally.warp_steps, tally.all_lane_steps());
            if count > 0 {
                tally.warps += 1;
                tally.rays += count;
                let rays = || lanes().filter(|&(lane, _)| traced >> lane & 1 != 0);
                let ranges = rays().map(|(lane, &ray)| {
                    let range = set.range(ray as usize);
                    (lane, range.start as u32, range.end as u32)
                });
                let (words, used) = (&mut warp.words, &mut warp.used);
                let mut body = Recorder { walk, words, used, distinct, tally: &mut *tally };
                lockstep.run(walk.loops, &set.steps, ranges, &mut body)?;
                if id.kind.query(header.shadow_query) == Query::Any {
                    let answered = rays().filter(|&(_, &ray)| ends_in_any_hit(set, ray as usize));
                    tally.answered_rays += answered.count() as u64;
                }
            }
            let steps = std::array::from_fn(|op| tally.warp_steps[op] - taken[op]);
            let first_shaded = warp.shaded.len();
            let hits = lanes().map(|(_, &ray)| set.hits[ray as usize]).filter(|&hit| hit < NOT_CAST);
            let shaded_lanes = if id.kind.is_shaded() { hits.clone().count() as u32 } else { 0 };
            if shaded_lanes > 0 {
                let mut triangles = [0; 64];
                let found = distinct.filter(hits, &mut triangles);
                warp.shaded.extend_from_slice(&triangles[..found]);
                tally.shaded_warps += 1;
                tally.shaded_lanes += u64::from(shaded_lanes);
            }
            warp.sets.push(SetSteps {
                words: start..warp.used,
                traced: count > 0,
                lane_slots: [steps.iter().sum::<u64>() * count, tally.all_lane_steps() - lane_steps],
                trips: tally.warp_trips - trips,
                taken: steps,
                shaded: first_shaded..warp.shaded.len(),
                shaded_lanes,
            });
        }
        tally.warps += 1;
        tally.lanes += lanes().count() as u64;
        Ok(())
    }
}

/// A ray that misses the box of a kd-tree takes no step, and yet has been made. `source` are the hits that the set's rays start from, where
/// the frame has those.
fn is_traced(set: &RaySet, source: Option<&[u32]>, ray: usize) -> bool {
    let has_steps = !set.range(ray).is_empty();
    let due = source.is_none_or(|hits| hits[ray] < NOT_CAST) && set.hits[ray] != NOT_CAST;
    has_steps || due
}

/// Whether a ray ended with a hit that its last step accepted.
fn ends_in_any_hit(set: &RaySet, ray: usize) -> bool {
    let last = set.steps[set.range(ray)].last();
    last.is_some_and(|step| step.op() == Op::AnyHit) && set.hits[ray] < NOT_CAST
}

/// Writes steps into words.
struct Recorder<'a> {
    walk: &'a Walk,
    words: &'a mut Vec<u32>,
    used: &'a mut usize,
    distinct: &'a mut Distinct,
    tally: &'a mut Tally,
}

impl Recorder<'_> {
    /// Room for the next step. It keeps its old content, so that no step pays for clearing it.
    #[inline(always)]
    fn room(&mut self) -> &mut [u32; STEP_WORDS] {
        if self.words.len() - *self.used < STEP_WORDS {
            self.words.resize(2 * self.words.len() + STEP_WORDS, 0);
        }
        self.words[*self.used..].first_chunk_mut().expect("there is room for a step")
    }

    /// Joins groups that are at the same stack entry.
    fn stack(&mut self, header: u32, lanes: &[u64], ids: &[u32]) {
        let room = self.room();
        let groups = room[1..].as_chunks_mut::<3>().0;
        let mut count = 0;
        for (&lanes, &entry) in lanes.iter().zip(ids) {
            let (low, high) = (lanes as u32, (lanes >> 32) as u32);
            match groups[..count].iter_mut().find(|group| group[0] == entry) {
                Some(group) => {
                    group[1] |= low;
                    group[2] |= high;
                }
                None => {
                    groups[count] = [entry, low, high];
                    count += 1;
                }
            }
        }
        room[0] = header | count as u32;
        *self.used += 1 + 3 * count;
    }
}

impl Body for Recorder<'_> {
    #[inline(always)]
    fn trip(&mut self, lanes: u32) {
        self.tally.warp_trips += 1;
        self.tally.lane_trips += u64::from(lanes);
    }

    #[inline(always)]
    fn step(&mut self, op: Op, lanes: &[u64], ids: &[u32]) -> Result<(), String> {
        if op == Op::Node && self.walk.levels.are_unlike() {
            self.step_by_level(lanes, ids);
        } else {
            self.record(op, lanes, ids);
        }
        Ok(())
    }
}

impl Recorder<'_> {
    /// A node step in both levels is a step in one after the other, as their nodes are read and tested by different instructions.
    fn step_by_level(&mut self, lanes: &[u64], ids: &[u32]) {
        let levels = self.walk.levels;
        for in_tlas in [true, false] {
            let (mut of_level, mut at, mut count) = ([0; 64], [0; 64], 0);
            for (&lanes, &id) in lanes.iter().zip(ids).filter(|&(_, &id)| levels.in_tlas(id) == in_tlas) {
                (of_level[count], at[count]) = (lanes, id);
                count += 1;
            }
            if count > 0 {
                self.record(Op::Node, &of_level[..count], &at[..count]);
            }
        }
    }

    #[inline(always)]
    fn record(&mut self, op: Op, lanes: &[u64], ids: &[u32]) {
        let active = lanes.iter().fold(0, |all, lanes| all | lanes).count_ones();
        self.tally.warp_steps[op as usize] += 1;
        self.tally.lane_steps[op as usize] += u64::from(active);
        if let Some(unit) = self.walk.unit.as_ref().filter(|unit| unit.tests(op)) {
            unit.count(op, lanes, ids, &mut self.tally.unit);
        }
        let header = (op as u32) << OP_SHIFT | active << LANES_SHIFT;
        match op {
            Op::Restart => {}
            Op::Push | Op::Pop if self.walk.stack_in_memory => self.stack(header, lanes, ids),
            Op::Push | Op::Pop => {}
            Op::Primitive if !self.walk.seconds.is_empty() => {
                let seconds = &self.walk.seconds;
                let at_seconds = lanes.iter().zip(ids).filter(|&(_, &id)| seconds.contains(id));
                let reading_none = at_seconds.fold(0, |all, (lanes, _)| all | lanes).count_ones();
                self.tally.second_steps.0 += u64::from(reading_none == active);
                self.tally.second_steps.1 += u64::from(reading_none);
                let firsts = ids.iter().copied().filter(|&id| !seconds.contains(id));
                self.room();
                let (head, rest) = self.words[*self.used..].split_at_mut(1);
                let out = rest.first_chunk_mut().expect("there is room for a step");
                let found = self.distinct.filter(firsts, out);
                head[0] = header | reading_none << PART_SHIFT | found as u32;
                *self.used += 1 + found;
            }
            _ => {
                let levels = self.walk.levels;
                let lanes_where = |is_meant: &dyn Fn(u32) -> bool| {
                    let met = lanes.iter().zip(ids).filter(|&(_, &id)| is_meant(id));
                    met.fold(0, |all, (lanes, _)| all | lanes).count_ones()
                };
                let roots = if op == Op::Node { lanes_where(&|id| levels.is_alone(id)) } else { 0 };
                let has_tlas = op == Op::Node && levels.are_two();
                let in_tlas = if has_tlas { lanes_where(&|id| levels.in_tlas(id)) } else { 0 };
                self.tally.tlas_steps.0 += u64::from(in_tlas > 0);
                self.tally.tlas_steps.1 += u64::from(in_tlas);
                self.tally.root_lanes += u64::from(roots);
                self.tally.sibling_steps += u64::from(op == Op::Node && roots < active);
                let part =
                    if op == Op::AnyHit { lanes_where(&|id| id & DECIDED_BY_MICROMAP == 0) } else { roots };
                if op == Op::AnyHit {
                    let (warps, shader_lanes) = &mut self.tally.any_hit_shaders;
                    *warps += u64::from(part > 0);
                    *shader_lanes += u64::from(part);
                }
                self.room();
                let (head, rest) = self.words[*self.used..].split_at_mut(1);
                let out = rest.first_chunk_mut().expect("there is room for a step");
                let found = self.distinct.filter(ids.iter().copied(), out);
                head[0] = header | part << PART_SHIFT | found as u32;
                *self.used += 1 + found;
            }
        }
    }
}
