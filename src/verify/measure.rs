//! Measures what claims need: every scene is loaded once, every trace made once, and all replays of a trace share it.

use super::audits::{Audit, Audited};
use super::eyes::{Eyes, Pair};
use super::plan::{Plan, Use};
use super::{formulas, metrics};
use crate::args::MachineArgs;
use crate::console;
use crate::frame::{Frame, LoadedScene};
use crate::machine::Machine;
use crate::meter::Meter;
use crate::reflections;
use crate::report::{self, Answer, Before};
use crate::settings::FrameSettings;
use crate::two_eyes::{self, TwoEyes};
use gpumodel::Maps;
use reports::claims::{ClaimSet, Measurements, SceneRole, Setup};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tracer::Traversal;

/// Where the scenes of a paper are, and how large its image is.
pub(crate) struct Conditions<'a> {
    /// Folder of scene files; without one, built-in scenes stand in.
    pub(crate) scenes: Option<&'a Path>,
    pub(crate) image: [u32; 2],
    /// Setups whose heat maps are wanted.
    pub(crate) maps: &'a dyn Fn(&Setup) -> bool,
}

/// What was measured, and the reports that it came from.
pub(crate) struct Measured {
    pub(crate) measurements: Measurements,
    pub(crate) answers: BTreeMap<Setup, Answer>,
    /// What each role was traced on.
    pub(crate) scenes: BTreeMap<String, String>,
    /// Traces made.
    pub(crate) traces: usize,
    /// Replays of them.
    pub(crate) replays: usize,
}

/// Setups with the metrics that are needed of each.
type Needs = BTreeMap<Setup, BTreeSet<String>>;

/// Measures everything that the claims need.
pub(crate) fn all(claims: &ClaimSet, conditions: &Conditions<'_>, meter: &Meter) -> anyhow::Result<Measured> {
    let mut measured = Measured {
        measurements: Measurements::new(),
        answers: BTreeMap::new(),
        scenes: BTreeMap::new(),
        traces: 0,
        replays: 0,
    };
    let needs = claims.needs();
    for role in &claims.scenes {
        let of_scene: Needs = needs
            .iter()
            .filter(|(setup, _)| setup.scene == role.name)
            .map(|(s, m)| (s.clone(), m.clone()))
            .collect();
        if of_scene.is_empty() {
            continue;
        }
        let found = find(role, conditions.scenes);
        if found.is_none() {
            measured.measurements.stand_in(&role.name, &role.stand_in);
        }
        let spec = found.unwrap_or_else(|| role.stand_in.clone());
        let scene = LoadedScene::load(&spec)?;
        measured.scenes.insert(role.name.clone(), scene.scene.name.clone());
        let plans = by_frame(of_scene, claims, conditions.image, &mut measured.measurements);
        let count = plans.len();
        for (number, of_frame) in (1..).zip(plans) {
            let label = of_frame.setups[0].plan.label();
            console::status(&format!(
                "{} ({}), trace {number} of {count}: {label}",
                role.title, scene.scene.name
            ));
            measure_frame(&scene, &of_frame, conditions, meter, &mut measured)?;
        }
    }
    Ok(measured)
}

/// A setup of a frame.
struct Planned {
    setup: Setup,
    plan: Plan,
    metrics: BTreeSet<String>,
}

/// Setups that share a trace, at least one.
struct OfFrame {
    settings: FrameSettings,
    setups: Vec<Planned>,
}

/// What must be traced. Metrics of formulas are measured at once; setups that are not possible have failed.
fn by_frame(
    needs: Needs,
    claims: &ClaimSet,
    image: [u32; 2],
    measurements: &mut Measurements,
) -> Vec<OfFrame> {
    let mut frames: Vec<OfFrame> = Vec::new();
    for (setup, mut metrics) in needs {
        metrics.retain(|metric| match formulas::of_formula(metric) {
            Some(value) => {
                measurements.figure(&setup, metric, value);
                false
            }
            None => true,
        });
        if metrics.is_empty() {
            continue;
        }
        let planned = Plan::of(&setup, image, &claims.paper.force)
            .and_then(|plan| Ok((FrameSettings::new(&plan.frame)?, plan)));
        match planned {
            Err(error) => measurements.failed(&setup, &format!("{error:#}")),
            Ok((settings, plan)) => {
                let known = frames.iter_mut().find(|other| other.setups[0].plan.frame == plan.frame);
                let planned = Planned { setup, plan, metrics };
                match known {
                    Some(frame) => frame.setups.push(planned),
                    None => frames.push(OfFrame { settings, setups: vec![planned] }),
                }
            }
        }
    }
    frames
}

/// The first file of a role that is there.
fn find(role: &SceneRole, folder: Option<&Path>) -> Option<String> {
    let folder = folder?;
    let paths = role.files.iter().map(|file| folder.join(file));
    paths.filter(|path| path.is_file()).map(|path| path.display().to_string()).next()
}

