//! From the steps of warps to the lines that their loads and stores touch, for one variant of a frame.

mod any_hit;
#[cfg(test)]
mod tests;
mod touched;

use super::distinct::Distinct;
use super::program::{INDEX_BYTES, NodeReads, Program};
use super::seam::{Half, Seam, TreeTurns};
use super::steps::{TileTally, WarpStep, WarpSteps};
use super::stream::{Run, Share, StreamWriter, TileStream, TileStreams, Turn};
use crate::config::Cost;
use crate::counters::{IssueCounters, Pass};
use crate::layout::{BufferKind, PIXEL_BYTES, Reads, STACK_ENTRY_BYTES, VEC4_BYTES};
use crate::schedule::{HELPER, z_order};
use std::sync::Arc;
use tracer::{Op, TILE_RAYS, TileRect};

/// Collects what warps ask of the caches, tile by tile.
pub(crate) struct Emitter {
    distinct: Distinct,
    /// Addresses that a step reads from, kept here so that no step clears room for them.
    records: [u32; 64],
    tree: Half,
    own: Half,
    seam: Seam,
    turns: Turns,
}

impl Emitter {
    pub(crate) fn new(tree_turns: TreeTurns) -> Self {
        Self {
            distinct: Distinct::new(),
            records: [0; 64],
            tree: Half::default(),
            own: Half::default(),
            seam: Seam::new(tree_turns),
            turns: Turns::default(),
        }
    }

    /// One warp that traces, of tile `index` at `rect`.
    ///
    /// # Errors
    /// A sentence when a step names what does not exist.
    pub(crate) fn trace(
        &mut self,
        program: &Program,
        warp: &WarpSteps,
        index: u32,
        rect: TileRect,
    ) -> Result<(), String> {
        if program.attachments > 0 {
            self.pixels(program, Pass::Output, BufferKind::Attachment, &warp.rays, index, rect);
        }
        self.trace_rays(program, warp)?;
        self.turns.spend(program.output);
        if program.writes_image {
            self.pixels(program, Pass::Output, BufferKind::Image, &warp.rays, index, rect);
        }
        if !program.writes_image {
            let pixels = warp.rays.iter().filter(|&&ray| ray != HELPER).count() as u32;
            self.turns.open.output_bytes += pixels * program.output_bytes;
        }
        self.end_warp(program);
        Ok(())
    }

    /// The steps of a warp's rays, and the shading of what they hit.
    ///
    /// # Errors
    /// As [`Self::trace`].
    pub(crate) fn trace_rays(&mut self, program: &Program, warp: &WarpSteps) -> Result<(), String> {
        for (set, &kind) in program.lanes.kinds.iter().enumerate().filter(|&(_, &kind)| program.traces(kind))
        {
            let pass = Pass::of(kind);
            if program.keeps_turns {
                self.timed_steps(program, pass, warp, set)?;
            } else {
                for step in warp.steps(set) {
                    self.step(program, pass, step)?;
                }
            }
            // Shading comes between a ray and those that start at its hit.
            let shaded_lanes = warp.sets[set].shaded_lanes;
            if let Some((pass, cost)) = program.shading(kind).filter(|_| shaded_lanes > 0) {
                self.turns.spend(cost);
                let buffers = &program.buffers;
                let triangles = warp.shaded(set).iter().copied();
                let mut part = self.part(program, pass, Share::Own);
                part.by_ray_unit = false;
                part.locate(triangles, |triangle| buffers.shading(triangle))
                    .map_err(|triangle| missing("triangle", triangle))?
                    .read_records(buffers.shading_kind, buffers.shading_reads, shaded_lanes);
                part.end_turn(true);
            }
        }
        Ok(())
    }

    /// A load or store of a warp outside of any traversal: `bytes` of each lane at these addresses, in bytes. Textures are read quad by quad.
    pub(crate) fn access(
        &mut self,
        program: &Program,
        pass: Pass,
        (kind, write, bytes): (BufferKind, bool, u32),
        addresses: impl Iterator<Item = u64> + Clone,
    ) {
        let shift = program.line_shift(kind, write);
        let lines = addresses.map(|address| (address >> shift) as u32);
        let mut part = self.part(program, pass, Share::Own);
        part.by_ray_unit = false;
        let access = Access { kind, write, bytes, repeats: 1 };
        if kind != BufferKind::Attachment {
            let active = lines.clone().count() as u32;
            if active > 0 {
                part.touch(access, lines, active);
            }
            return;
        }
        let mut left = lines;
        loop {
            let quad = left.clone().take(QUAD);
            let active = quad.clone().count() as u32;
            if active == 0 {
                break;
            }
            let samples = (f64::from(active) / program.texture_samples_per_clock).ceil() as u32;
            part.sample(access, quad, active, samples);
            left.nth(active as usize - 1);
        }
    }

