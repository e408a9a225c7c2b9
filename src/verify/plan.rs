//! From a claim's setup to what must be traced and replayed for it.

use crate::args::{FrameArgs, MachineArgs};
use anyhow::bail;
use reports::claims::Setup;
use scenes::Feature;

/// What a setup traces: setups of one plan share a trace.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct TracePlan {
    pub(super) traversal: String,
    pub(super) short_stack: String,
    pub(super) trail_bits: String,
    pub(super) ct: String,
    pub(super) ci: String,
}

/// How its trace is used.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Use {
    /// Replayed through a machine.
    Replay(Box<MachineArgs>),
    /// Not recorded: the time of the unobserved tracer on one thread of this machine.
    Cpu,
}

/// Figures of the Adreno 540 that a reading changes: the name of the machine in claim files, and the figure.
const MACHINES: [(&str, &[&str]); 5] = [
    ("adreno-540", &[]),
    ("ssbo-through-l1", &["paths.ssbo=[\"tp_l1\", \"uche\"]"]),
    ("alu-32-per-core", &["shader_cores.alu_lanes=32"]),
    ("alu-96-per-core", &["shader_cores.alu_lanes=96"]),
    ("load-store-64", &["load_store.bytes_per_clock=64"]),
];

fn axis<'a>(setup: &'a Setup, name: &str) -> &'a str {
    setup.get(name).unwrap_or_default()
}

impl TracePlan {
    pub(super) fn of(setup: &Setup) -> Self {
        let of_axis = |name: &str| axis(setup, name).to_owned();
        Self {
            traversal: of_axis("traversal"),
            short_stack: of_axis("short_stack"),
            trail_bits: of_axis("trail_bits"),
            ct: of_axis("ct"),
            ci: of_axis("ci"),
        }
    }

    /// As the command line would say it. The paper's triangles have normals in every scene.
    pub(super) fn frame_args(&self, [width, height]: [u32; 2]) -> anyhow::Result<FrameArgs> {
        let (accel, traversal) = self.traversal.split_once(' ').unwrap_or((&self.traversal, "dda"));
        let is_trail = traversal == "restart-trail";
        let number = |text: &str| text.parse::<f64>();
        let of_tree = accel != "grid";
        Ok(FrameArgs {
            accel: Some(accel.to_owned()),
            traversal: Some(traversal.to_owned()),
            size: Some(format!("{width}x{height}")),
            ct: of_tree.then(|| number(&self.ct)).transpose()?,
            ci: of_tree.then(|| number(&self.ci)).transpose()?,
            short_stack: is_trail.then(|| self.short_stack.parse()).transpose()?,
            trail_bits: is_trail.then(|| self.trail_bits.clone()),
            force: vec![Feature::Normals.name().to_owned()],
            ..FrameArgs::default()
        })
    }
}

impl Use {
    pub(super) fn of(setup: &Setup) -> anyhow::Result<Self> {
        let technique = axis(setup, "technique");
        if technique == "cpu" {
            return Ok(Self::Cpu);
        }
        let gpu = axis(setup, "gpu");
        let Some((_, figures)) = MACHINES.iter().find(|(name, _)| *name == gpu) else {
            bail!(
                "a claim names the machine '{gpu}', which is not known; expected one of: {}",
                MACHINES.map(|(name, _)| name).join(", ")
            );
        };
        Ok(Self::Replay(Box::new(MachineArgs {
            set: figures.iter().map(|&figure| figure.to_owned()).collect(),
            technique: Some(technique.to_owned()),
            layout: Some(axis(setup, "layout").to_owned()),
            ..MachineArgs::default()
        })))
    }
}
