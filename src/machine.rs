//! The machine as it was asked for, checked: the GPU, the shader's costs, the technique, the layouts, and their hashes.

use crate::args::{MachineArgs, ReflectionArgs, SAMPLED};
use crate::figures::with_figures;
use crate::output::read_text;
use anyhow::{anyhow, bail};
use gpumodel::energy::EnergyPrices;
use gpumodel::ordering::{AtomicStrategy, Binning};
use gpumodel::{
    EnergyTable, Fidelity, GPUS, Gpu, HitShading, Launch, NodeOrder, NodeRecords, PrimitiveLayout,
    PrimitiveOrder, QueryOrigin, RayScheduling, ReplayConfig, ScreenSpace, SecondaryQuery, ShaderCosts,
    TECHNIQUES, Technique,
};
use std::path::Path;
use xxhash_rust::xxh3::xxh3_64;

const DEFAULT_GPU: &str = "adreno-540";
const DEFAULT_TECHNIQUE: &str = "fragment";
const BUILTIN_COSTS: &str = include_str!("../configs/costs.toml");

/// What a frame is replayed through.
#[derive(Clone)]
pub(crate) struct Machine {
    pub(crate) config: ReplayConfig,
    /// What the GPU is called, with the figures that were set.
    pub(crate) gpu_name: String,
    /// Of the text of the GPU's description.
    pub(crate) gpu_hash: String,
    /// Of the text of the costs.
    pub(crate) costs_hash: String,
    /// Of the text of the energies.
    pub(crate) energy_hash: String,
    /// The rung that replays a sample was asked for.
    pub(crate) sampled: bool,
}

impl Machine {
    /// As [`Self::new`], for commands that take no samples.
    pub(crate) fn of_whole_frames(args: &MachineArgs) -> anyhow::Result<Self> {
        let machine = Self::new(args)?;
        if machine.sampled {
            bail!(
                "--fidelity {SAMPLED}: only profile, replay and whatif take samples by it; leave it out here"
            );
        }
        Ok(machine)
    }

    pub(crate) fn new(args: &MachineArgs) -> anyhow::Result<Self> {
        let MachineArgs {
            gpu,
            set,
            technique,
            layout,
            primitive_order,
            node_records,
            node_order,
            ray_unit,
            fidelity,
            costs,
            energy,
            reflections,
        } = args;
        let asked = gpu.as_deref().unwrap_or(DEFAULT_GPU);
        let gpu_file = file_of_gpu(asked);
        let (mut gpu, gpu_name, gpu_hash) = find_gpu(asked, set)?;
        set_ray_unit(&mut gpu, ray_unit.as_deref())?;
        let mut technique = find_technique(technique.as_deref().unwrap_or(DEFAULT_TECHNIQUE))?;
        set_reflections(&mut technique, reflections)?;
        if gpu.emulates(&technique) {
            gpu.ray_unit = None;
        }
        let primitive_layout = choice(
            "--layout",
            layout,
            PrimitiveLayout::from_name,
            &PrimitiveLayout::ALL.map(PrimitiveLayout::name),
        )?;
        let primitive_order = choice(
            "--primitive-order",
            primitive_order,
            PrimitiveOrder::from_name,
            &PrimitiveOrder::ALL.map(PrimitiveOrder::name),
        )?;
        let node_records = choice(
            "--node-records",
            node_records,
            NodeRecords::from_name,
            &NodeRecords::ALL.map(NodeRecords::name),
        )?;
        let node_order =
            choice("--node-order", node_order, NodeOrder::from_name, &NodeOrder::ALL.map(NodeOrder::name))?;
        let sampled = fidelity.as_deref() == Some(SAMPLED);
        let whole = fidelity.clone().filter(|_| !sampled);
        let fidelity = choice("--fidelity", &whole, Fidelity::from_name, &Fidelity::ALL.map(Fidelity::name))?;
        let (costs, costs_hash) = match costs {
            None => (ShaderCosts::parse(BUILTIN_COSTS, "configs/costs.toml")?, hash(BUILTIN_COSTS)),
            Some(path) => {
                let text = read_text(path, "a table of shader costs (.toml)")?;
                (ShaderCosts::parse(&text, &path.display().to_string())?, hash(&text))
            }
        };
        let (energy, energy_hash) = match energy {
            None => (EnergyTable::builtin()?, hash(EnergyTable::builtin_text())),
            Some(path) => {
                let text = read_text(path, "a table of energies (.toml)")?;
                (EnergyTable::parse(&text, &path.display().to_string())?, hash(&text))
            }
        };
        // What the table does not know is said before a frame is traced.
        EnergyPrices::new(&energy, &gpu).map_err(|error| in_file(error, gpu_file))?;
        let config = ReplayConfig {
            gpu,
            costs,
            energy,
            technique,
            primitive_layout: primitive_layout.unwrap_or_default(),
            primitive_order,
            node_records: node_records.unwrap_or_default(),
            node_order: node_order.unwrap_or_default(),
            fidelity: fidelity.unwrap_or_default(),
            keeps_misses: false,
        };
        Ok(Self { config, gpu_name, gpu_hash, costs_hash, energy_hash, sampled })
    }
}

