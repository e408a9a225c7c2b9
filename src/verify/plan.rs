//! From a claim's setup to what must be traced and replayed for it.

use super::eyes::Eyes;
use crate::args::{FrameArgs, MachineArgs};
use crate::vary::Axis;
use reports::claims::Setup;

/// What a setup asks for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    /// What is traced: setups of one frame share a trace.
    pub(super) frame: FrameArgs,
    pub(super) used: Use,
}

/// How the trace is used.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Use {
    /// Replayed through a machine.
    Replay(Box<MachineArgs>),
    /// The frames of two eyes replayed through a machine.
    Eyes(Box<MachineArgs>, Eyes),
    /// Not recorded: the time of the unobserved tracer on one thread of this machine.
    Cpu,
}

/// The value that leaves an option as it is without it.
const DEFAULT: &str = "default";

/// Axes of claim files that set an option only where the structure has it, so that one default serves all structures.
const OF_SOME_STRUCTURES: [&str; 4] = ["ct", "ci", "short_stack", "trail_bits"];

/// Figures of the default GPU that a reading changes: the name of the machine in claim files, and the figure.
const MACHINES: [(&str, &str); 4] = [
    ("ssbo-through-l1", "paths.ssbo=[\"tp_l1\", \"uche\"]"),
    ("alu-32-per-core", "shader_cores.alu_lanes=32"),
    ("alu-96-per-core", "shader_cores.alu_lanes=96"),
    ("load-store-64", "load_store.bytes_per_clock=64"),
];

impl Plan {
    /// As the command line would say it, with these features forced into every frame. All other axes and values are those of
    /// `raybudget compare --vary`; `default` sets nothing.
    ///
    /// # Errors
    /// On an axis that comparisons do not have, and on a value that it does not take.
    pub(super) fn of(setup: &Setup, [width, height]: [u32; 2], force: &[String]) -> anyhow::Result<Self> {
        let mut frame = FrameArgs { size: Some(format!("{width}x{height}")), ..FrameArgs::default() };
        let mut machine = MachineArgs::default();
        let (mut on_cpu, mut eyes) = (false, None);
        for (axis, value) in setup.axes.iter().filter(|(_, value)| *value != DEFAULT) {
            let figure = MACHINES.iter().find(|(name, _)| axis == "gpu" && name == value);
            match (axis.as_str(), value.as_str()) {
                ("technique", "cpu") => on_cpu = true,
                ("eyes", name) => eyes = Some(Eyes::named(name)?),
                ("traversal", "grid") => Axis::Traversal.apply("grid-dda", &mut frame, &mut machine)?,
                ("traversal", name) => {
                    Axis::Traversal.apply(&name.replace(' ', "-"), &mut frame, &mut machine)?;
                }
                (axis, _) if OF_SOME_STRUCTURES.contains(&axis) => {}
                (axis, value) => match figure {
                    Some((_, figure)) => machine.set.push((*figure).to_owned()),
                    None => Axis::named(axis)?.apply(value, &mut frame, &mut machine)?,
                },
            }
        }
        frame.force.extend_from_slice(force);
        set_of_structure(setup, &mut frame)?;
        let used = match eyes {
            Some(eyes) => Use::Eyes(Box::new(machine), eyes),
            None if on_cpu => Use::Cpu,
            None => Use::Replay(Box::new(machine)),
        };
        Ok(Self { frame, used })
    }

    /// Its frame in a few words.
    pub(super) fn label(&self) -> String {
        let FrameArgs { accel, traversal, ct, ci, ray_sets, shadow_query, .. } = &self.frame;
        let costs = [("Ct", ct), ("Ci", ci)].map(|(name, cost)| cost.map(|cost| format!("{name} {cost}")));
        let parts = [accel, traversal, shadow_query].map(Clone::clone).into_iter().chain(costs).flatten();
        parts.chain(ray_sets.iter().cloned()).collect::<Vec<_>>().join(" ")
    }
}

