//! Options of what a frame is replayed through.

use super::{ReflectionArgs, SAMPLED};
use clap::Args;
use clap::builder::PossibleValuesParser;
use std::path::PathBuf;

/// What the frame is replayed through.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Machine")]
pub(crate) struct MachineArgs {
    /// A described GPU by name, or a file that describes one [default: adreno-540].
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) gpu: Option<String>,
    /// Change one figure of the GPU's description, such as cache.uche.line=128; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// How the frame is rendered: a built-in technique by name, or a file [default: fragment].
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) technique: Option<String>,
    /// How triangles lie in memory [default: padded].
    #[arg(long, value_parser = PossibleValuesParser::new(gpumodel::PrimitiveLayout::ALL.map(gpumodel::PrimitiveLayout::name)))]
    pub(crate) layout: Option<String>,
    /// Triangles in the order of the leaves, or in file order behind an index list [default: leaf for a BVH, else indexed].
    #[arg(long, value_name = "ORDER", value_parser = PossibleValuesParser::new(gpumodel::PrimitiveOrder::ALL.map(gpumodel::PrimitiveOrder::name)))]
    pub(crate) primitive_order: Option<String>,
    /// What a node record holds [default: packed].
    #[arg(long, value_name = "KIND", value_parser = PossibleValuesParser::new(gpumodel::NodeRecords::ALL.map(gpumodel::NodeRecords::name)))]
    pub(crate) node_records: Option<String>,
    /// In which order nodes lie in memory [default: depth-first].
    #[arg(long, value_name = "ORDER", value_parser = PossibleValuesParser::new(gpumodel::NodeOrder::ALL.map(gpumodel::NodeOrder::name)))]
    pub(crate) node_order: Option<String>,
    /// Who walks a wide BVH on a GPU with a ray unit: shaders (none), the unit with rays scheduled by warps or each by itself, shaders around an
    /// instruction that tests a node (adreno-8, --traversal short-stack), or as the GPU's description has it [default: gpu].
    #[arg(long, value_name = "UNIT", value_parser = PossibleValuesParser::new(["gpu", "none", "warp", "ray", "instruction"]))]
    pub(crate) ray_unit: Option<String>,
    /// How time is found: warps in turns and what they ask of each resource, a sample of these, or event by event, slower [default: replay].
    #[arg(long, value_name = "RUNG", value_parser = PossibleValuesParser::new(rungs()))]
    pub(crate) fidelity: Option<String>,
    /// A file with the ALU and EFU costs of the shaders, instead of the built-in one.
    #[arg(long, value_name = "FILE")]
    pub(crate) costs: Option<PathBuf>,
    /// A file with the energies of events, memory and leakage, instead of the built-in one.
    #[arg(long, value_name = "FILE")]
    pub(crate) energy: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reflections: ReflectionArgs,
}

/// Names of all rungs of fidelity, the quickest first.
fn rungs() -> Vec<&'static str> {
    std::iter::once(SAMPLED).chain(gpumodel::Fidelity::ALL.map(gpumodel::Fidelity::name)).collect()
}