    /// Ends the turn of a warp outside of any traversal.
    pub(crate) fn end_turn(&mut self, program: &Program, pass: Pass, waits: bool) {
        self.part(program, pass, Share::Own).end_turn(waits);
    }

    /// The steps of a ray set, with what each costs. Loop control, and steps that touch no memory, are shared out evenly.
    fn timed_steps(
        &mut self,
        program: &Program,
        pass: Pass,
        warp: &WarpSteps,
        set: usize,
    ) -> Result<(), String> {
        if warp.sets[set].traced {
            self.turns.spend(program.setup(program.lanes.kinds[set]));
        }
        let (overhead, steps) = program.overhead(&warp.sets[set]);
        let share = |cost: u32, step: u64| (u64::from(cost) * step / steps.max(1)) as u32;
        for (index, step) in (0..).zip(warp.steps(set)) {
            let of = |cost: u32| share(cost, index + 1) - share(cost, index);
            self.turns.spend(program.step_cost(step));
            self.turns.spend(Cost { alu: of(overhead.alu), efu: of(overhead.efu) });
            self.step(program, pass, step)?;
        }
        if steps == 0 {
            self.turns.spend(overhead);
        }
        Ok(())
    }

    /// A warp of a full-screen quad that reads the image.
    pub(crate) fn present(&mut self, program: &Program, rays: &[u32], index: u32, rect: TileRect) {
        self.turns.spend(program.present);
        self.pixels(program, Pass::Present, BufferKind::Image, rays, index, rect);
        let pixels = rays.iter().filter(|&&ray| ray != HELPER).count() as u32;
        self.turns.open.output_bytes += pixels * program.output_bytes;
        self.end_warp(program);
    }

    /// A run of lines that fixed-function hardware reads.
    pub(crate) fn fetch(&mut self, program: &Program, pass: Pass, kind: BufferKind, lines: &[u32]) {
        let mut part = self.part(program, pass, Share::Own);
        let found = part.distinct.filter(lines.iter().copied(), part.writer.lines());
        part.writer.push(Run::new(pass, kind, false, found, 1).with_port_cycles(found as u32));
        part.counters.line_requests += found as u64;
        part.counters.line_accesses += found as u64;
        if program.keeps_turns {
            part.turns.load(found as u32);
        }
        part.end_turn(true);
    }

    /// The next warp begins. Its last turn may be one without loads and stores.
    pub(crate) fn end_warp(&mut self, program: &Program) {
        self.tree.warp_ends.push(self.tree.writer.len());
        self.own.warp_ends.push(self.own.writer.len());
        self.seam.end_warp(self.own.writer.len());
        if program.keeps_turns {
            self.turns.end_warp();
        }
    }

    /// The warp issues `cost` before its next loads and stores.
    pub(crate) fn spend(&mut self, cost: Cost) {
        self.turns.spend(cost);
    }

    /// The counters of a pass, for what is not counted by warps.
    pub(crate) fn issue(&mut self, pass: Pass) -> &mut IssueCounters {
        &mut self.own.issue[pass as usize]
    }

    /// What has been collected, with what `tally` says that the warps issued. `tree` is the stream of the turns on the tree where
    /// those are [`TreeTurns::Elsewhere`].
    pub(crate) fn take(
        &mut self,
        program: &Program,
        tally: &TileTally,
        tree: Option<&Arc<TileStream>>,
    ) -> TileStreams {
        program.issue(tally, &mut self.own.issue);
        self.seam.end_warp(0);
        let turns = std::mem::take(&mut self.turns.done);
        let turn_ends = std::mem::take(&mut self.turns.warp_ends);
        let (of_tree, own) = (self.tree.take(), TileStream { turns, turn_ends, ..self.own.take() });
        TileStreams { tree: tree.map_or_else(|| Arc::new(of_tree), Arc::clone), own: Arc::new(own) }
    }

    #[inline(always)]
    fn part<'a>(&'a mut self, program: &'a Program, pass: Pass, share: Share) -> Part<'a> {
        let Self { distinct, records, tree, own, seam, turns } = self;
        let (half, other) = match share {
            Share::Tree => (tree, own),
            Share::Own => (own, tree),
        };
        Part {
            program,
            distinct,
            records,
            located: 0,
            writer: &mut half.writer,
            other: &mut other.writer,
            seam,
            share,
            turns,
            counters: &mut half.issue[pass as usize],
            pass,
            by_ray_unit: program.by_ray_unit && pass.traces(),
        }
    }

