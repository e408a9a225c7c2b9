//! The shader of one frame as a program for warps, and its run over a tile.
//!
//! A lane makes its primary ray and traces it; where it hits, it shades, and makes and traces each shadow ray; then it
//! writes its colour. The warp reconverges between these parts.

use super::distinct::Distinct;
use super::lockstep::{Body, Lockstep};
use super::stream::{Pass, Run, TileStream};
use crate::config::Cost;
use crate::counters::IssueCounters;
use crate::error::Error;
use crate::layout::{BufferKind, Buffers, PrimitiveLayout, Reads, STACK_ENTRY_BYTES, VEC4_BYTES};
use crate::replay::ReplayConfig;
use crate::schedule::{HELPER, LaneMap};
use tracer::{NO_HIT, NodeFetch, Op, RayKind, Tile, TileRect, TraceHeader};

/// Bytes of an index list's entry.
const INDEX_BYTES: u32 = 4;

/// What every warp of a frame executes.
pub(crate) struct Program<'a> {
    header: &'a TraceHeader,
    buffers: &'a Buffers,
    lane_map: LaneMap,
    warp_width: u32,
    port_bytes: u32,
    pair: bool,
    /// By [`Op`], address arithmetic included.
    step_costs: [Cost; Op::ALL.len()],
    /// Of the second record of a pair.
    sibling_cost: Cost,
    trip: Cost,
    primary_setup: Cost,
    shadow_setup: Cost,
    shade: Cost,
    output: Cost,
    output_bytes: u32,
}

impl<'a> Program<'a> {
    pub(crate) fn new(
        header: &'a TraceHeader,
        buffers: &'a Buffers,
        config: &ReplayConfig,
    ) -> Result<Self, Error> {
        let traversal = config.costs.traversal(header)?;
        let shared = &config.costs.shared;
        let with_loads = |mut cost: Cost, loads: u32| {
            cost += shared.address.times(loads);
            cost
        };
        let stack_access = u32::from(header.stack_entries > 0);
        let index_load = u32::from(buffers.has_index_list());
        let mut step_costs = [Cost::default(); Op::ALL.len()];
        for (op, cost, loads) in [
            (Op::Pop, traversal.pop, stack_access),
            (Op::Restart, traversal.restart, 0),
            (Op::Up, traversal.up, buffers.node_reads.loads),
            (Op::Node, traversal.node, buffers.node_reads.loads),
            (Op::Push, traversal.push, stack_access),
            (Op::Primitive, traversal.primitive, buffers.intersection_reads.loads + index_load),
        ] {
            step_costs[op as usize] = with_loads(cost, loads);
        }
        let sum = |costs: &[Cost]| {
            let mut total = Cost::default();
            costs.iter().for_each(|&cost| total += cost);
            total
        };
        let mut shade = with_loads(shared.shade, buffers.shading_reads.loads);
        if config.primitive_layout == PrimitiveLayout::Compact {
            shade += shared.compact_normal;
        }
        Ok(Self {
            header,
            buffers,
            lane_map: LaneMap::new(&config.gpu, header.frame),
            warp_width: config.gpu.cores.warp_width,
            port_bytes: config.gpu.load_store.bytes_per_clock,
            pair: header.node_fetch == NodeFetch::Pair,
            step_costs,
            sibling_cost: shared.address.times(buffers.node_reads.loads),
            trip: shared.trip,
            primary_setup: sum(&[shared.camera_ray, shared.ray_setup]),
            shadow_setup: sum(&[shared.shadow_ray, shared.ray_setup]),
            shade,
            output: shared.output,
            output_bytes: config.gpu.output.bytes_per_pixel,
        })
    }

    fn refuse(&self, problem: impl Into<String>) -> Error {
        Error::Trace {
            scene: self.header.scene.clone(),
            problem: problem.into(),
            remedy: "record the trace again".to_owned(),
        }
    }

