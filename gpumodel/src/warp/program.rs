//! The shader of one frame as a program for warps, and its run over a tile.
//!
//! A lane makes its primary ray and traces it; where it hits, it shades, and makes and traces each shadow ray; then it
//! writes its colour. The warp reconverges between these parts.

use super::distinct::Distinct;
use super::lockstep::{Body, Lockstep};
use super::stream::{Pass, Run, StreamWriter, TileStream};
use crate::config::Cost;
use crate::counters::IssueCounters;
use crate::error::Error;
use crate::layout::{BufferKind, Buffers, PrimitiveLayout, Reads, STACK_ENTRY_BYTES, VEC4_BYTES};
use crate::replay::ReplayConfig;
use crate::schedule::{HELPER, LaneMap};
use tracer::{NO_HIT, NodeFetch, Op, RayKind, RaySet, Step, Tile, TileRect, TraceHeader};

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
            primary_setup: sum(&[shared.camera_ray, shared.ray_setup, traversal.start]),
            shadow_setup: sum(&[shared.shadow_ray, shared.ray_setup, traversal.start]),
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

    /// Node records that a ray of the tile and all rays that follow from it fetch.
    fn node_fetches(&self, tile: &Tile, ray: usize) -> u32 {
        let fetches = |step: &Step| match step.op() {
            Op::Node => 1 + u32::from(self.pair && step.id() != 0),
            Op::Up => 1,
            _ => 0,
        };
        let of_set = |set: &RaySet| set.steps[set.range(ray)].iter().map(fetches).sum::<u32>();
        tile.ray_sets.iter().map(of_set).sum()
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
    writer: StreamWriter,
}

impl<'a> TileReplay<'a> {
    pub(crate) fn new(program: &'a Program<'a>) -> Self {
        Self { program, lockstep: Lockstep::new(), distinct: Distinct::new(), writer: StreamWriter::new() }
    }

    /// Replays all warps of a tile.
    ///
    /// # Errors
    /// When the tile contradicts the header or the topology.
    pub(crate) fn run(&mut self, tile: &Tile, rect: TileRect) -> Result<TileStream, Error> {
        let program = self.program;
        let rays = rect.width * rect.height;
        program.check(tile, rays)?;
        let mut stream = TileStream {
            node_fetches: (0..rays as usize).map(|ray| program.node_fetches(tile, ray)).collect(),
            ..TileStream::default()
        };
        for lanes in program.lane_map.warps(rect) {
            self.warp(tile, &lanes, &mut stream.issue).map_err(|problem| program.refuse(problem))?;
            stream.warp_ends.push(self.writer.len());
        }
        stream.words = self.writer.take();
        Ok(stream)
    }

    fn warp(&mut self, tile: &Tile, rays: &[u32], issue: &mut [IssueCounters; 3]) -> Result<(), String> {
        let program = self.program;
        let lanes = || (0_usize..).zip(rays).filter(|&(_, &ray)| ray != HELPER);
        let active = lanes().count() as u32;
        let Self { lockstep, distinct, writer, .. } = self;
        let mut part = |pass: Pass, work: &mut dyn FnMut(&mut WarpBody<'_>) -> Result<(), String>| {
            let counters = &mut issue[pass as usize];
            work(&mut WarpBody { program, distinct, writer, counters, pass })
        };
        let mut primary_hits: Option<&[u32]> = None;
        for (set, &kind) in tile.ray_sets.iter().zip(&program.header.ray_sets) {
            // A ray that misses the box of a kd-tree takes no step, and yet has been made.
            let is_traced = |ray: u32| {
                let has_steps = !set.range(ray as usize).is_empty();
                let is_due = primary_hits.is_some_and(|hits| hits[ray as usize] != NO_HIT);
                kind == RayKind::Primary || has_steps || is_due
            };
            let traced = || lanes().filter(|&(_, &ray)| is_traced(ray));
            let count = traced().count() as u32;
            let (pass, setup) = match kind {
                RayKind::Primary => (Pass::Primary, program.primary_setup),
                RayKind::Shadow => (Pass::Shadow, program.shadow_setup),
            };
            if count > 0 {
                part(pass, &mut |body| {
                    body.counters.rays += u64::from(count);
                    body.issue(setup, count);
                    let ranges = traced().map(|(lane, &ray)| {
                        let range = set.range(ray as usize);
                        (lane, range.start as u32, range.end as u32)
                    });
                    lockstep.run(program.header.loop_structure, &set.steps, ranges, body)
                })?;
            }
            // Shading comes between the primary ray and those that start at its hit.
            if kind == RayKind::Primary && primary_hits.is_none() {
                let hits = lanes().map(|(_, &ray)| set.hits[ray as usize]).filter(|&hit| hit != NO_HIT);
                let hits: Vec<u32> = hits.collect();
                part(Pass::Output, &mut |body| body.shade(&hits))?;
                primary_hits = Some(&set.hits);
            }
        }
        part(Pass::Output, &mut |body| {
            body.issue(program.output, active);
            body.counters.output_bytes += u64::from(active * program.output_bytes);
            Ok(())
        })
    }
}

/// Counts and lists what a warp does in one pass.
struct WarpBody<'a> {
    program: &'a Program<'a>,
    distinct: &'a mut Distinct,
    writer: &'a mut StreamWriter,
    counters: &'a mut IssueCounters,
    pass: Pass,
}