    /// Every lane reads or writes its pixel of an image, or reads it of every attachment.
    fn pixels(
        &mut self,
        program: &Program,
        pass: Pass,
        kind: BufferKind,
        rays: &[u32],
        index: u32,
        rect: TileRect,
    ) {
        let write = kind == BufferKind::Image && pass == Pass::Output;
        let images = if kind == BufferKind::Attachment { program.attachments } else { 1 };
        let shift = if write { program.image_line_shift } else { program.texture_line_shift };
        let buffers = &program.buffers;
        // The attachments lie before the image of a compute stage; no technique has both.
        let tile = buffers.image_base + u64::from(index) * u64::from(TILE_RAYS) * PIXEL_BYTES;
        for image in 0..u64::from(images) {
            let base = tile + image * buffers.image_bytes;
            let of_ray = |ray: u32| {
                let offset = u64::from(z_order(ray % rect.width, ray / rect.width)) * PIXEL_BYTES;
                ((base + offset) >> shift) as u32
            };
            let active = rays.iter().filter(|&&ray| ray != HELPER).count() as u32;
            let lines = rays.iter().copied().filter(|&ray| ray != HELPER).map(of_ray);
            let mut part = self.part(program, pass, Share::Own);
            part.touch(Access { kind, write, bytes: PIXEL_BYTES as u32, repeats: 1 }, lines, active);
        }
        self.part(program, pass, Share::Own).end_turn(!write);
    }

    #[inline(always)]
    fn step(&mut self, program: &Program, pass: Pass, step: WarpStep<'_>) -> Result<(), String> {
        let share = match self.seam.tree_turns() {
            TreeTurns::Joined => Share::Own,
            _ if matches!(step.op, Op::Primitive | Op::AnyHit) => Share::Own,
            TreeTurns::Apart => Share::Tree,
            TreeTurns::Elsewhere => {
                if program.takes_turn(step) {
                    self.seam.turn(Share::Tree, &mut self.tree.writer, &mut self.own.writer);
                }
                return Ok(());
            }
        };
        let mut part = self.part(program, pass, share);
        match step.op {
            Op::Node => part.node(step),
            Op::Up => part.record(step.records, step.lanes).map(|()| part.end_turn(true)),
            Op::Primitive => part.primitive(step),
            Op::Push => part.stack(step, true),
            Op::Pop => part.stack(step, false),
            Op::Instance => part.instance(step),
            Op::Restart => Ok(()),
            Op::AnyHit => part.any_hit(step),
        }
    }
}

/// The turns of the tile's warps, where they are kept.
#[derive(Default)]
struct Turns {
    done: Vec<Turn>,
    warp_ends: Vec<usize>,
    /// Not ended yet.
    open: Turn,
}

impl Turns {
    fn spend(&mut self, cost: Cost) {
        self.open.alu += cost.alu;
        self.open.efu += cost.efu;
    }

    fn load(&mut self, port_cycles: u32) {
        self.open.port_cycles += port_cycles;
        self.open.runs += 1;
    }

    fn end(&mut self, waits: bool) {
        self.done.push(Turn { waits, ..std::mem::take(&mut self.open) });
    }

    fn end_warp(&mut self) {
        if self.open != Turn::default() {
            self.end(false);
        }
        self.warp_ends.push(self.done.len());
    }
}

/// What a warp does in one pass.
struct Part<'a> {
    program: &'a Program,
    distinct: &'a mut Distinct,
    /// The first `located` are those of the records to read.
    records: &'a mut [u32; 64],
    located: usize,
    writer: &'a mut StreamWriter,
    /// Of the stream that the part is not in.
    other: &'a mut StreamWriter,
    seam: &'a mut Seam,
    share: Share,
    turns: &'a mut Turns,
    counters: &'a mut IssueCounters,
    pass: Pass,
    /// Lines go to a ray unit, not to registers.
    by_ray_unit: bool,
}