    /// Checks what lockstep relies on.
    fn check(&self, tile: &Tile, rays: u32) -> Result<(), Error> {
        let (expected, found) = (self.header.ray_sets.len(), tile.ray_sets.len());
        if found != expected {
            return Err(self.refuse(format!("a tile has {found} ray sets, expected {expected}")));
        }
        for set in &tile.ray_sets {
            let ends_rise = set.ends.is_sorted();
            let last = set.ends.last().copied().unwrap_or(0) as usize;
            let complete = set.ends.len() == rays as usize && set.hits.len() == rays as usize;
            if !(ends_rise && complete && last <= set.steps.len()) {
                return Err(self.refuse(format!(
                    "a ray set of a tile of {rays} rays has {} ends, {} hits and {} steps up to {last}",
                    set.ends.len(),
                    set.hits.len(),
                    set.steps.len()
                )));
            }
        }
        Ok(())
    }
}

/// One thread's means to replay tiles.
pub(crate) struct TileReplay<'a> {
    program: &'a Program<'a>,
    lockstep: Lockstep,
    distinct: Distinct,
}

impl<'a> TileReplay<'a> {
    pub(crate) fn new(program: &'a Program<'a>) -> Self {
        Self { program, lockstep: Lockstep::new(), distinct: Distinct::new() }
    }

    /// Replays all warps of a tile.
    ///
    /// # Errors
    /// When the tile contradicts the header or the topology.
    pub(crate) fn run(&mut self, tile: &Tile, rect: TileRect) -> Result<TileStream, Error> {
        let program = self.program;
        program.check(tile, rect.width * rect.height)?;
        let mut stream = TileStream {
            node_fetches: vec![0; rect.width as usize * rect.height as usize],
            ..TileStream::default()
        };
        for rays in program.lane_map.warps(rect) {
            self.warp(tile, &rays, &mut stream).map_err(|problem| program.refuse(problem))?;
            stream.warp_ends.push(stream.words.len());
        }
        Ok(stream)
    }

    fn warp(&mut self, tile: &Tile, rays: &[u32], stream: &mut TileStream) -> Result<(), String> {
        let program = self.program;
        let lanes = || (0_usize..).zip(rays).filter(|&(_, &ray)| ray != HELPER);
        let active = lanes().count() as u32;
        let mut shaded = false;
        for (set, &kind) in tile.ray_sets.iter().zip(&program.header.ray_sets) {
            let traced = || lanes().filter(|&(_, &ray)| !set.range(ray as usize).is_empty());
            let count = traced().count() as u32;
            let (pass, setup) = match kind {
                RayKind::Primary => (Pass::Primary, program.primary_setup),
                RayKind::Shadow => (Pass::Shadow, program.shadow_setup),
            };
            if count > 0 {
                let mut body = LaneBody::new(program, &mut self.distinct, stream, pass, rays);
                body.counters().rays += u64::from(count);
                body.issue(setup, count);
                let ranges = traced().map(|(lane, &ray)| {
                    let range = set.range(ray as usize);
                    (lane, range.start as u32, range.end as u32)
                });
                self.lockstep.run(program.header.loop_structure, &set.steps, ranges, &mut body)?;
            }
            // Shading comes between the primary ray and those that start at its hit.
            if kind == RayKind::Primary && !shaded {
                let hit = lanes().map(|(_, &ray)| set.hits[ray as usize]).filter(|&hit| hit != NO_HIT);
                let hit: Vec<u32> = hit.collect();
                let mut body = LaneBody::new(program, &mut self.distinct, stream, Pass::Output, rays);
                body.shade(&hit)?;
                shaded = true;
            }
        }
        let mut body = LaneBody::new(program, &mut self.distinct, stream, Pass::Output, rays);
        body.issue(program.output, active);
        body.counters().output_bytes += u64::from(active * program.output_bytes);
        Ok(())
    }
}

/// Counts and lists what a warp does in one pass.
struct LaneBody<'a> {
    program: &'a Program<'a>,
    distinct: &'a mut Distinct,
    words: &'a mut Vec<u32>,
    counters: &'a mut IssueCounters,
    node_fetches: &'a mut [u32],
    pass: Pass,
    rays: &'a [u32],
    /// Where the header of the latest run lies in `words`.
    last_run: usize,
}

impl<'a> LaneBody<'a> {
    fn new(
        program: &'a Program<'a>,
        distinct: &'a mut Distinct,
        stream: &'a mut TileStream,
        pass: Pass,
        rays: &'a [u32],
    ) -> Self {
        Self {
            program,
            distinct,
            words: &mut stream.words,
            counters: &mut stream.issue[pass as usize],
            node_fetches: &mut stream.node_fetches,
            pass,
            rays,
            last_run: 0,
        }
    }

