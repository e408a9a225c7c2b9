//! From a source of tiles to a report, and the files that a report is written into.

use crate::console;
use crate::machine::{Machine, TECHNIQUE};
use crate::meter::{self, Meter, timed};
use crate::output::{OutputFile, OutputFolder};
use crate::progress::Progress;
use gpumodel::HeatMap;
use reports::{Fidelity, Hashes, Inputs, LeftOut, Report, Run, SceneFacts, csv_table, heat_map, json, text};
use std::path::Path;
use tracer::{Frame, Omission, SceneRemarks, TileSource, TraceHeader};

/// Pixels above this percentile share the heat map's last colour.
const HEAT_MAP_PERCENTILE: f64 = 99.5;

/// A report with its picture.
pub(crate) struct Answer {
    pub(crate) report: Report,
    node_fetches: HeatMap,
}

/// What was measured before the replay.
pub(crate) struct Before {
    pub(crate) load_s: f64,
    pub(crate) build_s: Option<f64>,
}

/// Replays all tiles and reports what they cost.
pub(crate) fn answer<S: TileSource>(
    source: &S,
    machine: &Machine,
    before: &Before,
    meter: &Meter,
) -> anyhow::Result<Answer> {
    let header = source.header();
    let progress = Progress::tiles("tracing and replaying", u64::from(header.frame.tiles()));
    let (replayed, replay_s) =
        timed(|| gpumodel::replay(source, &machine.config, &|done, _| progress.set(done)));
    drop(progress);
    let replayed = replayed?;
    let estimate = gpumodel::estimate(&replayed, header, source.topology(), &machine.config);
    let mut scene = facts(header);
    let stalls = replayed.counters.stalls;
    if stalls > 0 {
        scene
            .notes
            .push(format!("{stalls} traversals were ended by their loop bound: their hits may be wrong."));
    }
    let run = Run {
        wall_s: meter.wall_s(),
        peak_rss_bytes: meter::peak_rss_bytes(),
        fidelity: Fidelity::Replay,
        sampled_fraction: 1.0,
        threads: rayon::current_num_threads() as u32,
        load_s: before.load_s,
        build_s: before.build_s,
        replay_s,
    };
    let tool = concat!("raybudget ", env!("CARGO_PKG_VERSION"));
    let report = Report::new(tool, inputs(header, machine), scene, &estimate, run);
    Ok(Answer { report, node_fetches: replayed.node_fetches })
}

/// What the trace says of its scene.
fn facts(header: &TraceHeader) -> SceneFacts {
    let SceneRemarks { left_out, notes } = header.remarks.clone();
    let left_out = left_out.into_iter().map(|Omission { what, why }| LeftOut { what, why });
    SceneFacts { left_out: left_out.collect(), notes }
}

fn inputs(header: &TraceHeader, machine: &Machine) -> Inputs {
    let (width, height) = match header.frame {
        Frame::Image { width, height } => (Some(width), Some(height)),
        Frame::List { .. } => (None, None),
    };
    Inputs {
        scene: header.scene.clone(),
        gpu: machine.config.gpu.name().to_owned(),
        accel: header.accel.name().to_owned(),
        traversal: header.traversal.clone(),
        layout: machine.config.primitive_layout.name().to_owned(),
        technique: TECHNIQUE[0].to_owned(),
        width,
        height,
        seed: None,
        hashes: Hashes {
            scene: header.scene_hash.clone(),
            gpu: machine.gpu_hash.clone(),
            costs: machine.costs_hash.clone(),
        },
        triangles: header.triangles,
        ray_sets: header.ray_sets.iter().map(|kind| kind.name().to_owned()).collect(),
        sah_costs: header.sah_costs,
        short_stack: header.short_stack,
        trail_bits: header.trail_bits,
    }
}

/// The files of a report, opened.
pub(crate) struct ReportFiles {
    // Fields drop in order: the unfinished files go before the folder that was made for them.
    text: OutputFile,
    json: OutputFile,
    csv: OutputFile,
    heat_map: OutputFile,
    folder: OutputFolder,
}

impl ReportFiles {
    pub(crate) fn create(folder: &Path) -> anyhow::Result<Self> {
        let folder = OutputFolder::create(folder)?;
        Ok(Self {
            text: folder.file("report.txt")?,
            json: folder.file("report.json")?,
            csv: folder.file("counters.csv")?,
            heat_map: folder.file("node-fetches.png")?,
            folder,
        })
    }

    /// Writes all files. A list of rays has no pixels and so no heat map.
    pub(crate) fn write(self, answer: &Answer) -> anyhow::Result<()> {
        // Bindings drop from the last to the first.
        let Self { folder, text, json, csv, heat_map } = self;
        let Answer { report, .. } = answer;
        let picture = picture(answer)?;
        let mut ready = vec![
            text.written(text::write(report, text::Style::Plain).as_bytes())?,
            json.written(json::write(report).as_bytes())?,
            csv.written(csv_table::write(report).as_bytes())?,
        ];
        match picture {
            Some(picture) => ready.push(heat_map.written(&picture)?),
            None => console::warn("a list of rays has no pixels: no heat map is written"),
        }
        OutputFile::finish_all(ready)?;
        folder.keep();
        Ok(())
    }
}

fn picture(Answer { report, node_fetches }: &Answer) -> anyhow::Result<Option<Vec<u8>>> {
    let Inputs { scene, accel, traversal, width: Some(width), height: Some(height), ray_sets, .. } =
        &report.inputs
    else {
        return Ok(None);
    };
    let map = heat_map::HeatMap {
        title: "Node fetches per pixel".to_owned(),
        subtitle: format!("{scene}, {width}x{height}, {} rays, {accel} {traversal}", ray_sets.join(" + ")),
        unit: "fetches".to_owned(),
        width: *width,
        values: &node_fetches.values,
        clamp_percentile: HEAT_MAP_PERCENTILE,
    };
    Ok(Some(heat_map::write_png(&map)?))
}
