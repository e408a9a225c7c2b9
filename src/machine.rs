//! The machine as it was asked for, checked: the GPU, the shader's costs, the layout, and their hashes.

use crate::args::MachineArgs;
use crate::output::read_text;
use anyhow::{anyhow, bail};
use gpumodel::{GPUS, Gpu, NodeOrder, PrimitiveLayout, ReplayConfig, ShaderCosts};
use std::path::Path;
use xxhash_rust::xxh3::xxh3_64;

const DEFAULT_GPU: &str = "adreno-540";
/// How a frame is rendered: the name, and what it stands for.
pub(crate) const TECHNIQUE: [&str; 2] = [
    "fragment",
    "one fragment shader per pixel traces the primary ray, then a shadow ray to each light, shades and writes the colour",
];

const BUILTIN_COSTS: &str = include_str!("../configs/costs.toml");

/// What a frame is replayed through.
pub(crate) struct Machine {
    pub(crate) config: ReplayConfig,
    /// Of the text of the GPU's description.
    pub(crate) gpu_hash: String,
    /// Of the text of the costs.
    pub(crate) costs_hash: String,
}

impl Machine {
    pub(crate) fn new(args: &MachineArgs) -> anyhow::Result<Self> {
        let MachineArgs { gpu, layout, costs } = args;
        let (gpu, gpu_hash) = find_gpu(gpu.as_deref().unwrap_or(DEFAULT_GPU))?;
        let layout = layout.as_deref().unwrap_or(PrimitiveLayout::Padded.name());
        let primitive_layout = PrimitiveLayout::from_name(layout)
            .ok_or_else(|| anyhow!("--layout {layout}: no such layout; see `raybudget list layouts`"))?;
        let (costs, costs_hash) = match costs {
            None => (ShaderCosts::parse(BUILTIN_COSTS, "configs/costs.toml")?, hash(BUILTIN_COSTS)),
            Some(path) => {
                let text = read_text(path, "a table of shader costs (.toml)")?;
                (ShaderCosts::parse(&text, &path.display().to_string())?, hash(&text))
            }
        };
        let config = ReplayConfig { gpu, costs, primitive_layout, node_order: NodeOrder::default() };
        Ok(Self { config, gpu_hash, costs_hash })
    }
}

/// A built-in name wins over a file of that name; `./adreno-540` is the file.
fn find_gpu(name: &str) -> anyhow::Result<(Gpu, String)> {
    if let Some(builtin) = GPUS.iter().find(|gpu| gpu.name == name) {
        return Ok((Gpu::parse(builtin.toml, &format!("configs/gpus/{name}.toml"))?, hash(builtin.toml)));
    }
    let path = Path::new(name);
    if !path.exists() {
        let names: Vec<&str> = GPUS.iter().map(|gpu| gpu.name).collect();
        bail!(
            "--gpu {name}: neither a described GPU nor a file; use one of: {}; or a file like configs/gpus/{}.toml",
            names.join(", "),
            names[0]
        );
    }
    let text = read_text(path, "a description of a GPU (.toml)")?;
    Ok((Gpu::parse(&text, name)?, hash(&text)))
}

/// Of a file's text, with line ends as one byte: the same file has the same hash wherever it was checked out.
fn hash(text: &str) -> String {
    format!("{:016x}", xxh3_64(text.replace("\r\n", "\n").as_bytes()))
}
