//! The shaders of one frame: what each step costs, and how it reads its records.
//!
//! A lane makes its primary ray and traces it; where it hits, it shades, and makes and traces each ray that starts there; what a
//! reflection or diffuse ray hits is shaded before the shadow rays from there; then it writes its colour. The warp reconverges between these parts. With a rasterised hit the first part is another pass's, and
//! the lane begins with the position and normal that it reads back.

use super::levels::Levels;
use super::pairs::Seconds;
use super::ray_unit::UnitTally;
use super::steps::{SetSteps, Tally, TileTally, WarpStep};
use crate::config::{AlphaCosts, Cost, RayUnit, SecondaryCosts};
use crate::counters::{IssueCounters, Pass};
use crate::error::Error;
use crate::layout::{BufferKind, Buffers, NodeRecords, PrimitiveLayout, Reads, in_pairs};
use crate::replay::{Fidelity, ReplayConfig};
use tracer::{AlphaTests, DECIDED_BY_MICROMAP, NodeFetch, Op, RayKind, Topology, TraceHeader};

/// Bytes of a micromap that a look-up reads, and of a mask's texel.
pub(super) const MICROMAP_READ_BYTES: u32 = 4;
pub(super) const MASK_TEXEL_BYTES: u32 = 1;

/// Bytes of an index list's entry.
pub(super) const INDEX_BYTES: u32 = 4;

/// What every warp of a frame executes.
pub(crate) struct Program {
    pub(crate) buffers: Buffers,
    pub(super) lanes: Lanes,
    pub(super) nodes: NodeReads,
    pub(super) levels: Levels,
    /// Streams say what each turn costs.
    pub(crate) keeps_turns: bool,
    /// A ray unit reads nodes and triangles and tests them.
    pub(super) by_ray_unit: bool,
    /// It does so at an instruction of the shader, which walks.
    pub(super) around_instruction: bool,
    step_costs: [Cost; Op::ALL.len()],
    /// Where the trace has any-hit shaders.
    any_hits: Option<AnyHitCosts>,
    /// Address arithmetic of one triangle record.
    triangle_record_cost: Cost,
    /// Triangles that come with the record of another.
    pub(super) seconds: Seconds,
    /// Address arithmetic of one node record.
    record_cost: Cost,
    /// The same two of a TLAS whose nodes are unlike those of BLASes.
    tlas_costs: NodeCosts,
    trip: Cost,
    /// By [`RayKind`]: what a warp issues before the steps of a ray set.
    setups: [Cost; RayKind::ALL.len()],
    /// Of a primary hit.
    shade: Cost,
    /// Of what another ray hits.
    hit_shade: Cost,
    /// In which pass hits of reflection rays are shaded; `None` where they are kept for later.
    reflection_shading: Option<Pass>,
    pub(super) output: Cost,
    /// Of a full-screen quad that reads an image.
    pub(crate) present: Cost,
    /// Attachments read as textures before shading.
    pub(super) attachments: u32,
    /// The colour goes to an image rather than to tile memory.
    pub(super) writes_image: bool,
    pub(super) output_bytes: u32,
    pub(super) image_line_shift: u32,
    pub(super) texture_line_shift: u32,
    counter_line_shift: u32,
    pub(super) texture_samples_per_clock: f64,
}

/// What a hit costs that the traversal does not decide about.
#[derive(Clone, Copy)]
struct AnyHitCosts {
    /// Leaving the traversal and going on with it, and looking a micromap up.
    step: Cost,
    /// The shader.
    shader: Cost,
    /// A ray unit hands the warp back to its shader.
    leaves_unit: bool,
}

/// What a node step costs.
#[derive(Clone, Copy, Default)]
struct NodeCosts {
    step: Cost,
    /// Address arithmetic of one record.
    record: Cost,
}

/// Which rays warps trace, and what a load of theirs takes.
#[derive(PartialEq, Eq)]
pub(super) struct Lanes {
    pub(super) kinds: Vec<RayKind>,
    /// Rays whose hits another pass has found: that rasterised the geometry, or traced them.
    known: Option<RayKind>,
    pub(super) warp_width: u32,
    /// Clocks that the load/store port takes for so many words of 4 bytes: up to 16 bytes for each lane.
    pub(super) port_cycles: Box<[u32; 4 * 64 + 1]>,
    /// Clocks that the port of the ray unit takes for so many lines; `None` where it has none of its own.
    pub(super) unit_port_cycles: Option<Box<[u32; 64 + 1]>>,
}

