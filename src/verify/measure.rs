//! Measures what claims need: every scene is loaded once, every trace made once, and all replays of a trace share it.

use super::metrics::{self, Audits};
use super::plan::{TracePlan, Use};
use crate::console;
use crate::frame::{Frame, LoadedScene};
use crate::machine::Machine;
use crate::meter::Meter;
use crate::report::{self, Answer, Before};
use crate::settings::FrameSettings;
use gpumodel::Maps;
use reports::claims::{ClaimSet, Measurements, SceneRole, Setup};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use tracer::{FrameTracer, Tile, TileSource, Topology, TraceHeader};

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
        let mut plans: BTreeMap<TracePlan, Needs> = BTreeMap::new();
        for (setup, metrics) in of_scene {
            plans.entry(TracePlan::of(&setup)).or_default().insert(setup, metrics);
        }
        let count = plans.len();
        for (number, (plan, needs)) in (1..).zip(plans) {
            console::status(&format!(
                "{} ({}), trace {number} of {count}: {} Ct {} Ci {}",
                role.title, scene.scene.name, plan.traversal, plan.ct, plan.ci
            ));
            measure_trace(&scene, &plan, &needs, conditions, meter, &mut measured)?;
        }
    }
    Ok(measured)
}

/// The first file of a role that is there.
fn find(role: &SceneRole, folder: Option<&Path>) -> Option<String> {
    let folder = folder?;
    let paths = role.files.iter().map(|file| folder.join(file));
    paths.filter(|path| path.is_file()).map(|path| path.display().to_string()).next()
}

fn measure_trace(
    scene: &LoadedScene,
    plan: &TracePlan,
    needs: &Needs,
    conditions: &Conditions<'_>,
    meter: &Meter,
    measured: &mut Measured,
) -> anyhow::Result<()> {
    let settings = FrameSettings::new(&plan.frame_args(conditions.image)?)?;
    let frame = Frame::build(scene, &settings)?;
    let costs = [settings.build.traversal_cost, settings.build.intersection_cost];
    let mut replays: Vec<(&Setup, Machine)> = Vec::new();
    for (setup, metrics) in needs {
        match Use::of(setup)? {
            Use::Cpu => {
                let rate = metrics::cpu_mrays_per_second(&frame, conditions.image);
                measured.measurements.figure(setup, "cpu_mrays_per_second", rate);
            }
            Use::Replay(machine) => {
                let replays_it = metrics.iter().any(|metric| !is_of_trace(metric));
                if replays_it {
                    replays.push((setup, Machine::new(&machine)?));
                }
            }
        }
        for metric in metrics {
            if let Some(value) = metrics::of_structure(metric, &frame, costs) {
                measured.measurements.figure(setup, metric, value);
            }
        }
    }
    let wants = |metric: &str| needs.values().any(|metrics| metrics.contains(metric));
    let audits = Audits {
        leaves_tested_twice: wants("leaves_tested_twice"),
        restarts_above_push_down: wants("restarts_above_push_down"),
    };
    if replays.is_empty() && !audits.any() {
        return Ok(());
    }
    measured.traces += 1;
    // The judge of push-down is the same tree under a full stack.
    let stack_plan = TracePlan { traversal: "kd stack".to_owned(), ..plan.clone() };
    let stack_settings = FrameSettings::new(&stack_plan.frame_args(conditions.image)?)?;
    let stack = audits.restarts_above_push_down.then(|| Frame::build(scene, &stack_settings)).transpose()?;
    let stack = stack.as_ref().map(|stack| stack.tracer(None));
    let machines: Vec<Machine> = replays.iter().map(|(_, machine)| machine.clone()).collect();
    let source = Audited {
        tracer: frame.tracer_for(&machines),
        stack,
        audits,
        found: [AtomicU64::new(0), AtomicU64::new(0)],
    };

    if replays.is_empty() {
        let mut tile = Tile::default();
        for index in 0..source.header().frame.tiles() {
            source.tile(index, &mut tile)?;
        }
    } else {
        let maps = if needs.keys().any(conditions.maps) { Maps::Kept } else { Maps::Dropped };
        let before = Before { load_s: scene.load_s, build_s: Some(frame.build_s) };
        let answers = report::answers(&source, &machines, maps, &before, meter)?;
        for ((setup, machine), mut answer) in replays.into_iter().zip(answers) {
            record(setup, &needs[setup], &answer, &machine, &mut measured.measurements);
            if !(conditions.maps)(setup) {
                answer.replayed.maps = None;
            }
            measured.answers.insert(setup.clone(), answer);
        }
    }
    let [twice, above] = source.found.map(AtomicU64::into_inner);
    for (setup, metrics) in needs {
        for (metric, found) in [("leaves_tested_twice", twice), ("restarts_above_push_down", above)] {
            if metrics.contains(metric) {
                measured.measurements.figure(setup, metric, found as f64);
            }
        }
    }
    Ok(())
}

/// Metrics that need no replay.
fn is_of_trace(metric: &str) -> bool {
    matches!(metric, "leaves_tested_twice" | "restarts_above_push_down" | "cpu_mrays_per_second")
}

fn record(
    setup: &Setup,
    metrics: &BTreeSet<String>,
    answer: &Answer,
    machine: &Machine,
    measurements: &mut Measurements,
) {
    for metric in metrics {
        if let Some(value) = metrics::of_replay(metric, answer, &machine.config.gpu) {
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

/// Tiles of a tracer, audited as they pass.
struct Audited<'a> {
    tracer: FrameTracer<'a>,
    stack: Option<FrameTracer<'a>>,
    audits: Audits,
    found: [AtomicU64; 2],
}

impl TileSource for Audited<'_> {
    fn header(&self) -> &TraceHeader {
        self.tracer.header()
    }

    fn topology(&self) -> &Topology {
        self.tracer.topology()
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), tracer::Error> {
        self.tracer.tile(index, tile)?;
        if !self.audits.any() {
            return Ok(());
        }
        let mut judge = Tile::default();
        if let Some(stack) = &self.stack {
            stack.tile(index, &mut judge)?;
        }
        for (place, set) in tile.ray_sets.iter().enumerate() {
            let found = metrics::audit(self.audits, self.topology(), set, judge.ray_sets.get(place));
            for (sum, found) in self.found.iter().zip(found) {
                sum.fetch_add(found, Ordering::Relaxed);
            }
        }
        Ok(())
    }

    fn stalls(&self) -> u64 {
        self.tracer.stalls()
    }
}
