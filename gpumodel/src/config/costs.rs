//! What the shader's steps cost in operations, and the registers it holds.

use super::alpha::{AlphaCosts, AlphaFile};
use super::gpu::Gpu;
use super::intersection_costs::{RayIntersectionFile, ray_intersection};
use super::level_costs::{TwoLevelCosts, TwoLevelFile};
use super::reflections::{ReflectionCosts, ReflectionsFile, reflection_estimates, reflections};
use super::sourced::{File, Tag};
use super::stereo::{StereoCosts, StereoCostsFile};
use crate::error::Error;
use serde::Deserialize;
use std::ops::AddAssign;
use toml::Spanned;
use tracer::wide::NodeFormat;
use tracer::{Accel, AlphaTests, RayKind, TraceHeader};

const BUILTIN: &str = include_str!("../../../configs/costs.toml");
/// Most operations of one step.
const MOST_OPERATIONS: u32 = 1 << 16;

/// Scalar full-precision operations of one lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Of the ALU; the EFU's are not among them.
    pub alu: u32,
    /// Of the elementary function unit.
    pub efu: u32,
}

/// Operation counts of a ray-tracing shader, and its registers, by traversal.
#[derive(Clone, Debug)]
pub struct ShaderCosts {
    /// What every traversal's shader does.
    pub shared: SharedCosts,
    /// Missing in tables that were written before there were such rays.
    secondary: Option<SecondaryCosts>,
    secondary_estimates: Vec<String>,
    /// Missing in tables that were written before there were passes of reflections.
    reflections: Option<ReflectionCosts>,
    reflection_estimates: Vec<String>,
    /// Missing in tables that were written before there were two levels.
    pub(super) two_level: Option<TwoLevelCosts>,
    /// Missing in tables that were written before there were alpha tests.
    alpha: Option<AlphaCosts>,
    alpha_estimates: Vec<String>,
    /// Missing in tables that were written before there were two eyes.
    stereo: Option<StereoCosts>,
    stereo_estimates: Vec<String>,
    /// A ray query that a ray unit answers.
    pub ray_query: RayQueryCosts,
    /// Missing in tables that were written before there was such an instruction.
    ray_intersection: Option<TraversalCosts>,
    ray_intersection_estimates: Vec<String>,
    /// Missing in tables that were written before two levels were walked around it.
    pub(super) ray_intersection_two_level: Option<TwoLevelCosts>,
    bvh_stack: TraversalCosts,
    bvh_parent_link: TraversalCosts,
    bvh_restart_trail: TraversalCosts,
    kd_stack: TraversalCosts,
    kd_restart: TraversalCosts,
    kd_push_down: TraversalCosts,
    kd_backtrack: TraversalCosts,
    grid_dda: TraversalCosts,
    wide_full_4: TraversalCosts,
    wide_full_8: TraversalCosts,
    wide_compressed_8: TraversalCosts,
    wide_adreno_8: TraversalCosts,
}

/// Costs outside the traversal's own steps.
#[derive(Clone, Copy, Debug)]
pub struct SharedCosts {
    /// Making a primary ray.
    pub camera_ray: Cost,
    /// Preparing any ray for traversal.
    pub ray_setup: Cost,
    /// Shading a hit.
    pub shade: Cost,
    /// More of it where the first normal lies in the vertices' padding.
    pub compact_normal: Cost,
    /// Making a shadow ray.
    pub shadow_ray: Cost,
    /// Transforming the position of a vertex, for binning.
    pub vertex_position: Cost,
    /// Transforming a vertex.
    pub vertex: Cost,
    /// A rasterised fragment: its normal, encoded.
    pub geometry: Cost,
    /// The position of a rasterised hit, from its depth.
    pub unproject: Cost,
    /// Shading a rasterised hit with its encoded normal.
    pub decode_normal: Cost,
    /// Reading an image as a texture.
    pub present: Cost,
    /// Making the colour.
    pub output: Cost,
    /// Per load or store.
    pub address: Cost,
    /// Per trip of a loop.
    pub trip: Cost,
}

/// Costs of making rays that start at a hit, hard shadow rays apart. The hit's point and normal and the offset of the origin are among
/// them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SecondaryCosts {
    /// Drawing a point of a low-discrepancy sequence.
    pub(crate) sample: Cost,
    /// From there to a point of a light; the ray to it is [`SharedCosts::shadow_ray`].
    pub(crate) light_point: Cost,
    /// From there to a mirror or glossy reflection, by the roughness.
    pub(crate) reflection_ray: Cost,
    /// From there to a direction as dense as its cosine.
    pub(crate) cosine_ray: Cost,
}