impl Part<'_> {
    /// One load or store of `bytes` per lane on `lines`, or `repeats` of them on the same.
    #[inline(always)]
    fn touch(&mut self, access: Access, lines: impl Iterator<Item = u32> + Clone, active: u32) {
        let found = self.distinct.filter(lines, self.writer.lines());
        self.count(access, found, active);
    }

    /// A texture read of `active` lanes of a quad, which takes the texture unit so many cycles.
    fn sample(&mut self, access: Access, lines: impl Iterator<Item = u32> + Clone, active: u32, cycles: u32) {
        let found = self.distinct.filter(lines, self.writer.lines());
        self.count_cycles(access, found, active, cycles.max(found as u32));
    }

    #[inline(always)]
    fn count(&mut self, access: Access, found: usize, active: u32) {
        let lanes = &self.program.lanes;
        if let Some(port_cycles) = lanes.unit_port_cycles.as_ref().filter(|_| self.by_ray_unit) {
            self.counters.unit_port_lines += u64::from(access.repeats) * found as u64;
            self.push(access, found, active, port_cycles[found]);
            return;
        }
        let words = if self.by_ray_unit { 0 } else { (active * access.bytes) as usize / 4 };
        let port_cycles = (found as u32).max(lanes.port_cycles[words]);
        self.count_cycles(access, found, active, port_cycles);
    }

    #[inline(always)]
    fn count_cycles(&mut self, access: Access, found: usize, active: u32, port_cycles: u32) {
        self.counters.load_store_cycles += u64::from(access.repeats * port_cycles);
        self.push(access, found, active, port_cycles);
    }

    /// Puts a run into the stream whose lines have been found, each of its loads or stores taking its port so many cycles.
    #[inline(always)]
    fn push(&mut self, access: Access, found: usize, active: u32, port_cycles: u32) {
        let Access { kind, write, bytes, repeats } = access;
        let bytes = active * bytes;
        let run = Run::new(self.pass, kind, write, found, repeats);
        self.writer.push(run.with_port_cycles(port_cycles));
        let (repeats, lines) = (u64::from(repeats), found as u64);
        self.counters.memory_instructions += repeats;
        self.counters.line_requests += lines;
        self.counters.line_accesses += repeats * lines;
        // What a ray unit fetches goes to the unit, not to the registers of lanes.
        if !self.by_ray_unit {
            self.counters.lane_bytes += repeats * u64::from(bytes);
        }
        if self.program.keeps_turns {
            self.turns.load(repeats as u32 * port_cycles);
        }
    }

    /// Finds the addresses of at most 64 distinct ids; otherwise answers the first that has none.
    #[inline(always)]
    fn locate(
        &mut self,
        ids: impl Iterator<Item = u32>,
        address: impl Fn(u32) -> Option<u32>,
    ) -> Result<&mut Self, u32> {
        self.located = 0;
        for id in ids {
            self.records[self.located % 64] = address(id).ok_or(id)?;
            self.located += 1;
        }
        Ok(self)
    }

    /// All loads of one record by `active` lanes, at the located addresses.
    #[inline(always)]
    fn read_records(&mut self, kind: BufferKind, reads: Reads, active: u32) {
        let shift = self.program.buffers.tree.line_shift;
        let access = Access { kind, write: false, bytes: VEC4_BYTES as u32, repeats: 1 };
        let (loads, repeats) = if reads.one_line { (1, reads.loads) } else { (reads.loads, 1) };
        for load in 0..loads {
            let offset = reads.offset(load);
            let lines = self.records[..self.located].iter().map(|&record| (record + offset) >> shift);
            let found = self.distinct.filter(lines, self.writer.lines());
            self.count(Access { repeats, ..access }, found, active);
        }
    }

    /// Ends a turn of the warp: the loads since the last one are in flight together, and it waits for them.
    #[inline(always)]
    fn end_turn(&mut self, waits: bool) {
        self.writer.end_turn();
        match self.share {
            Share::Tree => self.seam.turn(Share::Tree, self.writer, self.other),
            Share::Own => self.seam.turn(Share::Own, self.other, self.writer),
        }
        self.counters.turns += 1;
        self.counters.memory_waits += u64::from(waits);
        if self.program.keeps_turns {
            self.turns.end(waits);
        }
    }

    #[inline(always)]
    fn record(&mut self, nodes: &[u32], active: u32) -> Result<(), String> {
        let tree = &self.program.buffers.tree;
        let in_tlas = nodes.first().is_some_and(|&node| self.program.levels.in_tlas(node));
        self.locate(nodes.iter().copied(), |node| tree.node(node))
            .map_err(|node| missing("node", node))?
            .read_records(BufferKind::Node, tree.reads_of(in_tlas), active);
        Ok(())
    }

    /// Records of instances lie among those of nodes, and are counted with them.
    #[inline(always)]
    fn instance(&mut self, step: WarpStep<'_>) -> Result<(), String> {
        let tree = &self.program.buffers.tree;
        let (mut begin, instances) = (0, step.records.iter().copied());
        if let Some((leaf, leaf_vec4s)) = tree.instance_leaf {
            self.locate(instances.clone(), |instance| tree.instance(instance))
                .map_err(|instance| missing("instance", instance))?
                .read_records(BufferKind::Node, leaf, step.lanes);
            self.end_turn(true);
            begin = leaf_vec4s;
        }
        self.by_ray_unit &= !self.program.around_instruction;
        self.locate(instances, |instance| Some(tree.instance(instance)? + begin))
            .map_err(|instance| missing("instance", instance))?
            .read_records(BufferKind::Node, tree.instance_reads, step.lanes);
        self.end_turn(true);
        Ok(())
    }

    #[inline(always)]
    fn node(&mut self, step: WarpStep<'_>) -> Result<(), String> {
        let siblings = step.lanes - step.root_lanes;
        if self.program.nodes != NodeReads::Parent {
            self.record(step.records, step.lanes)?;
        }
        if self.program.nodes != NodeReads::One && siblings > 0 {
            let (tree, levels) = (&self.program.buffers.tree, self.program.levels);
            let nodes = step.records.iter().copied().filter(|&node| !levels.is_alone(node));
            let located = if self.program.nodes == NodeReads::Pair {
                self.locate(nodes, |node| tree.node(node + 1))
                    .map_err(|node| missing("sibling of node", node))?
            } else {
                self.locate(nodes, |node| tree.node(node)).map_err(|node| missing("parent of node", node))?
            };
            // Only binary nodes have siblings: those of the TLAS, where the levels are unlike.
            located.read_records(BufferKind::Node, tree.reads_of(levels.are_unlike()), siblings);
        }
        if self.program.takes_turn(step) {
            self.end_turn(true);
        }
        Ok(())
    }

    #[inline(always)]
    fn primitive(&mut self, step: WarpStep<'_>) -> Result<(), String> {
        let (buffers, active) = (&self.program.buffers, step.lanes - step.root_lanes);
        if !self.program.takes_turn(step) {
            return Ok(());
        }
        if buffers.has_index_list() {
            let lines = step.records.iter().map(|&position| buffers.index_line(position));
            let access = Access { kind: BufferKind::Index, write: false, bytes: INDEX_BYTES, repeats: 1 };
            self.touch(access, lines, active);
            self.end_turn(true);
        }
        self.locate(step.records.iter().copied(), |position| buffers.intersection(position))
            .map_err(|position| missing("primitive", position))?
            .read_records(BufferKind::Primitive, buffers.intersection_reads, active);
        self.end_turn(true);
        Ok(())
    }

    #[inline(always)]
    fn stack(&mut self, step: WarpStep<'_>, write: bool) -> Result<(), String> {
        let (tree, warp_width) = (&self.program.buffers.tree, self.program.lanes.warp_width);
        let entries = tree.stack_entries;
        // A power of two, as both sizes are.
        let lanes_per_line = ((1 << tree.stack_line_shift) / STACK_ENTRY_BYTES).max(1);
        let out = self.writer.lines();
        let mut found = 0;
        for group in step.records.chunks_exact(3) {
            let entry = group[0];
            if entry >= entries {
                return Err(format!("a step names stack entry {entry} of {entries}"));
            }
            let mut lanes = u64::from(group[1]) | u64::from(group[2]) << 32;
            while lanes != 0 {
                let lane = lanes.trailing_zeros();
                let line = tree.stack_line(entry, lane, warp_width);
                // Entries are distinct; two of them share a line only where a line holds more than a warp's entry.
                if !out[..found].contains(&line) {
                    out[found] = line;
                    found += 1;
                }
                let place = entry * warp_width + lane;
                let next_line = lane + lanes_per_line - (place & (lanes_per_line - 1));
                lanes &= u64::MAX.checked_shl(next_line).unwrap_or(0);
            }
        }
        let access = Access { kind: BufferKind::Stack, write, bytes: STACK_ENTRY_BYTES, repeats: 1 };
        self.count(access, found, step.lanes);
        self.end_turn(!write);
        Ok(())
    }
}

/// Lanes that the texture unit serves together.
const QUAD: usize = 4;

/// A load or store of a warp.
#[derive(Clone, Copy)]
struct Access {
    kind: BufferKind,
    write: bool,
    /// Of each lane.
    bytes: u32,
    repeats: u32,
}

/// What a step that names something unknown is refused with.
fn missing(what: &str, id: u32) -> String {
    format!("a step names {what} {id}, which does not exist")
}