fn measure_frame(
    scene: &LoadedScene,
    OfFrame { settings, setups }: &OfFrame,
    conditions: &Conditions<'_>,
    meter: &Meter,
    measured: &mut Measured,
) -> anyhow::Result<()> {
    let frame = Frame::build(scene, settings)?;
    let costs = [settings.build.traversal_cost, settings.build.intersection_cost];
    let mut replays: Vec<(&Planned, Machine)> = Vec::new();
    for planned @ Planned { setup, plan, metrics } in setups {
        match &plan.used {
            Use::Cpu => {
                let rate = metrics::cpu_mrays_per_second(&frame, conditions.image);
                measured.measurements.figure(setup, "cpu_mrays_per_second", rate);
            }
            // Below, all of a frame together.
            Use::Eyes(..) => {}
            Use::Replay(machine) => match Machine::new(machine) {
                Ok(machine) if metrics.iter().any(|metric| Audit::named(metric).is_none()) => {
                    replays.push((planned, machine));
                }
                Ok(_) => {}
                Err(error) => measured.measurements.failed(setup, &format!("{error:#}")),
            },
        }
        for metric in metrics {
            if let Some(value) = metrics::of_structure(metric, &frame, costs) {
                measured.measurements.figure(setup, metric, value);
            }
        }
    }
    measure_eyes(&frame, setups, (scene.load_s, meter), measured)?;
    let wants = |audit: &Audit| setups.iter().any(|planned| planned.metrics.contains(audit.name()));
    let audits: Vec<Audit> = Audit::ALL.into_iter().filter(wants).collect();
    if replays.is_empty() && audits.is_empty() {
        return Ok(());
    }
    measured.traces += 1;
    let stack = audits
        .contains(&Audit::RestartsAbovePushDown)
        .then(|| Frame::build(scene, &under_full_stack(settings)))
        .transpose()?;
    let stack = stack.as_ref().map(|stack| stack.tracer(None));
    let (of_lists, of_tiles): (Vec<_>, Vec<_>) =
        replays.into_iter().partition(|(_, machine)| machine.config.technique.reflections.is_some());
    let machines: Vec<Machine> = of_tiles.iter().map(|(_, machine)| machine.clone()).collect();
    let source = Audited::new(frame.tracer_for(&machines), stack, &audits);
    let before = Before { load_s: scene.load_s, build_s: Some(frame.build_s) };
    let mut answers = Vec::new();
    if !machines.is_empty() {
        let wants_maps = setups.iter().any(|planned| (conditions.maps)(&planned.setup));
        let maps = if wants_maps { Maps::Kept } else { Maps::Dropped };
        answers = report::answers(&source, &machines, maps, &before, meter)?;
    } else if !audits.is_empty() {
        source.drain()?;
    }
    if !of_lists.is_empty() {
        let machines: Vec<&Machine> = of_lists.iter().map(|(_, machine)| machine).collect();
        answers.extend(reflections::answers(&frame, &machines, Maps::Dropped, &before, meter)?);
    }
    for ((planned, machine), mut answer) in of_tiles.into_iter().chain(of_lists).zip(answers) {
        let Planned { setup, metrics, .. } = planned;
        measured.replays += 1;
        record(setup, metrics, &answer, &machine, &mut measured.measurements);
        if !(conditions.maps)(setup) {
            answer.replayed.maps = None;
        }
        measured.answers.insert(setup.clone(), answer);
    }
    for (audit, found) in source.found() {
        for Planned { setup, .. } in setups.iter().filter(|planned| planned.metrics.contains(audit.name())) {
            measured.measurements.figure(setup, audit.name(), found as f64);
        }
    }
    Ok(())
}

/// The frames of two eyes, each machine's once.
fn measure_eyes(
    frame: &Frame<'_>,
    setups: &[Planned],
    (load_s, meter): (f64, &Meter),
    measured: &mut Measured,
) -> anyhow::Result<()> {
    let mut of_machines: Vec<(&MachineArgs, Vec<(&Planned, Eyes)>)> = Vec::new();
    for planned in setups {
        let Use::Eyes(machine, eyes) = &planned.plan.used else { continue };
        match of_machines.iter_mut().find(|(other, _)| *other == &**machine) {
            Some((_, of_machine)) => of_machine.push((planned, *eyes)),
            None => of_machines.push((machine, vec![(planned, *eyes)])),
        }
    }
    if of_machines.is_empty() {
        return Ok(());
    }
    let pair = Pair::new(frame)?;
    let before = Before { load_s, build_s: Some(frame.build_s) };
    for (machine, planned) in of_machines {
        measured.traces += 1;
        measured.replays += TwoEyes::REPLAYS;
        let figures = two_eyes::machine(machine).and_then(|machine| pair.on(&machine, &before, meter));
        for (Planned { setup, metrics, .. }, eyes) in planned {
            match &figures {
                Err(error) => measured.measurements.failed(setup, &format!("{error:#}")),
                Ok([traced, reusing]) => {
                    let figures = if eyes == Eyes::Traced { traced } else { reusing };
                    for (metric, figure) in figures.iter().filter(|(metric, _)| metrics.contains(metric)) {
                        match figure {
                            Ok(figure) => measured.measurements.figure(setup, metric, *figure),
                            Err(reason) => measured.measurements.absent(setup, metric, reason),
                        }
                    }
                }
            }
        }
    }
    Ok(())
}

