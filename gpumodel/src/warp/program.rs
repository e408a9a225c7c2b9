//! The shaders of one frame: what each step costs, and which addresses it touches.
//!
//! A lane makes its primary ray and traces it; where it hits, it shades, and makes and traces each shadow ray; then it
//! writes its colour. The warp reconverges between these parts. With a rasterised hit the first part is another pass's, and
//! the lane begins with the position and normal that it reads back.

use super::distinct::Distinct;
use super::steps::{Tally, TileTally, WarpStep, WarpSteps};
use super::stream::{Run, StreamWriter, TileStream};
use crate::config::Cost;
use crate::counters::{IssueCounters, Pass};
use crate::error::Error;
use crate::layout::{
    BufferKind, Buffers, NodeRecords, PIXEL_BYTES, PrimitiveLayout, Reads, STACK_ENTRY_BYTES, VEC4_BYTES,
};
use crate::replay::ReplayConfig;
use crate::schedule::{HELPER, z_order};
use tracer::{NodeFetch, Op, RayKind, TILE_RAYS, TileRect, TraceHeader};

/// Bytes of an index list's entry.
const INDEX_BYTES: u32 = 4;

/// What every warp of a frame executes.
pub(crate) struct Program {
    pub(crate) buffers: Buffers,
    kinds: Vec<RayKind>,
    pub(crate) warp_width: u32,
    pub(crate) port_bytes: u32,
    nodes: NodeReads,
    /// Where a traversal keeps a stack in memory.
    stack_entries: u32,
    step_costs: [Cost; Op::ALL.len()],
    /// Address arithmetic of one node record.
    record_cost: Cost,
    trip: Cost,
    primary_setup: Cost,
    shadow_setup: Cost,
    shade: Cost,
    output: Cost,
    /// Primary rays are traced, and hits shaded from their triangles.
    traces_primary: bool,
    /// Attachments read as textures before shading.
    attachments: u32,
    /// The colour goes to an image rather than to tile memory.
    writes_image: bool,
    output_bytes: u32,
    image_line_shift: u32,
    texture_line_shift: u32,
}

/// How a node step reads its nodes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum NodeReads {
    /// The record of the node.
    One,
    /// The records of the node and of its sibling; of the root alone.
    Pair,
    /// The record of the parent; none for the root.
    Parent,
}

impl Program {
    pub(crate) fn new(header: &TraceHeader, buffers: Buffers, config: &ReplayConfig) -> Result<Self, Error> {
        let traversal = config.costs.traversal(header)?;
        let shared = &config.costs.shared;
        let technique = &config.technique;
        let with_loads = |cost: Cost, loads: u32| sum(&[cost, shared.address.times(loads)]);
        let stack_access = u32::from(header.stack_entries > 0);
        let index_load = u32::from(buffers.has_index_list());
        let mut step_costs = [Cost::default(); Op::ALL.len()];
        for (op, cost, loads) in [
            (Op::Pop, traversal.pop, stack_access),
            (Op::Restart, traversal.restart, 0),
            (Op::Up, traversal.up, 0),
            (Op::Node, traversal.node, 0),
            (Op::Push, traversal.push, stack_access),
            (Op::Primitive, traversal.primitive, buffers.intersection_reads.loads + index_load),
        ] {
            step_costs[op as usize] = with_loads(cost, loads);
        }
        let attachments = technique.raster.map_or(0, |raster| raster.attachments_in_memory().len() as u32);
        let shade = match technique.raster {
            Some(_) => shared.decode_normal,
            None if config.primitive_layout == PrimitiveLayout::Compact => {
                with_loads(sum(&[shared.shade, shared.compact_normal]), buffers.shading_reads.loads)
            }
            None => with_loads(shared.shade, buffers.shading_reads.loads),
        };
        let writes_image = technique.present.is_some();
        let line_shift = |path: &[usize]| config.gpu.caches[path[0]].line_bytes.ilog2();
        Ok(Self {
            kinds: header.ray_sets.clone(),
            warp_width: config.gpu.cores.warp_width,
            port_bytes: config.gpu.load_store.bytes_per_clock,
            nodes: match (header.node_fetch, config.node_records) {
                (NodeFetch::Single, _) => NodeReads::One,
                (NodeFetch::Pair, NodeRecords::ChildBoxes) => NodeReads::Parent,
                (NodeFetch::Pair, _) => NodeReads::Pair,
            },
            stack_entries: header.stack_entries,
            step_costs,
            record_cost: shared.address.times(buffers.node_reads.loads),
            trip: shared.trip,
            primary_setup: sum(&[shared.camera_ray, shared.ray_setup, traversal.start]),
            shadow_setup: sum(&[shared.shadow_ray, shared.ray_setup, traversal.start]),
            shade,
            output: sum(&[
                with_loads(shared.output, attachments + u32::from(writes_image)),
                if technique.raster.is_some() { shared.unproject } else { Cost::default() },
            ]),
            traces_primary: technique.raster.is_none(),
            attachments,
            writes_image,
            output_bytes: config.gpu.output.bytes_per_pixel,
            image_line_shift: line_shift(&config.gpu.paths.ssbo),
            texture_line_shift: line_shift(&config.gpu.paths.texture),
            buffers,
        })
    }