    fn counters(&mut self) -> &mut IssueCounters {
        self.counters
    }

    /// The warp issued `cost` for `active` of its lanes.
    #[inline(always)]
    fn issue(&mut self, cost: Cost, active: u32) {
        let (active, width) = (u64::from(active), u64::from(self.program.warp_width));
        self.counters.alu_active += u64::from(cost.alu) * active;
        self.counters.alu_issued += u64::from(cost.alu) * width;
        self.counters.efu_active += u64::from(cost.efu) * active;
        self.counters.efu_issued += u64::from(cost.efu) * width;
    }

    /// One load or store, or `repeats` of them on the same lines.
    #[inline(always)]
    fn touch(&mut self, kind: BufferKind, write: bool, lines: &[u32], repeats: u32, active: u32, bytes: u32) {
        self.last_run = self.words.len();
        self.words.push(Run::new(self.pass, kind, write, lines.len(), repeats).word());
        self.words.extend_from_slice(lines);
        let (repeats, lines) = (u64::from(repeats), lines.len() as u64);
        let bytes = u64::from(active * bytes);
        self.counters.memory_instructions += repeats;
        self.counters.line_accesses += repeats * lines;
        self.counters.lines_read += if write { 0 } else { repeats * lines };
        self.counters.lane_bytes += repeats * bytes;
        self.counters.load_store_cycles +=
            repeats * lines.max(bytes.div_ceil(u64::from(self.program.port_bytes)));
    }

    /// All loads of one record of `active` lanes, whose distinct addresses are `records`.
    #[inline(always)]
    fn read_records(&mut self, kind: BufferKind, reads: Reads, records: &[u32], active: u32) {
        let shift = self.program.buffers.line_shift;
        let mut lines = [0; 64];
        if reads.one_line {
            let found = self.distinct.filter(records.iter().map(|&record| record >> shift), &mut lines);
            self.touch(kind, false, &lines[..found], reads.loads, active, VEC4_BYTES as u32);
            return;
        }
        for load in 0..reads.loads {
            let addresses = records.iter().map(|&record| (record + load) >> shift);
            let found = self.distinct.filter(addresses, &mut lines);
            self.touch(kind, false, &lines[..found], 1, active, VEC4_BYTES as u32);
        }
    }

    /// Ends a turn of the warp: the loads since the last one are in flight together, and it waits for them.
    #[inline(always)]
    fn end_turn(&mut self, waits: bool) {
        Run::mark_last(&mut self.words[self.last_run]);
        self.counters.memory_waits += u64::from(waits);
    }

    /// Shades the hit triangles of a warp's lanes.
    fn shade(&mut self, hits: &[u32]) -> Result<(), String> {
        if hits.is_empty() {
            return Ok(());
        }
        let active = hits.len() as u32;
        self.counters.shaded += u64::from(active);
        self.issue(self.program.shade, active);
        let records = self.records(hits, Buffers::shading, "hit triangle")?;
        self.read_records(BufferKind::Normal, self.program.buffers.shading_reads, &records, active);
        self.end_turn(true);
        Ok(())
    }

    /// The addresses of the distinct ones of `ids`.
    #[inline(always)]
    fn records(
        &mut self,
        ids: &[u32],
        address: impl Fn(&Buffers, u32) -> Option<u32>,
        what: &str,
    ) -> Result<Records, String> {
        let mut records = Records { addresses: [0; 64], count: 0 };
        records.count = self.distinct.filter(ids.iter().copied(), &mut records.addresses);
        for record in &mut records.addresses[..records.count] {
            match address(self.program.buffers, *record) {
                Some(address) => *record = address,
                None => return Err(format!("a step names {what} {record}, which does not exist")),
            }
        }
        Ok(records)
    }

