//! Each counter's value, as [`COUNTERS`](crate::COUNTERS) defines it.

use crate::config::CacheRole;
use crate::counters::{BufferTraffic, CounterSet, PassCounters, TrafficCounters, Value};
use crate::energy::PassEnergy;
use crate::replay::{ReplayConfig, Replayed};
use crate::timed::TimedPhase;
use tracer::{AlphaTests, Topology, TraceHeader};

/// What all passes of a frame share.
pub(super) struct FrameValues<'a> {
    pub(super) replayed: &'a Replayed,
    pub(super) header: &'a TraceHeader,
    pub(super) topology: &'a Topology,
    pub(super) config: &'a ReplayConfig,
}

/// The counters of a pass, or of the whole frame.
pub(super) struct PassValues<'a> {
    pub(super) frame: &'a FrameValues<'a>,
    pub(super) pass: &'a PassCounters,
    pub(super) seconds: f64,
    pub(super) energy: Option<PassEnergy>,
    /// Not a part of the frame but all of it.
    pub(super) whole: bool,
}

const NO_RAYS: &str = "no ray was traced";
const NO_ANY_HITS: &str = "every triangle is marked opaque, or rays take it so or pass through it";
const ONE_LEVEL: &str = "the structure has one level";
const NO_RAY_UNIT: &str = "no ray unit walks the structure";
const NO_TIME: &str = "it takes no time";
const NO_WORK: &str = "nothing was issued";
const NO_VERTICES: &str = "no vertex is fetched";
const NO_FRAGMENTS: &str = "there are no fragments";
const NO_ENERGY: &str = "it takes no energy";
/// Why there is no energy.
pub(super) const NO_PROCESS: &str = "the GPU's description names no process: it has no [energy]";
const OF_THE_FRAME: &str = "belongs to the frame, not to one of its parts";