/// Costs of a ray query that a ray unit answers.
#[derive(Clone, Copy, Debug)]
pub struct RayQueryCosts {
    /// Registers of four words per lane that the shader holds meanwhile.
    pub registers: u32,
    /// Handing a ray over and taking the answer.
    pub start: Cost,
}

/// Costs of a traversal's steps, by [`tracer::Op`], without address arithmetic and loop control.
#[derive(Clone, Copy, Debug)]
pub struct TraversalCosts {
    /// Registers of four words per lane, a short stack's not among them.
    pub registers: u32,
    /// Before the first step.
    pub start: Cost,
    /// [`tracer::Op::Node`].
    pub node: Cost,
    /// [`tracer::Op::Up`].
    pub up: Cost,
    /// [`tracer::Op::Restart`].
    pub restart: Cost,
    /// [`tracer::Op::Push`].
    pub push: Cost,
    /// [`tracer::Op::Pop`].
    pub pop: Cost,
    /// [`tracer::Op::Primitive`].
    pub primitive: Cost,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct CostsFile {
    shared: SharedFile,
    secondary: Option<SecondaryFile>,
    reflections: Option<ReflectionsFile>,
    two_level: Option<TwoLevelFile>,
    alpha: Option<AlphaFile>,
    stereo: Option<StereoCostsFile>,
    ray_query: RayQueryFile,
    ray_intersection: Option<RayIntersectionFile>,
    ray_intersection_two_level: Option<TwoLevelFile>,
    bvh_stack: TraversalFile,
    bvh_parent_link: TraversalFile,
    bvh_restart_trail: TraversalFile,
    kd_stack: TraversalFile,
    kd_restart: TraversalFile,
    kd_push_down: TraversalFile,
    kd_backtrack: TraversalFile,
    grid_dda: TraversalFile,
    #[serde(rename = "wide-full-4")]
    wide_full_4: TraversalFile,
    #[serde(rename = "wide-full-8")]
    wide_full_8: TraversalFile,
    #[serde(rename = "wide-compressed-8")]
    wide_compressed_8: TraversalFile,
    #[serde(rename = "wide-adreno-8")]
    wide_adreno_8: TraversalFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SharedFile {
    camera_ray: CostFile,
    ray_setup: CostFile,
    shade: CostFile,
    compact_normal: CostFile,
    shadow_ray: CostFile,
    vertex_position: CostFile,
    vertex: CostFile,
    geometry: CostFile,
    unproject: CostFile,
    decode_normal: CostFile,
    present: CostFile,
    output: CostFile,
    address: CostFile,
    r#loop: CostFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SecondaryFile {
    sample: TaggedCostFile,
    light_point: TaggedCostFile,
    reflection_ray: TaggedCostFile,
    cosine_ray: TaggedCostFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TaggedCostFile {
    alu: Spanned<u32>,
    efu: Spanned<u32>,
    source: Spanned<String>,
    pub(super) tag: Tag,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TaggedRegistersFile {
    pub(super) value: Spanned<u32>,
    pub(super) source: Spanned<String>,
    pub(super) tag: Tag,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RayQueryFile {
    registers: RegistersFile,
    start: CostFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TraversalFile {
    registers: RegistersFile,
    start: CostFile,
    node: CostFile,
    up: CostFile,
    restart: CostFile,
    push: CostFile,
    pop: CostFile,
    primitive: CostFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CostFile {
    alu: Spanned<u32>,
    efu: Spanned<u32>,
    source: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RegistersFile {
    value: Spanned<u32>,
    source: Spanned<String>,
}

impl ShaderCosts {
    /// Reads and checks a cost table; `file_name` is for messages only.
    ///
    /// # Errors
    /// Names the file, the line, the key, what was expected and the remedy.
    pub fn parse(toml_text: &str, file_name: &str) -> Result<Self, Error> {
        let file = File::new(file_name, toml_text);
        let raw: CostsFile = file.read()?;
        let cost = |key: &str, cost: &CostFile| read_cost(&file, key, cost);
        let traversal = |name: &str, raw: &TraversalFile| read_traversal(&file, name, raw);
        let mut secondary_estimates = Vec::new();
        let mut tagged = |key: &str, cost: &TaggedCostFile| {
            if cost.tag == Tag::Estimate {
                secondary_estimates.push(key.to_owned());
            }
            cost.read(&file, key)
        };
        let secondary = match &raw.secondary {
            Some(SecondaryFile { sample, light_point, reflection_ray, cosine_ray }) => Some(SecondaryCosts {
                sample: tagged("secondary.sample", sample)?,
                light_point: tagged("secondary.light_point", light_point)?,
                reflection_ray: tagged("secondary.reflection_ray", reflection_ray)?,
                cosine_ray: tagged("secondary.cosine_ray", cosine_ray)?,
            }),
            None => None,
        };
        let (alpha, alpha_estimates) = match &raw.alpha {
            Some(raw) => (Some(raw.read(&file)?), raw.estimates()),
            None => (None, Vec::new()),
        };
        let (stereo, stereo_estimates) = match &raw.stereo {
            Some(raw) => (Some(raw.read(&file)?), raw.estimates()),
            None => (None, Vec::new()),
        };
        let two_level = |name: &str, raw: &Option<TwoLevelFile>| {
            raw.as_ref().map(|raw| raw.read(&file, name)).transpose()
        };
        let mut ray_intersection_estimates = Vec::new();
        let ray_intersection = raw
            .ray_intersection
            .as_ref()
            .map(|raw| ray_intersection(&file, raw, &mut ray_intersection_estimates))
            .transpose()?;
        Ok(Self {
            ray_intersection,
            ray_intersection_estimates,
            two_level: two_level("two-level", &raw.two_level)?,
            ray_intersection_two_level: two_level(
                "ray-intersection-two-level",
                &raw.ray_intersection_two_level,
            )?,
            alpha,
            alpha_estimates,
            stereo,
            stereo_estimates,
            secondary,
            secondary_estimates,
            reflections: raw.reflections.as_ref().map(|raw| reflections(&file, raw)).transpose()?,
            reflection_estimates: reflection_estimates(toml_text),
            shared: SharedCosts {
                camera_ray: cost("shared.camera_ray", &raw.shared.camera_ray)?,
                ray_setup: cost("shared.ray_setup", &raw.shared.ray_setup)?,
                shade: cost("shared.shade", &raw.shared.shade)?,
                compact_normal: cost("shared.compact_normal", &raw.shared.compact_normal)?,
                shadow_ray: cost("shared.shadow_ray", &raw.shared.shadow_ray)?,
                vertex_position: cost("shared.vertex_position", &raw.shared.vertex_position)?,
                vertex: cost("shared.vertex", &raw.shared.vertex)?,
                geometry: cost("shared.geometry", &raw.shared.geometry)?,
                unproject: cost("shared.unproject", &raw.shared.unproject)?,
                decode_normal: cost("shared.decode_normal", &raw.shared.decode_normal)?,
                present: cost("shared.present", &raw.shared.present)?,
                output: cost("shared.output", &raw.shared.output)?,
                address: cost("shared.address", &raw.shared.address)?,
                trip: cost("shared.loop", &raw.shared.r#loop)?,
            },
            ray_query: RayQueryCosts {
                registers: {
                    let RegistersFile { value, source } = &raw.ray_query.registers;
                    read_registers(&file, "ray-query", value, source)?
                },
                start: cost("ray-query.start", &raw.ray_query.start)?,
            },
            bvh_stack: traversal("bvh-stack", &raw.bvh_stack)?,
            bvh_parent_link: traversal("bvh-parent-link", &raw.bvh_parent_link)?,
            bvh_restart_trail: traversal("bvh-restart-trail", &raw.bvh_restart_trail)?,
            kd_stack: traversal("kd-stack", &raw.kd_stack)?,
            kd_restart: traversal("kd-restart", &raw.kd_restart)?,
            kd_push_down: traversal("kd-push-down", &raw.kd_push_down)?,
            kd_backtrack: traversal("kd-backtrack", &raw.kd_backtrack)?,
            grid_dda: traversal("grid-dda", &raw.grid_dda)?,
            wide_full_4: traversal("wide-full-4", &raw.wide_full_4)?,
            wide_full_8: traversal("wide-full-8", &raw.wide_full_8)?,
            wide_compressed_8: traversal("wide-compressed-8", &raw.wide_compressed_8)?,
            wide_adreno_8: traversal("wide-adreno-8", &raw.wide_adreno_8)?,
        })
    }

    /// The table that comes with the program.
    ///
    /// # Errors
    /// Never, as long as the built-in file is sound; a test says so.
    pub fn builtin() -> Result<Self, Error> {
        Self::parse(BUILTIN, "costs.toml")
    }

    /// Costs of making the rays of a trace that start at a hit; nothing where it has none but hard shadow rays.
    ///
    /// # Errors
    /// When the trace has such rays and the table no costs of them.
    pub(crate) fn secondary(&self, header: &TraceHeader) -> Result<SecondaryCosts, Error> {
        if !has_secondary(header) {
            return Ok(SecondaryCosts::default());
        }
        self.secondary.ok_or_else(|| Error::Trace {
            scene: header.scene.clone(),
            problem: "it has rays whose making the table of shader costs does not know".to_owned(),
            remedy: "add a table [secondary] to it, as configs/costs.toml has".to_owned(),
        })
    }

    /// Costs of alpha tests; nothing where no shader makes any.
    ///
    /// # Errors
    /// When the trace has alpha tests and the table no costs of them.
    pub(crate) fn alpha(&self, header: &TraceHeader) -> Result<AlphaCosts, Error> {
        if !header.alpha.as_ref().is_some_and(AlphaTests::run_shaders) {
            return Ok(AlphaCosts::default());
        }
        self.alpha.ok_or_else(|| Error::Trace {
            scene: header.scene.clone(),
            problem: "it has alpha tests, which the table of shader costs does not know".to_owned(),
            remedy: "add a table [alpha] to it, as configs/costs.toml has".to_owned(),
        })
    }

    /// Keys of the costs of [`Self::alpha`] that are estimates.
    pub(crate) fn alpha_estimates(&self) -> &[String] {
        &self.alpha_estimates
    }

    /// Costs of the kernels between two eyes, where the table has them.
    pub fn stereo(&self) -> Option<&StereoCosts> {
        self.stereo.as_ref()
    }

    /// Keys of the costs of [`Self::stereo`] that are estimates.
    pub fn stereo_estimates(&self) -> &[String] {
        &self.stereo_estimates
    }

    /// A node step in a binary TLAS.
    pub(crate) fn tlas_node(&self) -> Cost {
        self.bvh_stack.node
    }

    /// Keys of the costs of [`Self::secondary`] that are estimates.
    pub(crate) fn secondary_estimates(&self) -> &[String] {
        &self.secondary_estimates
    }

    /// Costs of making rays that start at a hit, where the table has them.
    pub(crate) fn secondary_rays(&self) -> Option<&SecondaryCosts> {
        self.secondary.as_ref()
    }

    /// Costs of the passes of reflections, where the table has them.
    pub fn reflections(&self) -> Option<&ReflectionCosts> {
        self.reflections.as_ref()
    }

    /// Keys of the costs of [`Self::reflections`] that are estimates.
    pub fn reflection_estimates(&self) -> &[String] {
        &self.reflection_estimates
    }

    /// Costs of what a shader does of a trace's traversal on a GPU: all of it, or what is left of it where a ray unit tests nodes at its instruction.
    ///
    /// # Errors
    /// As [`Self::traversal`].
    pub(crate) fn of_shader(&self, header: &TraceHeader, gpu: &Gpu) -> Result<TraversalCosts, Error> {
        if gpu.has_instruction_for(header) { self.around_instruction(header) } else { self.traversal(header) }
    }

    /// Keys of the costs around a ray unit's instruction that are estimates.
    pub(crate) fn ray_intersection_estimates(&self) -> &[String] {
        &self.ray_intersection_estimates
    }

    fn around_instruction(&self, header: &TraceHeader) -> Result<TraversalCosts, Error> {
        self.ray_intersection.ok_or_else(|| Error::Trace {
            scene: header.scene.clone(),
            problem: "its traversal short-stack is one that the table of shader costs does not know"
                .to_owned(),
            remedy: "add a table [ray-intersection] to it, as configs/costs.toml has".to_owned(),
        })
    }

    /// Costs of the traversal that a trace was made with, where a shader does all of it. That of a wide BVH with a short stack takes its nodes and triangles as
    /// the one with a full stack, and keeps its stack as around the instruction of a ray unit.
    ///
    /// # Errors
    /// When the trace names a traversal that has no costs.
    pub fn traversal(&self, header: &TraceHeader) -> Result<TraversalCosts, Error> {
        let wide = match header.node_format {
            Some(NodeFormat::Full4) => self.wide_full_4,
            Some(NodeFormat::Full8) => self.wide_full_8,
            Some(NodeFormat::Adreno8) => self.wide_adreno_8,
            // Without a format there is no layout either, which is refused.
            Some(NodeFormat::Compressed8 | NodeFormat::Compressed8Pairs) | None => self.wide_compressed_8,
        };
        match (header.accel, header.traversal.as_str()) {
            (Accel::TwoLevel, "stack") if header.node_format.is_none() => Ok(self.bvh_stack),
            (Accel::WideBvh | Accel::TwoLevel, "stack") => Ok(wide),
            (Accel::WideBvh | Accel::TwoLevel, "short-stack") => {
                let TraversalCosts { restart, push, pop, .. } = self.around_instruction(header)?;
                Ok(TraversalCosts { restart, push, pop, ..wide })
            }
            (Accel::Bvh, "stack") => Ok(self.bvh_stack),
            (Accel::Bvh, "parent-link") => Ok(self.bvh_parent_link),
            (Accel::Bvh, "restart-trail") => Ok(self.bvh_restart_trail),
            (Accel::Kd, "stack") => Ok(self.kd_stack),
            (Accel::Kd, "restart") => Ok(self.kd_restart),
            (Accel::Kd, "push-down") => Ok(self.kd_push_down),
            (Accel::Kd, "backtrack") => Ok(self.kd_backtrack),
            (Accel::Grid, "dda") => Ok(self.grid_dda),
            (accel, other) => Err(Error::Trace {
                scene: header.scene.clone(),
                problem: format!("its {} traversal '{other}' has no operation counts", accel.name()),
                remedy: "expected bvh stack, parent-link or restart-trail, wide-bvh stack or short-stack, kd stack, restart, push-down or backtrack, grid dda, or two-level stack or short-stack"
                    .to_owned(),
            }),
        }
    }
}

/// Whether a trace has rays that start at a hit and are no hard shadow rays of primary hits.
pub(crate) fn has_secondary(header: &TraceHeader) -> bool {
    header.ray_sets.iter().any(|set| !matches!(set.kind, RayKind::Primary | RayKind::Shadow))
}

impl TaggedCostFile {
    pub(super) fn read(&self, file: &File<'_>, key: &str) -> Result<Cost, Error> {
        read_operations(file, key, [&self.alu, &self.efu], &self.source)
    }
}

fn read_cost(file: &File<'_>, key: &str, cost: &CostFile) -> Result<Cost, Error> {
    read_operations(file, key, [&cost.alu, &cost.efu], &cost.source)
}

fn read_operations(
    file: &File<'_>,
    key: &str,
    [alu, efu]: [&Spanned<u32>; 2],
    source: &Spanned<String>,
) -> Result<Cost, Error> {
    file.said(key, source)?;
    for operations in [alu, efu] {
        let count = *operations.get_ref();
        if count > MOST_OPERATIONS {
            let problem = format!("is {count}, expected at most {MOST_OPERATIONS} operations");
            return Err(file.refuse(key, &operations.span(), problem, "correct the value"));
        }
    }
    Ok(Cost { alu: *alu.get_ref(), efu: *efu.get_ref() })
}

pub(super) fn read_registers(
    file: &File<'_>,
    name: &str,
    value: &Spanned<u32>,
    source: &Spanned<String>,
) -> Result<u32, Error> {
    let key = format!("{name}.registers");
    file.said(&key, source)?;
    let registers = *value.get_ref();
    if registers == 0 {
        let problem = "is 0, expected at least 1 register per lane";
        return Err(file.refuse(&key, &value.span(), problem, "correct the value"));
    }
    Ok(registers)
}

fn read_traversal(file: &File<'_>, name: &str, raw: &TraversalFile) -> Result<TraversalCosts, Error> {
    let cost = |field: &str, cost: &CostFile| read_cost(file, &format!("{name}.{field}"), cost);
    Ok(TraversalCosts {
        registers: read_registers(file, name, &raw.registers.value, &raw.registers.source)?,
        start: cost("start", &raw.start)?,
        node: cost("node", &raw.node)?,
        up: cost("up", &raw.up)?,
        restart: cost("restart", &raw.restart)?,
        push: cost("push", &raw.push)?,
        pop: cost("pop", &raw.pop)?,
        primitive: cost("primitive", &raw.primitive)?,
    })
}

impl Cost {
    /// This cost `times` over.
    pub(crate) fn times(self, times: u32) -> Self {
        Self { alu: self.alu * times, efu: self.efu * times }
    }
}

impl AddAssign for Cost {
    fn add_assign(&mut self, other: Self) {
        let Self { alu, efu } = other;
        self.alu += alu;
        self.efu += efu;
    }
}