/// How a node step reads its nodes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum NodeReads {
    /// The record of the node.
    One,
    /// The records of the node and of its sibling; of the root alone.
    Pair,
    /// The record of the parent; none for the root.
    Parent,
}

impl Program {
    pub(crate) fn new(
        header: &TraceHeader,
        topology: &Topology,
        buffers: Buffers,
        config: &ReplayConfig,
    ) -> Result<Self, Error> {
        let unit = config.gpu.ray_unit_for(header);
        let by_ray_unit = unit.is_some();
        let unit_walks = unit.is_some_and(RayUnit::walks);
        let traversal = config.costs.of_shader(header, &config.gpu)?;
        let shared = &config.costs.shared;
        let technique = &config.technique;
        let with_loads = |cost: Cost, loads: u32| sum(&[cost, shared.address.times(loads)]);
        let stack_access = u32::from(buffers.tree.stack_entries > 0);
        let unless_by_unit = |cost: Cost| if by_ray_unit { Cost::default() } else { cost };
        let unless_unit_walks = |cost: Cost| if unit_walks { Cost::default() } else { cost };
        let index_load = u32::from(buffers.has_index_list());
        let two_level = config.costs.two_level(header, &config.gpu)?;
        let instance = two_level.map_or_else(Cost::default, |costs| costs.instance);
        let mut step_costs = [Cost::default(); Op::ALL.len()];
        for (op, cost, loads) in [
            (Op::Pop, traversal.pop, stack_access),
            (Op::Restart, traversal.restart, 0),
            (Op::Up, traversal.up, 0),
            (Op::Node, traversal.node, 0),
            (Op::Push, traversal.push, stack_access),
            (Op::Instance, instance, buffers.tree.instance_loads()),
            (Op::Primitive, traversal.primitive, 0),
        ] {
            // What an instance's record takes around the instruction of a unit is in its cost.
            let loads = if by_ray_unit && op == Op::Instance { 0 } else { loads };
            step_costs[op as usize] = unless_unit_walks(with_loads(cost, loads));
        }
        let any_hits = AnyHitCosts::new(header, &buffers, unit, config)?;
        let query = match unit {
            Some(unit) if unit.walks() => config.costs.ray_query.start,
            Some(_) => traversal.start,
            None => sum(&[shared.ray_setup, traversal.start]),
        };
        let attachments = technique.raster.map_or(0, |raster| raster.attachments_in_memory().len() as u32);
        let compact =
            header.normals && config.primitive_layout == PrimitiveLayout::Compact && !in_pairs(header);
        let compact_normal = if compact { shared.compact_normal } else { Cost::default() };
        let shade = match config.costs.reflections() {
            Some(costs) if technique.reflections.is_some() => costs.fetch,
            _ => shared.shade,
        };
        let hit_shade = with_loads(sum(&[shade, compact_normal]), buffers.shading_reads.loads);
        let shade = if technique.raster.is_some() { shared.decode_normal } else { hit_shade };
        let kinds: Vec<RayKind> = header.ray_sets.iter().map(|set| set.kind).collect();
        let secondary = config.costs.secondary(header)?;
        // Passes over lists make rays, and read and write what they take and leave, apart from tracing.
        let over_lists = technique.reflections.is_some();
        let setup = |kind: RayKind| {
            let SecondaryCosts { sample, light_point, reflection_ray, cosine_ray } = secondary;
            let making = match kind {
                RayKind::Primary => shared.camera_ray,
                RayKind::Shadow | RayKind::ReflectionShadow | RayKind::DiffuseShadow => shared.shadow_ray,
                RayKind::SoftShadow => sum(&[sample, light_point, shared.shadow_ray]),
                RayKind::Reflection if over_lists => Cost::default(),
                RayKind::Reflection => sum(&[sample, reflection_ray]),
                RayKind::AmbientOcclusion | RayKind::Diffuse => sum(&[sample, cosine_ray]),
            };
            sum(&[making, query])
        };
        let writes_image = technique.present.is_some();
        let line_shift = |path: &[usize]| config.gpu.caches[path[0]].line_bytes.ilog2();
        Ok(Self {
            lanes: Lanes {
                kinds,
                known: technique.raster.is_some().then_some(RayKind::Primary),
                warp_width: config.gpu.cores.warp_width,
                port_cycles: Box::new(std::array::from_fn(|words| {
                    (4 * words as u32).div_ceil(config.gpu.load_store.bytes_per_clock)
                })),
                unit_port_cycles: unit.filter(|unit| config.gpu.through_unit_port(&unit.path)).map(|_| {
                    let of_a_line = config.gpu.unit_port_line_cycles();
                    Box::new(std::array::from_fn(|lines| (lines as f64 * of_a_line).ceil() as u32))
                }),
            },
            nodes: match (header.node_fetch, config.node_records) {
                (NodeFetch::Single, _) => NodeReads::One,
                (NodeFetch::Pair, NodeRecords::ChildBoxes) => NodeReads::Parent,
                (NodeFetch::Pair, _) => NodeReads::Pair,
            },
            levels: Levels::new(header, topology),
            keeps_turns: config.fidelity == Fidelity::Timed,
            step_costs,
            any_hits,
            by_ray_unit,
            around_instruction: by_ray_unit && !unit_walks,
            triangle_record_cost: unless_by_unit(
                shared.address.times(buffers.intersection_reads.loads + index_load),
            ),
            seconds: Seconds::new(topology),
            record_cost: unless_by_unit(shared.address.times(buffers.tree.reads.loads)),
            tlas_costs: NodeCosts {
                step: unless_by_unit(config.costs.tlas_node()),
                record: unless_by_unit(shared.address.times(buffers.tree.tlas_reads.loads)),
            },
            trip: unless_unit_walks(shared.trip),
            setups: RayKind::ALL.map(setup),
            shade,
            hit_shade,
            reflection_shading: Some(Pass::Reflection),
            output: if over_lists {
                Cost::default()
            } else {
                sum(&[
                    with_loads(shared.output, attachments + u32::from(writes_image)),
                    if technique.raster.is_some() { shared.unproject } else { Cost::default() },
                ])
            },
            present: with_loads(shared.present, 1),
            attachments,
            writes_image,
            output_bytes: if over_lists { 0 } else { config.gpu.output.bytes_per_pixel },
            image_line_shift: line_shift(&config.gpu.paths.ssbo),
            texture_line_shift: line_shift(&config.gpu.paths.texture),
            counter_line_shift: line_shift(config.gpu.atomic_path()),
            texture_samples_per_clock: config.gpu.texture.samples_per_clock,
            buffers,
        })
    }