/// Takes the ray unit of a GPU away, or schedules its rays in another way.
fn set_ray_unit(gpu: &mut Gpu, choice: Option<&str>) -> anyhow::Result<()> {
    match choice {
        None | Some("gpu") => {}
        Some("none") => gpu.ray_unit = None,
        Some(name) => {
            let Some(scheduling) = RayScheduling::from_name(name) else {
                bail!("--ray-unit {name}: no such choice; use one of: gpu, none, warp, ray, instruction");
            };
            let Some(unit) = &mut gpu.ray_unit else {
                bail!(
                    "--ray-unit {name}: {} has no [ray_unit]; use none, or a GPU that has one, such as mali-g715",
                    gpu.name()
                );
            };
            unit.scheduling = scheduling;
        }
    }
    Ok(())
}

/// Changes parts of a technique's reflections; its name tells which.
fn set_reflections(technique: &mut Technique, args: &ReflectionArgs) -> anyhow::Result<()> {
    let given = args.given();
    let Some((option, value)) = given.first() else { return Ok(()) };
    let name = technique.name.clone();
    let Some(reflections) = &mut technique.reflections else {
        bail!(
            "--{option} {value}: technique {name} has no [reflections]; use one of reflections-*, or leave it out"
        );
    };
    let ReflectionArgs {
        screen_space,
        launch,
        binning,
        query_origin,
        hit_shading,
        secondary_query,
        payload,
        materials,
        atomics,
    } = args;
    let names = |names: &[&'static str]| names.join(", ");
    macro_rules! set {
        ($field:ident, $option:literal, $kind:ty) => {
            if let Some(value) = $field {
                let Some(choice) = <$kind>::from_name(value) else {
                    let all = names(&<$kind>::ALL.map(<$kind>::name));
                    bail!("--{} {value}: no such choice; use one of: {all}", $option);
                };
                reflections.$field = choice;
            }
        };
    }
    set!(screen_space, "screen-space", ScreenSpace);
    set!(launch, "launch", Launch);
    set!(query_origin, "query-origin", QueryOrigin);
    set!(hit_shading, "hit-shading", HitShading);
    set!(secondary_query, "secondary-query", SecondaryQuery);
    set!(atomics, "atomics", AtomicStrategy);
    let number = |option: &str, value: &Option<String>| {
        let parse = |value: &String| {
            value
                .parse::<u32>()
                .map_err(|_| anyhow!("--{option} {value}: expected a whole number, such as 16"))
        };
        value.as_ref().map(parse).transpose()
    };
    reflections.payload_bytes = number("payload", payload)?;
    reflections.materials = number("materials", materials)?;
    if let Some(value) = binning {
        reflections.binning =
            Binning::from_name(value).map_err(|error| anyhow!("--binning {value}: {error}"))?;
    }
    if let Err(problem) = reflections.check() {
        bail!("technique {name} with these options {problem}; change one of the two");
    }
    let changes: Vec<String> = given.iter().map(|(option, value)| format!("{option} {value}")).collect();
    technique.name = format!("{name} with {}", changes.join(", "));
    Ok(())
}

/// The value of an option with a closed set of names.
pub(crate) fn choice<T>(
    option: &str,
    name: &Option<String>,
    from_name: impl Fn(&str) -> Option<T>,
    names: &[&str],
) -> anyhow::Result<Option<T>> {
    let find = |name: &String| {
        from_name(name)
            .ok_or_else(|| anyhow!("{option} {name}: no such choice; use one of: {}", names.join(", ")))
    };
    name.as_ref().map(find).transpose()
}

/// The file that describes a GPU.
fn file_of_gpu(name: &str) -> String {
    let builtin = GPUS.iter().any(|gpu| gpu.name == name);
    if builtin { format!("configs/gpus/{name}.toml") } else { name.to_owned() }
}

/// A wrong figure of a GPU, with the file that has it.
fn in_file(error: gpumodel::Error, file: String) -> gpumodel::Error {
    match error {
        gpumodel::Error::Config { line, key, problem, remedy, .. } => {
            gpumodel::Error::Config { file, line, key, problem, remedy }
        }
        other => other,
    }
}

/// A built-in name wins over a file of that name; `./adreno-540` is the file.
fn find_gpu(name: &str, figures: &[String]) -> anyhow::Result<(Gpu, String, String)> {
    let builtin = GPUS.iter().find(|gpu| gpu.name == name);
    let text = match builtin {
        Some(builtin) => builtin.toml.to_owned(),
        None => described(name)?,
    };
    let file = file_of_gpu(name);
    if figures.is_empty() {
        let gpu = Gpu::parse(&text, &file)?;
        let called = gpu.name().to_owned();
        return Ok((gpu, called, hash(&text)));
    }
    let text = with_figures(&text, &file, figures)?;
    let set = format!("{file} with --set {}", figures.join(" --set "));
    // Lines of the rewritten text are lines of no file.
    let gpu = Gpu::parse(&text, &set).map_err(|error| match error {
        gpumodel::Error::Config { file, key, problem, remedy, .. } => {
            gpumodel::Error::Config { file, line: None, key, problem, remedy }
        }
        other => other,
    })?;
    let called = format!("{} with {}", gpu.name(), figures.join(", "));
    Ok((gpu, called, hash(&text)))
}

fn described(name: &str) -> anyhow::Result<String> {
    let path = Path::new(name);
    if !path.exists() {
        let names: Vec<&str> = GPUS.iter().map(|gpu| gpu.name).collect();
        bail!(
            "--gpu {name}: neither a described GPU nor a file; use one of: {}; or a file like configs/gpus/{}.toml",
            names.join(", "),
            names[0]
        );
    }
    read_text(path, "a description of a GPU (.toml)")
}

fn find_technique(name: &str) -> anyhow::Result<Technique> {
    if let Some(technique) = TECHNIQUES.iter().find(|technique| technique.name == name) {
        return Ok(Technique::parse(technique.toml, &format!("configs/techniques/{name}.toml"))?);
    }
    let path = Path::new(name);
    if !path.exists() {
        let names: Vec<&str> = TECHNIQUES.iter().map(|technique| technique.name).collect();
        bail!(
            "--technique {name}: neither a built-in technique nor a file; use one of: {}; or a file like \
             configs/techniques/{}.toml",
            names.join(", "),
            names[0]
        );
    }
    Ok(Technique::parse(&read_text(path, "a technique (.toml)")?, name)?)
}

/// Of a file's text, with line ends as one byte: the same file has the same hash wherever it was checked out.
fn hash(text: &str) -> String {
    format!("{:016x}", xxh3_64(text.replace("\r\n", "\n").as_bytes()))
}