/// The judge of push-down: the same tree under a full stack.
fn under_full_stack(settings: &FrameSettings) -> FrameSettings {
    FrameSettings { traversal: Traversal::KdStack, ..*settings }
}

fn record(
    setup: &Setup,
    metrics: &BTreeSet<String>,
    answer: &Answer,
    machine: &Machine,
    measurements: &mut Measurements,
) {
    for metric in metrics {
        if let Some(value) = metrics::of_replay(metric, answer, &machine.config) {
            match value {
                Ok(value) => measurements.figure(setup, metric, value),
                Err(reason) => measurements.absent(setup, metric, &reason),
            }
        } else if let Some(counter) = answer.report.counters.get(metric) {
            match &counter.value {
                reports::Value::Absent { reason } => measurements.absent(setup, metric, reason),
                value => measurements.figure(setup, metric, value.as_f64().unwrap_or(f64::NAN)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reports::claims::{Outcome, Verdict};

    const HEAD: &str = r#"
[paper]
letter = "Z"
citation = "Anon. 2000"
image = [16, 16]
[[scene]]
name = "box"
title = "Box"
files = []
stand_in = "cornell"
why = "alike"
[axes]
traversal = ["wide-bvh-stack"]
gpu = ["mali-g715", "mali-g1-ultra"]
ray-sets = ["mirror", "hard-shadows"]
force = ["default", "mirror"]
shadow-query = ["default", "closest-hit"]
technique = ["hybrid", "reflections-hybrid", "reflections-visibility-buffer", "reflections-by-magic"]
[defaults]
traversal = "wide-bvh-stack"
gpu = "mali-g715"
ray-sets = "mirror"
force = "mirror"
shadow-query = "default"
technique = "hybrid"
[variants]
plain = { gpu = "mali-g715" }
shadows = { ray-sets = "hard-shadows", force = "default" }
closest = { ray-sets = "hard-shadows", force = "default", shadow-query = "closest-hit" }
listed = { technique = "reflections-hybrid" }
sorted = { technique = "reflections-visibility-buffer" }
magic = { technique = "reflections-by-magic" }
[metrics]
reflection_hits = { unit = "rays", definition = "hits" }
"rays:reflection shadow rays" = { unit = "rays", definition = "rays" }
"pass_ms:bucket count+bucket copy" = { unit = "ms", definition = "time" }
"pass_ms:bucket count" = { unit = "ms", definition = "time" }
"node_fetches:shadow rays" = { unit = "fetches", definition = "fetches" }
secondary_ms = { unit = "ms", definition = "time" }
buckets_per_warp = { unit = "buckets", definition = "mean" }
"#;

    fn verdict(keys: &str) -> Verdict {
        let head = "[[claim]]\nid = \"Z1\"\nstatement = \"It works\"\nwhere = \"1\"\nkind = \"order\"\n[[claim.test]]\n";
        let claims = ClaimSet::parse(&format!("{HEAD}\n{head}{keys}\n"), "z.toml").expect("a claim file");
        let conditions = Conditions { scenes: None, image: claims.paper.image, maps: &|_| false };
        let measured = all(&claims, &conditions, &Meter::start()).expect("a built-in scene");
        claims.evaluate(&measured.measurements).remove(0)
    }

    #[test]
    fn counters_of_passes_and_audits_of_traces_are_of_the_same_frame() {
        for keys in [
            "rule = \"property\"\nmetric = \"rays:reflection shadow rays / reflection_hits\"\nof = \"plain\"\nequals = 1",
            "rule = \"order\"\nmetric = \"node_fetches:shadow rays\"\nascending = [\"shadows\", \"closest\"]\neffect = 0",
            "rule = \"property\"\nmetric = \"buckets_per_warp\"\nof = \"sorted\"\nat_least = 1",
            "rule = \"property\"\nmetric = \"pass_ms:bucket count / pass_ms:bucket count+bucket copy\"\nof = \"sorted\"\nat_most = 0.99",
        ] {
            let found = verdict(keys);
            assert_eq!(found.outcome, Outcome::Reproduced, "{}", found.why);
        }
    }

    #[test]
    fn what_a_frame_does_not_have_is_named_and_so_is_a_technique_that_there_is_not() {
        for (keys, expected) in [
            (
                "rule = \"property\"\nmetric = \"pass_ms:bucket count\"\nof = \"listed\"\nat_least = 0",
                "the frame has no such pass",
            ),
            (
                "rule = \"property\"\nmetric = \"secondary_ms\"\nof = \"magic\"\nat_least = 0",
                "--technique reflections-by-magic",
            ),
        ] {
            let found = verdict(keys);
            assert_ne!(found.outcome, Outcome::Reproduced, "{}", found.why);
            assert!(found.why.contains(expected), "{}", found.why);
        }
    }
}