impl WarpBody<'_> {
    /// The warp issued `cost` for `active` of its lanes.
    #[inline(always)]
    fn issue(&mut self, cost: Cost, active: u32) {
        let (active, width) = (u64::from(active), u64::from(self.program.warp_width));
        self.counters.alu_active += u64::from(cost.alu) * active;
        self.counters.alu_issued += u64::from(cost.alu) * width;
        self.counters.efu_active += u64::from(cost.efu) * active;
        self.counters.efu_issued += u64::from(cost.efu) * width;
    }

    /// One load or store of `bytes` per lane on `lines`, or `repeats` of them on the same.
    #[inline(always)]
    fn touch(&mut self, access: Access, lines: impl Iterator<Item = u32>, active: u32) {
        let Access { kind, write, bytes, repeats } = access;
        let found = self.distinct.filter(lines, self.writer.lines());
        self.writer.push(Run::new(self.pass, kind, write, found, repeats));
        let bytes = active * bytes;
        let port_cycles = (found as u32).max(bytes.div_ceil(self.program.port_bytes));
        let (repeats, lines) = (u64::from(repeats), found as u64);
        self.counters.memory_instructions += repeats;
        self.counters.line_accesses += repeats * lines;
        self.counters.lines_read += if write { 0 } else { repeats * lines };
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

    /// Shades the hit triangles of a warp's lanes.
    fn shade(&mut self, hits: &[u32]) -> Result<(), String> {
        if hits.is_empty() {
            return Ok(());
        }
        let buffers = self.program.buffers;
        let active = hits.len() as u32;
        self.counters.shaded += u64::from(active);
        self.issue(self.program.shade, active);
        let mut records = [0; 64];
        let count = self.distinct.filter(hits.iter().copied(), &mut records);
        locate(&mut records[..count], "triangle", |triangle| buffers.shading(triangle))?;
        self.read_records(BufferKind::Normal, buffers.shading_reads, &records[..count], active);
        self.end_turn(true);
        Ok(())
    }

    #[inline(always)]
    fn node(&mut self, ids: &[u32], pair: bool) -> Result<(), String> {
        let (buffers, active) = (self.program.buffers, ids.len() as u32);
        let mut nodes = [0; 64];
        let count = self.distinct.filter(ids.iter().copied(), &mut nodes);
        let mut records = nodes;
        locate(&mut records[..count], "node", |node| buffers.node(node))?;
        self.read_records(BufferKind::Node, buffers.node_reads, &records[..count], active);
        let mut siblings = 0;
        if pair {
            // The root has no sibling.
            siblings = ids.iter().map(|&id| u32::from(id != 0)).sum();
            let mut count = count;
            if siblings < active {
                let of_root = nodes[..count].iter().position(|&node| node == 0).unwrap_or(0);
                nodes.copy_within(of_root + 1..count, of_root);
                count -= 1;
            }
            if siblings > 0 {
                locate(&mut nodes[..count], "sibling of node", |node| buffers.node(node + 1))?;
                self.read_records(BufferKind::Node, buffers.node_reads, &nodes[..count], siblings);
                self.issue(self.program.sibling_cost, siblings);
            }
        }
        self.counters.node_fetches += u64::from(active + siblings);
        self.end_turn(true);
        Ok(())
    }

    #[inline(always)]
    fn primitive(&mut self, ids: &[u32]) -> Result<(), String> {
        let (buffers, active) = (self.program.buffers, ids.len() as u32);
        let mut records = [0; 64];
        let count = self.distinct.filter(ids.iter().copied(), &mut records);
        if buffers.has_index_list() {
            let lines = records[..count].iter().map(|&position| buffers.index_line(position));
            let access = Access { kind: BufferKind::Index, write: false, bytes: INDEX_BYTES, repeats: 1 };
            self.touch(access, lines, active);
            self.end_turn(true);
        }
        locate(&mut records[..count], "primitive", |position| buffers.intersection(position))?;
        self.read_records(BufferKind::Primitive, buffers.intersection_reads, &records[..count], active);
        self.counters.primitive_tests += u64::from(active);
        self.end_turn(true);
        Ok(())
    }

    #[inline(always)]
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
        let access = Access { kind: BufferKind::Stack, write, bytes: STACK_ENTRY_BYTES, repeats: 1 };
        self.touch(access, lanes.iter().zip(entries).map(of_lane), active);
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

/// Replaces ids by addresses.
#[inline(always)]
fn locate(ids: &mut [u32], what: &str, address: impl Fn(u32) -> Option<u32>) -> Result<(), String> {
    for id in ids {
        match address(*id) {
            Some(address) => *id = address,
            None => return Err(format!("a step names {what} {id}, which does not exist")),
        }
    }
    Ok(())
}

impl Body for WarpBody<'_> {
    #[inline(always)]
    fn trip(&mut self, lanes: u32) {
        self.issue(self.program.trip, lanes);
    }

    #[inline(always)]
    fn step(&mut self, op: Op, lanes: &[u8], ids: &[u32]) -> Result<(), String> {
        let active = ids.len() as u64;
        self.counters.warp_steps += 1;
        self.counters.lane_steps += active;
        self.issue(self.program.step_costs[op as usize], ids.len() as u32);
        match op {
            Op::Node => self.node(ids, self.program.pair),
            Op::Up => self.node(ids, false),
            Op::Primitive => self.primitive(ids),
            Op::Push => {
                self.counters.pushes += active;
                self.stack(lanes, ids, true)
            }
            Op::Pop => {
                self.counters.pops += active;
                self.stack(lanes, ids, false)
            }
            Op::Restart => {
                self.counters.restarts += active;
                Ok(())
            }
            Op::Instance | Op::AnyHit => unreachable!("lockstep refuses these"),
        }
    }
}