fn set_of_structure(setup: &Setup, frame: &mut FrameArgs) -> anyhow::Result<()> {
    let number = |axis: &str| setup.get(axis).map(str::parse::<f64>).transpose();
    if frame.accel.as_deref() != Some("grid") {
        (frame.ct, frame.ci) = (number("ct")?, number("ci")?);
    }
    if frame.traversal.as_deref() == Some("restart-trail") {
        frame.short_stack = setup.get("short_stack").map(str::parse).transpose()?;
        frame.trail_bits = setup.get("trail_bits").map(str::to_owned);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::settings::FrameSettings;
    use crate::two_eyes;
    use reports::claims::{EMBEDDED, Paper};

    fn setup(axes: &[(&str, &str)]) -> Setup {
        let axes = axes.iter().map(|&(axis, value)| (axis.to_owned(), value.to_owned())).collect();
        Setup { scene: "one".to_owned(), axes }
    }

    fn plan(axes: &[(&str, &str)]) -> anyhow::Result<Plan> {
        Plan::of(&setup(axes), [16, 8], &["normals".to_owned()])
    }

    #[test]
    fn every_setup_of_every_paper_can_be_planned_and_run() {
        let possible = |setup: &Setup, paper: &Paper| -> anyhow::Result<()> {
            let plan = Plan::of(setup, paper.image, &paper.force)?;
            FrameSettings::new(&plan.frame)?;
            match plan.used {
                Use::Replay(machine) => Machine::new(&machine).map(drop),
                Use::Eyes(machine, _) => two_eyes::machine(&machine).map(drop),
                Use::Cpu => Ok(()),
            }
        };
        for claims in EMBEDDED.iter().map(|embedded| embedded.parse().expect("a claim file")) {
            for setup in claims.setups() {
                possible(&setup, &claims.paper).unwrap_or_else(|error| panic!("{setup}: {error}"));
            }
        }
    }

    #[test]
    fn an_axis_sets_what_it_sets_in_a_comparison_and_a_default_sets_nothing() {
        let of = plan(&[
            ("gpu", "mali-g715"),
            ("layout", "default"),
            ("ray-sets", "mirror:hard-shadows"),
            ("shadow-query", "closest-hit"),
            ("traversal", "wide-bvh-stack"),
        ])
        .expect("known");
        let text = |text: &str| Some(text.to_owned());
        let frame = FrameArgs {
            accel: text("wide-bvh"),
            traversal: text("stack"),
            size: text("16x8"),
            force: vec!["normals".to_owned()],
            ray_sets: vec!["mirror".to_owned(), "hard-shadows".to_owned()],
            shadow_query: text("closest-hit"),
            ..FrameArgs::default()
        };
        let machine = MachineArgs { gpu: text("mali-g715"), ..MachineArgs::default() };
        assert_eq!(of, Plan { frame, used: Use::Replay(Box::new(machine)) });
    }

    #[test]
    fn options_of_some_structures_are_left_out_of_the_others() {
        let axes = |traversal| {
            let all = [("ct", "3"), ("ci", "1.5"), ("short_stack", "4"), ("trail_bits", "64")];
            plan(&[&all[..], &[("traversal", traversal)]].concat()).expect("known").frame
        };
        let trail = axes("bvh restart-trail");
        assert_eq!(
            (trail.ct, trail.short_stack, trail.trail_bits.as_deref()),
            (Some(3.0), Some(4), Some("64"))
        );
        let stack = axes("kd stack");
        assert_eq!((stack.ci, stack.short_stack, stack.trail_bits), (Some(1.5), None, None));
        let grid = axes("grid");
        assert_eq!((grid.ct, grid.ci, grid.traversal.as_deref()), (None, None, Some("dda")));
    }

    #[test]
    fn what_is_not_known_is_named() {
        for (axes, expected) in [
            (("colour", "red"), "--vary colour: no such axis"),
            (("traversal", "bvh zigzag"), "--vary traversal=bvh-zigzag: no such one"),
            (("ray-sets", "sparks"), "--vary ray-sets=sparks: expected one of"),
        ] {
            let error = plan(&[axes]).expect_err("it is wrong").to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
