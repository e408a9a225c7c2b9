//! What two levels cost a shader beside the steps in either.

use super::costs::{Cost, ShaderCosts, TaggedCostFile, TaggedRegistersFile, read_registers};
use super::gpu::Gpu;
use super::sourced::{File, Tag};
use crate::error::Error;
use serde::Deserialize;
use tracer::{Accel, TraceHeader};

/// What a traversal of two levels costs beside the steps in either.
#[derive(Clone, Debug)]
pub(crate) struct TwoLevelCosts {
    /// Registers of four words per lane that hold the ray in the world, and where it is, meanwhile.
    pub(crate) registers: u32,
    /// [`tracer::Op::Instance`]: the ray into the space of the mesh, and back.
    pub(crate) instance: Cost,
    /// Keys of what is an estimate.
    pub(crate) estimates: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TwoLevelFile {
    registers: TaggedRegistersFile,
    instance: TaggedCostFile,
}

impl TwoLevelFile {
    pub(super) fn read(&self, file: &File<'_>, name: &str) -> Result<TwoLevelCosts, Error> {
        let Self { registers, instance } = self;
        let key = |field: &str| format!("{name}.{field}");
        let tagged = [("registers", registers.tag), ("instance", instance.tag)];
        let estimates = tagged.into_iter().filter(|(_, tag)| *tag == Tag::Estimate);
        Ok(TwoLevelCosts {
            registers: read_registers(file, name, &registers.value, &registers.source)?,
            instance: instance.read(file, &key("instance"))?,
            estimates: estimates.map(|(field, _)| key(field)).collect(),
        })
    }
}

impl ShaderCosts {
    /// Costs of two levels beside those of the traversal, where shaders do all, or around the instruction of a ray unit that tests nodes; `None`
    /// where a trace has one level.
    ///
    /// # Errors
    /// When the trace has two levels and the table no costs of them.
    pub(crate) fn two_level(&self, header: &TraceHeader, gpu: &Gpu) -> Result<Option<&TwoLevelCosts>, Error> {
        if header.accel != Accel::TwoLevel {
            return Ok(None);
        }
        let (costs, table, where_from) = if gpu.has_instruction_for(header) {
            (
                &self.ray_intersection_two_level,
                "ray-intersection-two-level",
                " around the instruction of a ray unit",
            )
        } else {
            (&self.two_level, "two-level", "")
        };
        costs.as_ref().map(Some).ok_or_else(|| Error::Trace {
            scene: header.scene.clone(),
            problem: format!("it has two levels{where_from}, which the table of shader costs does not know"),
            remedy: format!("add a table [{table}] to it, as configs/costs.toml has"),
        })
    }
}
