//! Measures frames on two rungs of fidelity.
//!
//! Every frame is traced once, into a temporary file, and that is replayed on each GPU and rung. GPUs are replayed side by side, each
//! replay on one thread alone, so that run times can be compared.

use crate::args::{FrameArgs, MachineArgs};
use crate::commands::trace::record_all;
use crate::console;
use crate::frame::{Frame, LoadedScene};
use crate::machine::Machine;
use crate::meter::timed_on_thread;
use crate::settings::FrameSettings;
use crate::vary::traversal_name;
use anyhow::{anyhow, bail};
use gpumodel::{Estimate, Fidelity, Maps, Value};
use reports::accuracy::{Figures, Point};
use scenes::Feature;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use tracer::{AlphaMode, TileSource, TraceFile, Traversal};

/// The rung under test.
pub(crate) const OURS: Fidelity = Fidelity::Replay;
/// The rung that it is held against.
pub(crate) const REFERENCE: Fidelity = Fidelity::Timed;

/// How rays walk which structure, and the size of the image.
pub(crate) struct Walk {
    name: String,
    settings: FrameSettings,
}

impl Walk {
    /// Of a traversal by its name, such as kd-push-down.
    pub(crate) fn named(name: &str, size: &str) -> anyhow::Result<Self> {
        let Some(traversal) = Traversal::ALL.into_iter().find(|&known| traversal_name(known) == name) else {
            bail!(
                "--traversal {name}: no such one; use one of: {}",
                Traversal::ALL.map(traversal_name).join(", ")
            );
        };
        let settings = FrameSettings::new(&FrameArgs {
            accel: Some(traversal.accel().name().to_owned()),
            traversal: Some(traversal.name().to_owned()),
            size: Some(size.to_owned()),
            // Records as published; without normals all layouts would be alike.
            force: vec![Feature::Normals.name().to_owned()],
            alpha: Some(AlphaMode::Opaque.name().to_owned()),
            ..FrameArgs::default()
        })?;
        Ok(Self { name: name.to_owned(), settings })
    }
}

/// A GPU on both rungs.
pub(crate) struct Rungs {
    ours: Machine,
    reference: Machine,
}

impl Rungs {
    /// Of a GPU by its name or file.
    pub(crate) fn of(gpu: &str) -> anyhow::Result<Self> {
        let on = |fidelity: Fidelity| {
            Machine::new(&MachineArgs {
                gpu: Some(gpu.to_owned()),
                fidelity: Some(fidelity.name().to_owned()),
                ..MachineArgs::default()
            })
        };
        Ok(Self { ours: on(OURS)?, reference: on(REFERENCE)? })
    }
}

/// Measures every scene with every walk on every GPU, in this order.
pub(crate) fn all(scenes: &[String], walks: &[Walk], gpus: &[Rungs]) -> anyhow::Result<Vec<Point>> {
    let mut points = Vec::new();
    for_each_trace(scenes, walks, |trace, traversal| {
        points.extend(side_by_side(gpus, |gpu| point(trace, traversal, gpu))?);
        Ok(())
    })?;
    Ok(points)
}

/// Traces every scene with every walk into a temporary file, one after the other; `work` is given the trace and the walk's name.
pub(crate) fn for_each_trace(
    scenes: &[String],
    walks: &[Walk],
    mut work: impl FnMut(&TraceFile, &str) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let folder = tempfile::tempdir().map_err(|error| {
        anyhow!("cannot make a folder for traces: {error}; let TMPDIR name one that you may write to")
    })?;
    let file = folder.path().join("frame.rbt");
    for name in scenes {
        let scene = LoadedScene::load(name)?;
        for Walk { name: traversal, settings } in walks {
            console::status(&format!("{name}: {traversal}"));
            record_all(&Frame::build(&scene, settings)?.tracer(None), &file)?;
            work(&TraceFile::open(&file)?, traversal)?;
        }
    }
    Ok(())
}

fn point(trace: &TraceFile, traversal: &str, gpu: &Rungs) -> anyhow::Result<Point> {
    let (ours, deciding_bound) = replayed(trace, &gpu.ours)?;
    let (reference, _) = replayed(trace, &gpu.reference)?;
    Ok(Point {
        scene: trace.header().scene.clone(),
        traversal: traversal.to_owned(),
        gpu: gpu.ours.gpu_name.clone(),
        ours,
        reference,
        deciding_bound: deciding_bound.to_owned(),
    })
}

/// What a machine's rung says of the trace, and the resource that decides its time.
fn replayed(trace: &TraceFile, machine: &Machine) -> anyhow::Result<(Figures, &'static str)> {
    let config = &machine.config;
    let (replayed, run_s) = timed_on_thread(|| gpumodel::replay(trace, config, Maps::Dropped, &|_, _| {}));
    let estimate = gpumodel::estimate(&replayed?, trace.header(), trace.topology(), config)?;
    let figures = Figures {
        frame_time_ms: number(&estimate, "frame_time_ms")?,
        dram_read_bytes: number(&estimate, "dram_read_bytes")?,
        dram_write_bytes: number(&estimate, "dram_write_bytes")?,
        run_s,
    };
    Ok((figures, estimate.deciding_bound))
}

fn number(estimate: &Estimate, id: &str) -> anyhow::Result<f64> {
    let value = estimate.frame.get(id).and_then(Value::number);
    value.ok_or_else(|| anyhow!("the frame has no figure {id}; leave out this scene or GPU"))
}

/// Does `work` for each item on as many threads as there are; parallel work within it has that thread alone. Results are in the order
/// of the items.
pub(crate) fn side_by_side<T: Sync, R: Send>(
    items: &[T],
    work: impl Fn(&T) -> anyhow::Result<R> + Sync,
) -> anyhow::Result<Vec<R>> {
    let next = AtomicUsize::new(0);
    let found: Mutex<Vec<(usize, anyhow::Result<R>)>> = Mutex::new(Vec::new());
    let worker = |alone: &rayon::ThreadPool| {
        loop {
            let place = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(place) else { return };
            let result = alone.install(|| work(item));
            found.lock().expect("nothing panics under this lock").push((place, result));
        }
    };
    let threads = rayon::current_num_threads().min(items.len());
    let pool = |_| rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pools = (0..threads).map(pool).collect::<Result<Vec<_>, _>>()?;
    std::thread::scope(|scope| {
        for alone in &pools {
            scope.spawn(|| worker(alone));
        }
    });
    let mut found = found.into_inner().expect("nothing panics under this lock");
    found.sort_by_key(|&(place, _)| place);
    found.into_iter().map(|(_, result)| result).collect()
}
