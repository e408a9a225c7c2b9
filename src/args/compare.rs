//! Options of comparisons and what-ifs.

use super::{DEFAULT_SCENE, Format, FrameArgs, MachineArgs, RunArgs, SampleArgs};
use clap::Args;
use clap::builder::PossibleValuesParser;
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(crate) struct CompareArgs {
    /// Built-in scenes, .obj, .obj.zst, .gltf, .glb, or scene files .toml; or finished reports (.json), which nothing varies.
    #[arg(default_value = DEFAULT_SCENE, value_name = "SCENE|REPORT.json")]
    pub(crate) subjects: Vec<String>,
    /// What varies: traversal, ct-ci, short-stack, node-format, ray-sets, force, spp, shadow-query, gpu, technique, layout,
    /// primitive-order, node-records, node-order, ray-unit, alpha, micromap-level, an option of reflections such as binning, or a
    /// figure of the GPU such as cache.uche.size; with values as in layout=padded+split, ct-ci=3:1.5+1:3.5,
    /// ray-sets=mirror+hard-shadows:ao, cache.uche.size=65536+131072, else all of them; ct-ci=fine is a grid of 36.
    #[arg(long, value_name = "AXIS[=V+V]", value_delimiter = ',')]
    pub(crate) vary: Vec<String>,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Also write tables, charts and heat maps into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) frame: FrameArgs,
    #[command(flatten)]
    pub(crate) machine: MachineArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Args, Debug)]
pub(crate) struct WhatifArgs {
    /// A trace file that `raybudget trace` wrote.
    #[arg(value_name = "F.rbt")]
    pub(crate) trace: PathBuf,
    /// Other GPUs, by name or file.
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    pub(crate) gpu: Vec<String>,
    /// Other figures of the GPU, such as cache.uche.line=128 or cache.uche.size=65536+262144; may be given again.
    #[arg(long, value_name = "KEY=V+V")]
    pub(crate) set: Vec<String>,
    /// Other techniques, by name or file.
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    pub(crate) technique: Vec<String>,
    /// Other primitive layouts.
    #[arg(long, value_delimiter = ',', value_parser = PossibleValuesParser::new(gpumodel::PrimitiveLayout::ALL.map(gpumodel::PrimitiveLayout::name)))]
    pub(crate) layout: Vec<String>,
    /// Other orders of triangles.
    #[arg(long, value_name = "ORDER", value_delimiter = ',', value_parser = PossibleValuesParser::new(gpumodel::PrimitiveOrder::ALL.map(gpumodel::PrimitiveOrder::name)))]
    pub(crate) primitive_order: Vec<String>,
    /// Other contents of node records.
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = PossibleValuesParser::new(gpumodel::NodeRecords::ALL.map(gpumodel::NodeRecords::name)))]
    pub(crate) node_records: Vec<String>,
    /// Other orders of nodes.
    #[arg(long, value_name = "ORDER", value_delimiter = ',', value_parser = PossibleValuesParser::new(gpumodel::NodeOrder::ALL.map(gpumodel::NodeOrder::name)))]
    pub(crate) node_order: Vec<String>,
    /// Bins into which workgroups sort the reflection rays of the trace: sign, octahedral-4x4, position-2, position-sign-1, or other numbers. The unchanged
    /// frame is then that of these rays in the order in which they arrive. Without any of these options, every change of layout, order and technique is
    /// tried.
    #[arg(long, value_name = "BINS", value_delimiter = ',')]
    pub(crate) binning: Vec<String>,
    /// The GPU of the unchanged frame, by name or file.
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) base: Option<String>,
    /// A file with the ALU and EFU costs of the shaders, instead of the built-in one.
    #[arg(long, value_name = "FILE")]
    pub(crate) costs: Option<PathBuf>,
    /// A file with the energies of events, memory and leakage, instead of the built-in one.
    #[arg(long, value_name = "FILE")]
    pub(crate) energy: Option<PathBuf>,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Also write tables into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) sample: SampleArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}