    fn node(&mut self, lanes: &[u8], ids: &[u32]) -> Result<(), String> {
        let (program, active) = (self.program, ids.len() as u32);
        let reads = program.buffers.node_reads;
        let records = self.records(ids, Buffers::node, "node")?;
        self.read_records(BufferKind::Node, reads, &records, active);
        let mut siblings = 0;
        if program.pair {
            let mut pairs = [0; 64];
            for &id in ids.iter().filter(|&&id| id != 0) {
                pairs[siblings] = id + 1;
                siblings += 1;
            }
            if siblings > 0 {
                let records = self.records(&pairs[..siblings], Buffers::node, "node")?;
                self.read_records(BufferKind::Node, reads, &records, siblings as u32);
                self.issue(program.sibling_cost, siblings as u32);
            }
        }
        for (&lane, &id) in lanes.iter().zip(ids) {
            let fetches = 1 + u32::from(program.pair && id != 0);
            self.node_fetches[self.rays[usize::from(lane)] as usize] += fetches;
        }
        self.counters.node_fetches += u64::from(active) + siblings as u64;
        self.end_turn(true);
        Ok(())
    }

    fn up(&mut self, lanes: &[u8], ids: &[u32]) -> Result<(), String> {
        let active = ids.len() as u32;
        let records = self.records(ids, Buffers::node, "node")?;
        self.read_records(BufferKind::Node, self.program.buffers.node_reads, &records, active);
        for &lane in lanes {
            self.node_fetches[self.rays[usize::from(lane)] as usize] += 1;
        }
        self.counters.node_fetches += u64::from(active);
        self.end_turn(true);
        Ok(())
    }

    fn primitive(&mut self, ids: &[u32]) -> Result<(), String> {
        let (buffers, active) = (self.program.buffers, ids.len() as u32);
        let records = self.records(ids, Buffers::intersection, "primitive")?;
        if buffers.has_index_list() {
            let mut lines = [0; 64];
            let of_position = ids.iter().filter_map(|&position| buffers.index_line(position));
            let found = self.distinct.filter(of_position, &mut lines);
            self.touch(BufferKind::Index, false, &lines[..found], 1, active, INDEX_BYTES);
            self.end_turn(true);
        }
        self.read_records(BufferKind::Primitive, buffers.intersection_reads, &records, active);
        self.counters.primitive_tests += u64::from(active);
        self.end_turn(true);
        Ok(())
    }

    fn stack(&mut self, lanes: &[u8], entries: &[u32], write: bool) -> Result<(), String> {
        let (buffers, active) = (self.program.buffers, entries.len() as u32);
        if buffers.stack_entries == 0 {
            return Ok(());
        }
        if let Some(entry) = entries.iter().find(|&&entry| entry >= buffers.stack_entries) {
            return Err(format!("a step names stack entry {entry} of {}", buffers.stack_entries));
        }
        let width = self.program.warp_width;
        let of_lane = |(&lane, &entry): (&u8, &u32)| buffers.stack_line(entry, u32::from(lane), width);
        let mut lines = [0; 64];
        let found = self.distinct.filter(lanes.iter().zip(entries).map(of_lane), &mut lines);
        self.touch(BufferKind::Stack, write, &lines[..found], 1, active, STACK_ENTRY_BYTES);
        self.end_turn(!write);
        Ok(())
    }
}

/// Distinct addresses, at most one per lane.
struct Records {
    addresses: [u32; 64],
    count: usize,
}

impl std::ops::Deref for Records {
    type Target = [u32];

    fn deref(&self) -> &[u32] {
        &self.addresses[..self.count]
    }
}

impl Body for LaneBody<'_> {
    #[inline(always)]
    fn trip(&mut self, lanes: u32) {
        self.issue(self.program.trip, lanes);
    }

    #[inline(always)]
    fn step(&mut self, op: Op, lanes: &[u8], ids: &[u32]) -> Result<(), String> {
        self.counters.warp_steps += 1;
        self.counters.lane_steps += ids.len() as u64;
        self.issue(self.program.step_costs[op as usize], ids.len() as u32);
        match op {
            Op::Node => self.node(lanes, ids),
            Op::Up => self.up(lanes, ids),
            Op::Primitive => self.primitive(ids),
            Op::Push => {
                self.counters.pushes += ids.len() as u64;
                self.stack(lanes, ids, true)
            }
            Op::Pop => {
                self.counters.pops += ids.len() as u64;
                self.stack(lanes, ids, false)
            }
            Op::Restart => {
                self.counters.restarts += ids.len() as u64;
                Ok(())
            }
            Op::Instance | Op::AnyHit => unreachable!("lockstep refuses these"),
        }
    }
}