    /// The same program over a list of reflection rays: those of a kind may be `known` from a pass before, and what reflection rays hit is
    /// shaded in the pass `shading`, or kept for later.
    pub(crate) fn over_list(mut self, known: Option<RayKind>, shading: Option<Pass>) -> Self {
        self.lanes.known = known;
        self.reflection_shading = shading;
        self
    }

    /// Whether warps of the same shape ask the same of memory here as in `other` where they read nodes and use their stacks, and no
    /// stream says what a turn costs.
    pub(crate) fn reads_tree_as(&self, other: &Self) -> bool {
        let Self { buffers, lanes, nodes, levels, keeps_turns, by_ray_unit, around_instruction, .. } = self;
        let alike = *by_ray_unit == other.by_ray_unit
            && *around_instruction == other.around_instruction
            && *levels == other.levels
            && *lanes == other.lanes
            && *nodes == other.nodes
            && buffers.tree == other.buffers.tree;
        alike && !keeps_turns && !other.keeps_turns
    }

    /// Which ray sets its warps trace.
    pub(crate) fn wanted(&self) -> Vec<bool> {
        self.lanes.kinds.iter().map(|&kind| self.traces(kind)).collect()
    }

    pub(super) fn traces(&self, kind: RayKind) -> bool {
        self.lanes.known != Some(kind)
    }

    /// Node records that a ray's step reads.
    pub(crate) fn records(&self, op: Op, id: u32) -> u32 {
        match (op, self.nodes) {
            (Op::Up, _) | (Op::Node, NodeReads::One) => 1,
            (Op::Node, NodeReads::Pair) => 1 + u32::from(!self.levels.is_alone(id)),
            (Op::Node, NodeReads::Parent) => u32::from(!self.levels.is_alone(id)),
            _ => 0,
        }
    }