    /// Which ray sets its warps trace.
    pub(crate) fn wanted(&self) -> Vec<bool> {
        self.kinds.iter().map(|&kind| self.traces(kind)).collect()
    }

    fn traces(&self, kind: RayKind) -> bool {
        self.traces_primary || kind != RayKind::Primary
    }

    /// Node records that a ray's step reads.
    pub(crate) fn records(&self, op: Op, id: u32) -> u32 {
        match (op, self.nodes) {
            (Op::Up, _) | (Op::Node, NodeReads::One) => 1,
            (Op::Node, NodeReads::Pair) => 1 + u32::from(id != 0),
            (Op::Node, NodeReads::Parent) => u32::from(id != 0),
            _ => 0,
        }
    }

    /// Bytes that a ray's step loads, stacks apart.
    pub(crate) fn loaded_bytes(&self, op: Op, id: u32) -> u32 {
        let bytes = |reads: Reads| reads.loads * VEC4_BYTES as u32;
        match op {
            Op::Primitive => {
                let index = if self.buffers.has_index_list() { INDEX_BYTES } else { 0 };
                bytes(self.buffers.intersection_reads) + index
            }
            _ => self.records(op, id) * bytes(self.buffers.node_reads),
        }
    }

    /// What the warps of a tile issued, from how often they took each step.
    fn issue(&self, tally: &TileTally, issue: &mut [IssueCounters; Pass::COUNT]) {
        for (set, &kind) in tally.sets.iter().zip(&self.kinds).filter(|&(_, &kind)| self.traces(kind)) {
            let (pass, setup) = match kind {
                RayKind::Primary => (Pass::Primary, self.primary_setup),
                RayKind::Shadow => (Pass::Shadow, self.shadow_setup),
            };
            self.issue_set(set, setup, &mut issue[pass as usize]);
        }
        let output = &mut issue[Pass::Output as usize];
        output.shaded += tally.shaded_lanes;
        self.spend(self.shade, tally.shaded_warps, tally.shaded_lanes, output);
        self.spend(self.output, tally.warps, tally.lanes, output);
        if !self.writes_image {
            output.output_bytes += tally.lanes * u64::from(self.output_bytes);
        }
    }

