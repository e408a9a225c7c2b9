//! `raybudget profile`: what a scene's frame costs on a GPU.

use super::{deliver, open_report_files};
use crate::Outcome;
use crate::args::ProfileArgs;
use crate::frame::{Frame, LoadedScene};
use crate::machine::Machine;
use crate::meter::Meter;
use crate::report::{self, Answer, Before};
use crate::sample::Plan;
use crate::settings::{FrameSettings, start_threads};
use crate::sustained;
use anyhow::bail;
use gpumodel::Maps;

pub(crate) fn run(args: &ProfileArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let settings = FrameSettings::new(&args.frame)?;
    let machine = Machine::new(&args.machine)?;
    let plan = Plan::new(&args.sample, &machine, meter)?;
    let load = sustained::Plan::new(&args.sustained, &machine)?;
    if plan.is_some() && load.is_some() {
        bail!(
            "--sustained: it replays the frame at each clock as a whole; leave out --sample, --within, --time-limit and --fidelity sampled"
        );
    }
    start_threads(args.run.threads)?;
    let files = open_report_files(&args.report)?;
    let maps = if files.is_some() { Maps::Kept } else { Maps::Dropped };
    let answer = match load {
        None => profile(&args.scene, &settings, (&machine, plan.as_ref()), maps, meter)?,
        Some(load) => profile_load(&args.scene, &settings, &machine, load, maps, meter)?,
    };
    deliver(&answer, files, args.report.format)?;
    Ok(Outcome::Done)
}

/// Builds, traces and replays the frame, or a sample of it.
pub(super) fn profile(
    scene: &str,
    settings: &FrameSettings,
    (machine, plan): (&Machine, Option<&Plan>),
    maps: Maps,
    meter: &Meter,
) -> anyhow::Result<Answer> {
    let scene = LoadedScene::load(scene)?;
    let frame = Frame::build(&scene, settings)?;
    let before = Before { load_s: scene.load_s, build_s: Some(frame.build_s) };
    let machines = std::slice::from_ref(machine);
    match plan {
        Some(plan) => {
            report::sampled_answer(&frame.tracer_for(machines), machine, plan, maps, &before, meter)
        }
        None => Ok(report::frame_answers(&frame, machines, maps, &before, meter)?.remove(0)),
    }
}

/// Replays the frame at each clock of a load too, all in one pass over its tiles, and follows the load.
fn profile_load(
    scene: &str,
    settings: &FrameSettings,
    machine: &Machine,
    load: sustained::Plan,
    maps: Maps,
    meter: &Meter,
) -> anyhow::Result<Answer> {
    let scene = LoadedScene::load(scene)?;
    let frame = Frame::build(&scene, settings)?;
    let before = Before { load_s: scene.load_s, build_s: Some(frame.build_s) };
    let mut machines = vec![machine.clone()];
    machines.extend(load.machines(machine));
    let mut answers = report::frame_answers(&frame, &machines, maps, &before, meter)?;
    let at_clocks = answers.split_off(1);
    let answer = answers.remove(0);
    Ok(answer.with_load(load.follow(&at_clocks)?))
}