    /// Bytes that a ray's step loads, stacks apart.
    pub(crate) fn loaded_bytes(&self, op: Op, id: u32) -> u32 {
        let bytes = Reads::bytes;
        match op {
            Op::Primitive if self.seconds.contains(id) => 0,
            Op::Primitive => {
                let index = if self.buffers.has_index_list() { INDEX_BYTES } else { 0 };
                bytes(self.buffers.intersection_reads) + index
            }
            Op::Instance => self.buffers.tree.instance_bytes(),
            Op::AnyHit => {
                let shader = id & DECIDED_BY_MICROMAP == 0;
                let of_shader = if shader { bytes(self.buffers.shading_reads) + MASK_TEXEL_BYTES } else { 0 };
                of_shader + if self.buffers.micromaps.is_some() { MICROMAP_READ_BYTES } else { 0 }
            }
            _ => self.records(op, id) * bytes(self.buffers.tree.reads_of(self.levels.in_tlas(id))),
        }
    }

    /// What the warps of a tile issued, from how often they took each step.
    pub(super) fn issue(&self, tally: &TileTally, issue: &mut [IssueCounters; Pass::COUNT]) {
        for (set, &kind) in tally.sets.iter().zip(&self.lanes.kinds).filter(|&(_, &kind)| self.traces(kind)) {
            self.issue_set(set, self.setup(kind), &mut issue[Pass::of(kind) as usize]);
        }
        // A rasterised hit is shaded too.
        for (set, &kind) in tally.sets.iter().zip(&self.lanes.kinds) {
            let Some((pass, cost)) = self.shading(kind) else { continue };
            let shading = &mut issue[pass as usize];
            shading.shaded += set.shaded_lanes;
            self.spend(cost, set.shaded_warps, set.shaded_lanes, shading);
        }
        let output = &mut issue[Pass::Output as usize];
        self.spend(self.output, tally.warps, tally.lanes, output);
        if !self.writes_image {
            output.output_bytes += tally.lanes * u64::from(self.output_bytes);
        }
    }