    fn issue_set(&self, set: &Tally, setup: Cost, issue: &mut IssueCounters) {
        issue.rays += set.rays;
        self.spend(setup, set.warps, set.rays, issue);
        self.spend(self.trip, set.warp_trips, set.lane_trips, issue);
        for op in Op::ALL {
            let (warps, lanes) = (set.warp_steps[op as usize], set.lane_steps[op as usize]);
            issue.warp_steps += warps;
            issue.lane_steps += lanes;
            self.spend(self.step_costs[op as usize], warps, lanes, issue);
        }
        let of = |op: Op| (set.warp_steps[op as usize], set.lane_steps[op as usize]);
        let ((node_warps, node_lanes), (up_warps, up_lanes)) = (of(Op::Node), of(Op::Up));
        let siblings = (set.sibling_steps, node_lanes - set.root_lanes);
        let records = match self.nodes {
            NodeReads::One => (node_warps, node_lanes),
            NodeReads::Pair => (node_warps + siblings.0, node_lanes + siblings.1),
            NodeReads::Parent => siblings,
        };
        let (record_warps, record_lanes) = (records.0 + up_warps, records.1 + up_lanes);
        self.spend(self.record_cost, record_warps, record_lanes, issue);
        let alu = |cost: Cost, lanes: u64| u64::from(cost.alu) * lanes;
        issue.node_steps += node_lanes;
        issue.up_steps += up_lanes;
        issue.node_alu +=
            alu(self.step_costs[Op::Node as usize], node_lanes) + alu(self.record_cost, records.1);
        issue.primitive_alu += alu(self.step_costs[Op::Primitive as usize], of(Op::Primitive).1);
        issue.node_fetches += record_lanes;
        issue.primitive_tests += of(Op::Primitive).1;
        issue.restarts += of(Op::Restart).1;
        issue.pushes += of(Op::Push).1;
        issue.pops += of(Op::Pop).1;
    }

    /// `warps` issued `cost`, for `lanes` of their lanes.
    pub(crate) fn spend(&self, cost: Cost, warps: u64, lanes: u64, issue: &mut IssueCounters) {
        let width = u64::from(self.warp_width);
        issue.alu_active += u64::from(cost.alu) * lanes;
        issue.alu_issued += u64::from(cost.alu) * warps * width;
        issue.efu_active += u64::from(cost.efu) * lanes;
        issue.efu_issued += u64::from(cost.efu) * warps * width;
    }
}

fn sum(costs: &[Cost]) -> Cost {
    let mut total = Cost::default();
    costs.iter().for_each(|&cost| total += cost);
    total
}

/// Collects what warps ask of the caches, tile by tile.
pub(crate) struct Emitter {
    distinct: Distinct,
    writer: StreamWriter,
    warp_ends: Vec<usize>,
    issue: [IssueCounters; Pass::COUNT],
}

impl Emitter {
    pub(crate) fn new() -> Self {
        Self {
            distinct: Distinct::new(),
            writer: StreamWriter::new(),
            warp_ends: Vec::new(),
            issue: [IssueCounters::default(); Pass::COUNT],
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
        for (set, &kind) in program.kinds.iter().enumerate().filter(|&(_, &kind)| program.traces(kind)) {
            let pass = match kind {
                RayKind::Primary => Pass::Primary,
                RayKind::Shadow => Pass::Shadow,
            };
            for step in warp.steps(set) {
                self.step(program, pass, step)?;
            }
            // Shading comes between the primary ray and those that start at its hit.
            if kind == RayKind::Primary && warp.shaded_lanes > 0 {
                let (buffers, mut records) = (&program.buffers, [0; 64]);
                let triangles = &warp.shaded;
                let records =
                    locate(triangles, &mut records, "triangle", |triangle| buffers.shading(triangle))?;
                let mut output = self.part(program, Pass::Output);
                output.read_records(BufferKind::Normal, buffers.shading_reads, records, warp.shaded_lanes);
                output.end_turn(true);
            }
        }
        if program.writes_image {
            self.pixels(program, Pass::Output, BufferKind::Image, &warp.rays, index, rect);
        }
        self.end_warp();
        Ok(())
    }

    /// A warp of a full-screen quad that reads the image.
    pub(crate) fn present(&mut self, program: &Program, rays: &[u32], index: u32, rect: TileRect) {
        self.pixels(program, Pass::Present, BufferKind::Image, rays, index, rect);
        self.end_warp();
    }

    /// A run of lines that fixed-function hardware reads.
    pub(crate) fn fetch(&mut self, program: &Program, pass: Pass, kind: BufferKind, lines: &[u32]) {
        let mut part = self.part(program, pass);
        let found = part.distinct.filter(lines.iter().copied(), part.writer.lines());
        part.writer.push(Run::new(pass, kind, false, found, 1));
        part.counters.vertex_lines_read += found as u64;
        part.end_turn(true);
    }

    pub(crate) fn end_warp(&mut self) {
        self.warp_ends.push(self.writer.len());
    }

    /// The counters of a pass, for what is not counted by warps.
    pub(crate) fn issue(&mut self, pass: Pass) -> &mut IssueCounters {
        &mut self.issue[pass as usize]
    }

    /// What has been collected, with what `tally` says that the warps issued.
    pub(crate) fn take(&mut self, program: &Program, tally: &TileTally) -> TileStream {
        program.issue(tally, &mut self.issue);
        TileStream {
            words: self.writer.take(),
            warp_ends: std::mem::take(&mut self.warp_ends),
            issue: std::mem::take(&mut self.issue),
        }
    }

    fn part<'a>(&'a mut self, program: &'a Program, pass: Pass) -> Part<'a> {
        let Self { distinct, writer, issue, .. } = self;
        Part { program, distinct, writer, counters: &mut issue[pass as usize], pass }
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
            let mut part = self.part(program, pass);
            part.touch(Access { kind, write, bytes: PIXEL_BYTES as u32, repeats: 1 }, lines, active);
        }
        self.part(program, pass).end_turn(!write);
    }

