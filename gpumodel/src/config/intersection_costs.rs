//! What a shader does around a ray unit's instruction that tests a node or a triangle.

use super::costs::{Cost, TaggedCostFile, TaggedRegistersFile, TraversalCosts, read_registers};
use super::sourced::{File, Tag};
use crate::error::Error;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RayIntersectionFile {
    registers: TaggedRegistersFile,
    start: TaggedCostFile,
    node: TaggedCostFile,
    restart: TaggedCostFile,
    push: TaggedCostFile,
    pop: TaggedCostFile,
    primitive: TaggedCostFile,
}

/// Puts the keys of estimates behind the others.
pub(super) fn ray_intersection(
    file: &File<'_>,
    raw: &RayIntersectionFile,
    estimates: &mut Vec<String>,
) -> Result<TraversalCosts, Error> {
    let RayIntersectionFile { registers, start, node, restart, push, pop, primitive } = raw;
    let mut read = |field: &str, tag: Tag| {
        let key = format!("ray-intersection.{field}");
        if tag == Tag::Estimate {
            estimates.push(key.clone());
        }
        key
    };
    let registers = {
        read("registers", registers.tag);
        read_registers(file, "ray-intersection", &registers.value, &registers.source)?
    };
    let mut cost = |field: &str, cost: &TaggedCostFile| cost.read(file, &read(field, cost.tag));
    Ok(TraversalCosts {
        registers,
        start: cost("start", start)?,
        node: cost("node", node)?,
        up: Cost::default(),
        restart: cost("restart", restart)?,
        push: cost("push", push)?,
        pop: cost("pop", pop)?,
        primitive: cost("primitive", primitive)?,
    })
}