    fn issue_set(&self, set: &Tally, setup: Cost, issue: &mut IssueCounters) {
        issue.rays += set.rays;
        self.spend(setup, set.warps, set.rays, issue);
        self.spend(self.trip, set.warp_trips, set.lane_trips, issue);
        // Where one shader walks both levels, a node step costs the same in either.
        let tlas = if self.levels.are_unlike() { set.tlas_steps } else { (0, 0) };
        for op in Op::ALL {
            let (warps, lanes) = (set.warp_steps[op as usize], set.lane_steps[op as usize]);
            issue.warp_steps += warps;
            issue.lane_steps += lanes;
            let (of_tlas_warps, of_tlas_lanes) = if op == Op::Node { tlas } else { (0, 0) };
            self.spend(self.tlas_costs.step, of_tlas_warps, of_tlas_lanes, issue);
            self.spend(self.step_costs[op as usize], warps - of_tlas_warps, lanes - of_tlas_lanes, issue);
        }
        let of = |op: Op| (set.warp_steps[op as usize], set.lane_steps[op as usize]);
        let ((node_warps, node_lanes), (up_warps, up_lanes)) = (of(Op::Node), of(Op::Up));
        let siblings = (set.sibling_steps, node_lanes - set.root_lanes);
        let records = match self.nodes {
            NodeReads::One => (node_warps, node_lanes),
            NodeReads::Pair => (node_warps + siblings.0, node_lanes + siblings.1),
            NodeReads::Parent => siblings,
        };
        // Wide nodes have no siblings.
        let tlas_records =
            if self.levels.are_unlike() { (tlas.0 + siblings.0, tlas.1 + siblings.1) } else { (0, 0) };
        self.spend(self.tlas_costs.record, tlas_records.0, tlas_records.1, issue);
        let (record_warps, record_lanes) = (records.0 + up_warps, records.1 + up_lanes);
        self.spend(self.record_cost, record_warps - tlas_records.0, record_lanes - tlas_records.1, issue);
        let alu = |cost: Cost, lanes: u64| u64::from(cost.alu) * lanes;
        issue.node_steps += node_lanes;
        issue.up_steps += up_lanes;
        issue.node_alu += alu(self.step_costs[Op::Node as usize], node_lanes - tlas.1)
            + alu(self.record_cost, records.1 - tlas_records.1)
            + alu(self.tlas_costs.step, tlas.1)
            + alu(self.tlas_costs.record, tlas_records.1);
        issue.tlas_steps += set.tlas_steps.1;
        issue.instances += of(Op::Instance).1;
        let (triangle_warps, triangle_lanes) = of(Op::Primitive);
        let triangle_records = (triangle_warps - set.second_steps.0, triangle_lanes - set.second_steps.1);
        self.spend(self.triangle_record_cost, triangle_records.0, triangle_records.1, issue);
        issue.primitive_alu += alu(self.step_costs[Op::Primitive as usize], triangle_lanes)
            + alu(self.triangle_record_cost, triangle_records.1);
        issue.node_fetches += record_lanes;
        issue.primitive_tests += of(Op::Primitive).1;
        if let Some(AnyHitCosts { step, shader, leaves_unit }) = self.any_hits {
            let ((returns, hits), (shader_warps, shader_lanes)) = (of(Op::AnyHit), set.any_hit_shaders);
            self.spend(step, returns, hits, issue);
            self.spend(shader, shader_warps, shader_lanes, issue);
            issue.non_opaque_hits += hits;
            issue.any_hits += shader_lanes;
            if leaves_unit {
                issue.unit_returns += returns;
                issue.resumed_rays += hits - set.answered_rays;
            }
        }
        let UnitTally { nodes: [boxes, triangles], tlas_boxes } = &set.unit;
        issue.unit_tlas_boxes += tlas_boxes;
        issue.box_nodes += boxes.by_quarters.iter().sum::<u64>();
        issue.box_nodes_quarter += boxes.by_quarters[0];
        issue.box_nodes_half += boxes.by_quarters[1];
        issue.box_nodes_three_quarters += boxes.by_quarters[2];
        issue.box_nodes_full += boxes.by_quarters[3];
        issue.triangle_nodes += triangles.by_quarters.iter().sum::<u64>();
        issue.triangle_nodes_quarter += triangles.by_quarters[0];
        issue.triangle_nodes_half += triangles.by_quarters[1];
        issue.triangle_nodes_three_quarters += triangles.by_quarters[2];
        issue.triangle_nodes_full += triangles.by_quarters[3];
        issue.unit_box_tests += boxes.tests;
        issue.unit_box_places += boxes.places;
        issue.unit_triangle_places += triangles.places;
        issue.restarts += of(Op::Restart).1;
        issue.pushes += of(Op::Push).1;
        issue.pops += of(Op::Pop).1;
    }

    /// Whether a step in the words of a warp loads or stores anything: with the boxes of children in their parent, the root has
    /// no record to read, and the second triangle of a pair has none either.
    #[inline(always)]
    pub(super) fn takes_turn(&self, step: WarpStep<'_>) -> bool {
        match step.op {
            Op::Node => self.nodes != NodeReads::Parent || step.lanes > step.root_lanes,
            Op::Primitive => step.lanes > step.root_lanes,
            _ => true,
        }
    }

    /// Whether its traversals leave hits to any-hit shaders.
    pub(super) fn has_any_hits(&self) -> bool {
        self.any_hits.is_some()
    }

    /// What a warp issues for a step that touches memory.
    pub(super) fn step_cost(&self, step: WarpStep<'_>) -> Cost {
        if let (Op::AnyHit, Some(costs)) = (step.op, self.any_hits) {
            let shader = if step.shader_lanes > 0 { costs.shader } else { Cost::default() };
            return sum(&[costs.step, shader]);
        }
        let siblings = u32::from(step.lanes > step.root_lanes);
        let records = match (step.op, self.nodes) {
            (Op::Up, _) | (Op::Node, NodeReads::One) => 1,
            (Op::Node, NodeReads::Pair) => 1 + siblings,
            (Op::Node, NodeReads::Parent) => siblings,
            _ => 0,
        };
        if step.op == Op::Node && self.levels.are_unlike() && self.levels.in_tlas(step.records[0]) {
            let NodeCosts { step, record } = self.tlas_costs;
            return sum(&[step, record.times(records)]);
        }
        let triangles = u32::from(step.op == Op::Primitive && step.lanes > step.root_lanes);
        sum(&[
            self.step_costs[step.op as usize],
            self.record_cost.times(records),
            self.triangle_record_cost.times(triangles),
        ])
    }