    #[inline(always)]
    fn step(&mut self, program: &Program, pass: Pass, step: WarpStep<'_>) -> Result<(), String> {
        let mut part = self.part(program, pass);
        match step.op {
            Op::Node => part.node(step),
            Op::Up => part.record(step.records, step.lanes).map(|()| part.end_turn(true)),
            Op::Primitive => part.primitive(step),
            Op::Push => part.stack(step, true),
            Op::Pop => part.stack(step, false),
            Op::Restart => Ok(()),
            Op::Instance | Op::AnyHit => unreachable!("lockstep refuses these"),
        }
    }
}

/// What a warp does in one pass.
struct Part<'a> {
    program: &'a Program,
    distinct: &'a mut Distinct,
    writer: &'a mut StreamWriter,
    counters: &'a mut IssueCounters,
    pass: Pass,
}

impl Part<'_> {
    /// One load or store of `bytes` per lane on `lines`, or `repeats` of them on the same.
    #[inline(always)]
    fn touch(&mut self, access: Access, lines: impl Iterator<Item = u32> + Clone, active: u32) {
        let found = self.distinct.filter(lines, self.writer.lines());
        self.count(access, found, active);
    }

    #[inline(always)]
    fn count(&mut self, access: Access, found: usize, active: u32) {
        let Access { kind, write, bytes, repeats } = access;
        self.writer.push(Run::new(self.pass, kind, write, found, repeats));
        let bytes = active * bytes;
        let port_cycles = (found as u32).max(bytes.div_ceil(self.program.port_bytes));
        let (repeats, lines) = (u64::from(repeats), found as u64);
        let texture = !write && matches!(kind, BufferKind::Image | BufferKind::Attachment);
        self.counters.memory_instructions += repeats;
        self.counters.line_accesses += repeats * lines;
        self.counters.lines_read += if write { 0 } else { repeats * lines };
        self.counters.texture_lines_read += if texture { repeats * lines } else { 0 };
        self.counters.lane_bytes += repeats * u64::from(bytes);
        self.counters.load_store_cycles += repeats * u64::from(port_cycles);
    }

    /// All loads of one record of `active` lanes, whose distinct addresses are `records`.
    #[inline(always)]
    fn read_records(&mut self, kind: BufferKind, reads: Reads, records: &[u32], active: u32) {
        let shift = self.program.buffers.line_shift;
        let access = Access { kind, write: false, bytes: VEC4_BYTES as u32, repeats: 1 };
        if reads.one_line {
            let lines = records.iter().map(|&record| record >> shift);
            self.touch(Access { repeats: reads.loads, ..access }, lines, active);
            return;
        }
        for load in 0..reads.loads {
            self.touch(access, records.iter().map(|&record| (record + load) >> shift), active);
        }
    }

    /// Ends a turn of the warp: the loads since the last one are in flight together, and it waits for them.
    #[inline(always)]
    fn end_turn(&mut self, waits: bool) {
        self.writer.end_turn();
        self.counters.memory_waits += u64::from(waits);
    }

    #[inline(always)]
    fn record(&mut self, nodes: &[u32], active: u32) -> Result<(), String> {
        let (buffers, mut records) = (&self.program.buffers, [0; 64]);
        let records = locate(nodes, &mut records, "node", |node| buffers.node(node))?;
        self.read_records(BufferKind::Node, buffers.node_reads, records, active);
        Ok(())
    }

    #[inline(always)]
    fn node(&mut self, step: WarpStep<'_>) -> Result<(), String> {
        let siblings = step.lanes - step.root_lanes;
        if self.program.nodes != NodeReads::Parent {
            self.record(step.records, step.lanes)?;
        }
        if self.program.nodes != NodeReads::One && siblings > 0 {
            let buffers = &self.program.buffers;
            let (mut nodes, mut records) = ([0; 64], [0; 64]);
            let mut count = 0;
            for &node in step.records.iter().filter(|&&node| node != 0) {
                nodes[count] = node;
                count += 1;
            }
            let nodes = &nodes[..count];
            let records = if self.program.nodes == NodeReads::Pair {
                locate(nodes, &mut records, "sibling of node", |node| buffers.node(node + 1))?
            } else {
                locate(nodes, &mut records, "parent of node", |node| buffers.node(node))?
            };
            self.read_records(BufferKind::Node, buffers.node_reads, records, siblings);
        } else if self.program.nodes == NodeReads::Parent {
            return Ok(());
        }
        self.end_turn(true);
        Ok(())
    }

    #[inline(always)]
    fn primitive(&mut self, step: WarpStep<'_>) -> Result<(), String> {
        let (buffers, active) = (&self.program.buffers, step.lanes);
        if buffers.has_index_list() {
            let lines = step.records.iter().map(|&position| buffers.index_line(position));
            let access = Access { kind: BufferKind::Index, write: false, bytes: INDEX_BYTES, repeats: 1 };
            self.touch(access, lines, active);
            self.end_turn(true);
        }
        let mut records = [0; 64];
        let records =
            locate(step.records, &mut records, "primitive", |position| buffers.intersection(position))?;
        self.read_records(BufferKind::Primitive, buffers.intersection_reads, records, active);
        self.end_turn(true);
        Ok(())
    }

    #[inline(always)]
    fn stack(&mut self, step: WarpStep<'_>, write: bool) -> Result<(), String> {
        let entries = self.program.stack_entries;
        let buffers = &self.program.buffers;
        let lanes_per_line = ((1 << buffers.stack_line_shift) / STACK_ENTRY_BYTES).max(1);
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
                let line = buffers.stack_line(entry, lane, self.program.warp_width);
                // Entries are distinct; two of them share a line only where a line holds more than a warp's entry.
                if !out[..found].contains(&line) {
                    out[found] = line;
                    found += 1;
                }
                let place = entry * self.program.warp_width + lane;
                let next_line = lane + lanes_per_line - place % lanes_per_line;
                lanes &= u64::MAX.checked_shl(next_line).unwrap_or(0);
            }
        }
        let access = Access { kind: BufferKind::Stack, write, bytes: STACK_ENTRY_BYTES, repeats: 1 };
        self.count(access, found, step.lanes);
        self.end_turn(!write);
        Ok(())
    }
}

/// A load or store of a warp.
#[derive(Clone, Copy)]
struct Access {
    kind: BufferKind,
    write: bool,
    /// Of each lane.
    bytes: u32,
    repeats: u32,
}

/// The addresses of ids.
#[inline(always)]
fn locate<'a>(
    ids: &[u32],
    addresses: &'a mut [u32; 64],
    what: &str,
    address: impl Fn(u32) -> Option<u32>,
) -> Result<&'a [u32], String> {
    for (&id, place) in ids.iter().zip(addresses.iter_mut()) {
        match address(id) {
            Some(address) => *place = address,
            None => return Err(format!("a step names {what} {id}, which does not exist")),
        }
    }
    Ok(&addresses[..ids.len()])
}