impl PassValues<'_> {
    pub(super) fn set(&self) -> CounterSet {
        CounterSet::new(|id| self.value(id))
    }

    fn value(&self, id: &str) -> Value {
        let issue = &self.pass.issue;
        let traffic = self.pass.traffic.total();
        let gpu = &self.frame.config.gpu;
        let fragments = self.frame.header.frame.rays() as f64;
        let rays = issue.rays as f64;
        // Bin lists are written once and read once.
        let dram_reads = traffic.dram_read_bytes + issue.bin_list_bytes / 2 + issue.dma_read_bytes;
        let alu_capacity = f64::from(gpu.cores.count) * gpu.cores.alu_lanes * gpu.clock.hz * self.seconds;
        match id {
            "frame_time_ms" => Value::Real(self.seconds * 1e3),
            "fps" => Value::ratio(1.0, self.seconds, NO_TIME),
            "rays" => Value::Count(issue.rays),
            "mrays_per_second" => self.per_second(rays / 1e6),
            "structure_nodes" => self.of_frame(|| Value::Count(self.frame.topology.node_count())),
            "structure_bytes" => self.of_frame(|| Value::Count(self.frame.replayed.structure_bytes)),
            "node_fetches" => self.of_rays(Value::Count(issue.node_fetches)),
            "node_fetches_per_ray" => Value::ratio(issue.node_fetches as f64, rays, NO_RAYS),
            "node_fetches_per_pixel" => Value::ratio(issue.node_fetches as f64, fragments, NO_FRAGMENTS),
            "primitive_tests" => self.of_rays(Value::Count(issue.primitive_tests)),
            "primitive_tests_per_ray" => Value::ratio(issue.primitive_tests as f64, rays, NO_RAYS),
            "non_opaque_hits" | "any_hits" | "any_hits_per_ray" => self.alpha_tests(id),
            "instances" | "instances_per_ray" | "tlas_step_share" => self.two_levels(id),
            "restarts" => self.restarts(),
            id if id.starts_with("ray_unit_") => self.ray_unit(id),
            "fragments" => Value::Count(self.frame.header.frame.rays()),
            "warps" => self.of_frame(|| Value::Count(self.frame.replayed.counters.schedule.warps)),
            "vertices" if issue.vertices > 0 => Value::Count(issue.vertices),
            "vertices" => Value::absent(NO_VERTICES),
            "alu_operations" => Value::Count(issue.alu_active),
            "alu_operations_issued" => Value::Count(issue.alu_issued),
            "efu_operations" => Value::Count(issue.efu_active),
            "efu_operations_issued" => Value::Count(issue.efu_issued),
            "memory_instructions" => Value::Count(issue.memory_instructions),
            "load_store_cycles" => Value::Count(issue.load_store_cycles),
            "atomics" | "dispatches" if !self.frame.config.technique.has_lists() => {
                Value::absent("no pass of this technique lists what another one takes")
            }
            "atomics" => Value::Count(issue.atomics),
            "dispatches" => Value::Count(issue.dispatches),
            "shader_calls" => match &self.frame.config.technique.reflections {
                Some(reflections) if reflections.hit_shading.is_pipeline() => {
                    Value::Count(issue.shader_calls)
                }
                _ => Value::absent("this technique has no ray-tracing pipeline"),
            },
            "alu_per_fragment" => Value::ratio(issue.alu_active as f64, fragments, NO_FRAGMENTS),
            "alu_issued_per_fragment" => Value::ratio(issue.alu_issued as f64, fragments, NO_FRAGMENTS),
            "efu_per_fragment" => Value::ratio(issue.efu_active as f64, fragments, NO_FRAGMENTS),
            "simt_efficiency" => Value::ratio(issue.alu_active as f64, issue.alu_issued as f64, NO_WORK),
            "occupancy" => self.of_frame(|| self.occupancy()),
            "sp_memory_read_bytes" => Value::Count(self.shader_reads()),
            "sp_memory_read_bytes_per_second" => self.per_second(self.shader_reads() as f64),
            "texture_memory_read_bytes" => memory_reads(self.pass.traffic.image, "no texture is read"),
            "vertex_memory_read_bytes" => memory_reads(self.pass.traffic.vertex, NO_VERTICES),
            "external_read_bytes" => self.external(Value::Count(dram_reads)),
            "load_store_external_read_bytes" => self.external(Value::Count(self.buffers().dram_read_bytes)),
            "texture_external_read_bytes" => {
                self.external(memory_reads(self.pass.traffic.image, "no texture is read"))
            }
            "dram_read_bytes" => Value::Count(dram_reads),
            "dram_write_bytes" => {
                let past_caches = issue.output_bytes + issue.bin_list_bytes / 2 + issue.dma_write_bytes;
                Value::Count(traffic.dram_write_bytes + past_caches)
            }
            "l1_accesses" => self.level(CacheRole::L1, &traffic, accesses),
            "l1_misses" => self.level(CacheRole::L1, &traffic, misses),
            "l1_miss_ratio" => self.level(CacheRole::L1, &traffic, miss_ratio),
            "l2_accesses" => self.level(CacheRole::L2, &traffic, accesses),
            "l2_misses" => self.level(CacheRole::L2, &traffic, misses),
            "l2_miss_ratio" => self.level(CacheRole::L2, &traffic, miss_ratio),
            "load_store_l2_accesses" => self.level(CacheRole::L2, &self.buffers(), accesses),
            "load_store_l2_misses" => self.level(CacheRole::L2, &self.buffers(), misses),
            "texture_l2_accesses" => self.level(CacheRole::L2, &self.pass.traffic.image, accesses),
            "texture_l2_misses" => self.level(CacheRole::L2, &self.pass.traffic.image, misses),
            "shader_alu_capacity_utilized" => Value::ratio(issue.alu_active as f64, alu_capacity, NO_TIME),
            "time_alus_working" => Value::ratio(issue.alu_issued as f64, alu_capacity, NO_TIME),
            "shaders_busy" => self.of_frame(|| {
                let schedule = &self.frame.replayed.counters.schedule;
                Value::ratio(schedule.full_ticks as f64, schedule.ticks as f64, NO_WORK)
            }),
            "stalled_on_system_memory" => self.of_frame(|| match &self.frame.replayed.timed {
                Some(timed) => {
                    let sum = |value: fn(&TimedPhase) -> f64| -> f64 {
                        timed.phases.iter().map(|(_, phase)| value(phase)).sum()
                    };
                    Value::ratio(sum(|phase| phase.stalled_on_memory), sum(|phase| phase.cycles), NO_TIME)
                }
                None => Value::absent("needs time event by event: --fidelity timed"),
            }),
            "avg_bytes_per_fragment" => Value::ratio(dram_reads as f64, fragments, NO_FRAGMENTS),
            "energy_mj" | "power_mw" | "energy_nj_per_ray" | "dram_energy_share" => self.energy(id),
            _ => Value::absent("this estimate does not compute it"),
        }
    }

    fn energy(&self, id: &str) -> Value {
        let Some(PassEnergy { joules, dram_joules }) = self.energy else { return Value::absent(NO_PROCESS) };
        match id {
            "energy_mj" => Value::Real(joules * 1e3),
            "power_mw" => self.per_second(joules * 1e3),
            "energy_nj_per_ray" => Value::ratio(joules * 1e9, self.pass.issue.rays as f64, NO_RAYS),
            _ => Value::ratio(dram_joules, joules, NO_ENERGY),
        }
    }

    fn ray_unit(&self, id: &str) -> Value {
        let issue = &self.pass.issue;
        let gpu = &self.frame.config.gpu;
        let Some(unit) = gpu.ray_unit_for(self.frame.header) else { return Value::absent(NO_RAY_UNIT) };
        if issue.rays == 0 {
            return Value::absent(NO_RAYS);
        }
        let box_cycles = issue.unit_box_places as f64 / unit.boxes_per_clock;
        let triangle_cycles = issue.unit_triangle_places as f64 / unit.triangles_per_clock;
        let capacity = f64::from(gpu.cores.count) * gpu.clock.hz * self.seconds;
        match id {
            "ray_unit_rays" => Value::Count(issue.rays),
            "ray_unit_utilization" => Value::ratio(box_cycles.max(triangle_cycles), capacity, NO_TIME),
            "ray_unit_efficiency" => {
                Value::ratio(issue.unit_box_tests as f64, issue.unit_box_places as f64, NO_WORK)
            }
            "ray_unit_box_cycles" => Value::Real(box_cycles),
            "ray_unit_triangle_cycles" => Value::Real(triangle_cycles),
            "ray_unit_port_cycles" if !gpu.through_unit_port(&unit.path) => {
                Value::absent("the unit reads through the load/store port of its core")
            }
            "ray_unit_port_cycles" => Value::Real(issue.unit_port_lines as f64 * gpu.unit_port_line_cycles()),
            "ray_unit_box_tests" => Value::Count(issue.unit_box_tests),
            "ray_unit_tlas_box_tests" | "ray_unit_instances" if self.frame.topology.levels.is_none() => {
                Value::absent(ONE_LEVEL)
            }
            "ray_unit_tlas_box_tests" => Value::Count(issue.unit_tlas_boxes),
            "ray_unit_instances" => Value::Count(issue.instances),
            "ray_unit_non_opaque_hits" => Value::Count(issue.non_opaque_hits),
            "ray_unit_resume_messages" | "ray_unit_resumed_rays" if !unit.walks() => {
                Value::absent("the unit keeps no ray from one instruction to the next")
            }
            "ray_unit_resume_messages" => Value::Count(issue.unit_returns),
            "ray_unit_resumed_rays" => Value::Count(issue.resumed_rays),
            "ray_unit_box_nodes" => Value::Count(issue.box_nodes),
            "ray_unit_box_nodes_quarter" => Value::Count(issue.box_nodes_quarter),
            "ray_unit_box_nodes_half" => Value::Count(issue.box_nodes_half),
            "ray_unit_box_nodes_three_quarters" => Value::Count(issue.box_nodes_three_quarters),
            "ray_unit_box_nodes_full" => Value::Count(issue.box_nodes_full),
            "ray_unit_triangle_nodes" => Value::Count(issue.triangle_nodes),
            "ray_unit_triangle_nodes_quarter" => Value::Count(issue.triangle_nodes_quarter),
            "ray_unit_triangle_nodes_half" => Value::Count(issue.triangle_nodes_half),
            "ray_unit_triangle_nodes_three_quarters" => Value::Count(issue.triangle_nodes_three_quarters),
            "ray_unit_triangle_nodes_full" => Value::Count(issue.triangle_nodes_full),
            _ => Value::absent("this estimate does not compute it"),
        }
    }

    fn alpha_tests(&self, id: &str) -> Value {
        let issue = &self.pass.issue;
        if !self.frame.header.alpha.as_ref().is_some_and(AlphaTests::run_shaders) {
            return Value::absent(NO_ANY_HITS);
        }
        match id {
            "non_opaque_hits" => self.of_rays(Value::Count(issue.non_opaque_hits)),
            "any_hits" => self.of_rays(Value::Count(issue.any_hits)),
            _ => Value::ratio(issue.any_hits as f64, issue.rays as f64, NO_RAYS),
        }
    }

    fn two_levels(&self, id: &str) -> Value {
        let issue = &self.pass.issue;
        if self.frame.topology.levels.is_none() {
            return Value::absent(ONE_LEVEL);
        }
        match id {
            "instances" => self.of_rays(Value::Count(issue.instances)),
            "instances_per_ray" => Value::ratio(issue.instances as f64, issue.rays as f64, NO_RAYS),
            _ => Value::ratio(issue.tlas_steps as f64, issue.node_steps as f64, NO_RAYS),
        }
    }

    fn of_frame(&self, value: impl FnOnce() -> Value) -> Value {
        if self.whole { value() } else { Value::absent(OF_THE_FRAME) }
    }

    fn of_rays(&self, value: Value) -> Value {
        if self.pass.issue.rays > 0 { value } else { Value::absent(NO_RAYS) }
    }

    fn per_second(&self, amount: f64) -> Value {
        Value::ratio(amount, self.seconds, NO_TIME)
    }

    fn restarts(&self) -> Value {
        let header = self.frame.header;
        match header.traversal.as_str() {
            "restart" | "push-down" | "restart-trail" | "short-stack" => {
                self.of_rays(Value::Count(self.pass.issue.restarts))
            }
            other => Value::Absent { reason: format!("{} {other} never restarts", header.accel.name()) },
        }
    }

    fn occupancy(&self) -> Value {
        let schedule = &self.frame.replayed.counters.schedule;
        let cores = &self.frame.config.gpu.cores;
        // In floats: 10 THz for a second are 10^13 ticks, and slow memory makes a frame of many seconds.
        let slots = f64::from(cores.count) * f64::from(cores.warp_slots) * schedule.ticks as f64;
        Value::ratio(schedule.warp_ticks as f64, slots, NO_WORK)
    }

    /// Bytes from memory for the loads of shaders, textures apart.
    fn shader_reads(&self) -> u64 {
        let TrafficCounters { node, primitive, index, normal, stack, vertex: _, image: _, record } =
            self.pass.traffic;
        [node, primitive, index, normal, stack, record].iter().map(|traffic| traffic.dram_read_bytes).sum()
    }

    /// Traffic of all that is no image.
    fn buffers(&self) -> BufferTraffic {
        TrafficCounters { image: BufferTraffic::default(), ..self.pass.traffic }.total()
    }

    /// What memory counts is what the GPU's own caches ask for, if no cache of the chip stands between.
    fn external(&self, of_memory: Value) -> Value {
        if self.frame.config.gpu.caches.iter().any(|cache| cache.role == CacheRole::Slc) {
            return Value::absent("the system cache counts what it is read and what it is written together");
        }
        of_memory
    }

    fn level(&self, role: CacheRole, traffic: &BufferTraffic, value: fn(u64, u64) -> Value) -> Value {
        let gpu = &self.frame.config.gpu;
        let levels = gpu.caches.iter().zip(traffic.levels).filter(|(cache, _)| cache.role == role);
        let (mut accesses, mut misses) = (0, 0);
        levels.for_each(|(_, served)| {
            accesses += served.accesses;
            misses += served.misses;
        });
        if accesses == 0 {
            return Value::absent("no buffer of this pass goes through a cache of that level");
        }
        value(accesses, misses)
    }
}

/// Bytes from memory; absent with `none` where there was no access at all.
fn memory_reads(traffic: BufferTraffic, none: &str) -> Value {
    if traffic.levels.iter().all(|level| level.accesses == 0) {
        return Value::absent(none);
    }
    Value::Count(traffic.dram_read_bytes)
}

fn accesses(accesses: u64, _: u64) -> Value {
    Value::Count(accesses)
}

fn misses(_: u64, misses: u64) -> Value {
    Value::Count(misses)
}

fn miss_ratio(accesses: u64, misses: u64) -> Value {
    Value::ratio(misses as f64, accesses as f64, NO_WORK)
}