    /// What a warp issues for one ray set besides its steps that touch memory, and the number of those.
    pub(super) fn overhead(&self, set: &SetSteps) -> (Cost, u64) {
        let mut cost = self.trip.times(set.trips as u32);
        let mut steps = 0;
        for op in Op::ALL {
            let taken = set.taken[op as usize];
            let touches = match op {
                Op::Restart => false,
                Op::Push | Op::Pop => self.buffers.tree.stack_entries > 0,
                _ => true,
            };
            if touches {
                steps += taken;
            } else {
                cost += self.step_costs[op as usize].times(taken as u32);
            }
        }
        (cost, steps)
    }

    /// What a warp issues to fetch the attributes of what rays hit.
    pub(crate) fn hit_shade(&self) -> Cost {
        self.hit_shade
    }

    /// What a warp issues before the steps of a ray set.
    pub(super) fn setup(&self, kind: RayKind) -> Cost {
        self.setups[kind as usize]
    }

    /// The pass in which hits of rays are shaded, and what a warp issues for that.
    pub(super) fn shading(&self, kind: RayKind) -> Option<(Pass, Cost)> {
        match kind {
            RayKind::Primary => Some((Pass::Output, self.shade)),
            RayKind::Reflection => self.reflection_shading.map(|pass| (pass, self.hit_shade)),
            _ => Some((Pass::of(kind), self.hit_shade)),
        }
    }

    /// Bits of a line's size on the way of a load or store that no traversal makes.
    pub(super) fn line_shift(&self, kind: BufferKind, write: bool) -> u32 {
        match kind {
            BufferKind::Image | BufferKind::Attachment if !write => self.texture_line_shift,
            BufferKind::Counter => self.counter_line_shift,
            BufferKind::Stack => self.buffers.tree.stack_line_shift,
            _ => self.image_line_shift,
        }
    }

    /// `warps` issued `cost`, for `lanes` of their lanes.
    pub(crate) fn spend(&self, cost: Cost, warps: u64, lanes: u64, issue: &mut IssueCounters) {
        let width = u64::from(self.lanes.warp_width);
        issue.alu_active += u64::from(cost.alu) * lanes;
        issue.alu_issued += u64::from(cost.alu) * warps * width;
        issue.efu_active += u64::from(cost.efu) * lanes;
        issue.efu_issued += u64::from(cost.efu) * warps * width;
    }
}

impl AnyHitCosts {
    /// `None` where the trace has no any-hit shaders.
    ///
    /// # Errors
    /// When the cost table or the ray unit says nothing of them.
    fn new(
        header: &TraceHeader,
        buffers: &Buffers,
        unit: Option<&RayUnit>,
        config: &ReplayConfig,
    ) -> Result<Option<Self>, Error> {
        if !header.alpha.as_ref().is_some_and(AlphaTests::run_shaders) {
            return Ok(None);
        }
        let AlphaCosts { any_hit, resume, micromap, .. } = config.costs.alpha(header)?;
        let address = config.costs.shared.address;
        let leaves_unit = unit.is_some_and(RayUnit::walks);
        if leaves_unit && unit.is_some_and(|unit| unit.return_cycles.is_none()) {
            return Err(Error::Trace {
                scene: header.scene.clone(),
                problem: format!(
                    "it has alpha tests, and nothing is known of how a ray leaves the unit of {}",
                    config.gpu.name()
                ),
                remedy: "add return_cycles to its [ray_unit], as configs/gpus/mali-g715.toml has".to_owned(),
            });
        }
        let of_unit = if unit.is_some() { resume } else { Cost::default() };
        let of_micromap =
            if buffers.micromaps.is_some() { sum(&[micromap, address]) } else { Cost::default() };
        // A texture takes its coordinates as they are.
        let shader = sum(&[any_hit, address.times(buffers.shading_reads.loads)]);
        Ok(Some(Self { step: sum(&[of_unit, of_micromap]), shader, leaves_unit }))
    }
}

fn sum(costs: &[Cost]) -> Cost {
    let mut total = Cost::default();
    costs.iter().for_each(|&cost| total += cost);
    total
}
