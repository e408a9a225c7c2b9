//! `raybudget trace`: records what every ray of a frame visits.

use crate::Outcome;
use crate::args::TraceArgs;
use crate::console;
use crate::frame::{Frame, LoadedScene};
use crate::meter::timed;
use crate::output::{OutputFile, check_writable};
use crate::progress::Progress;
use crate::ray_sets::RayRequest;
use crate::reflections;
use crate::report::{of_first_sample, samples_per_pixel};
use crate::settings::{FrameSettings, start_threads};
use anyhow::bail;
use rayon::prelude::*;
use scenes::Feature;
use std::io::Write;
use tracer::{Choice, EncodedTile, FrameTracer, Hit, Tile, TileSource, TraceHeader, TraceWriter};

/// Tiles that are traced together, for each thread: enough to even out their cost, few enough to hold in memory.
const TILES_PER_THREAD: u32 = 16;

pub(crate) fn run(args: &TraceArgs) -> anyhow::Result<Outcome> {
    let settings = FrameSettings::new(&args.frame)?;
    if args.rays.is_some() {
        let forced = Feature::ALL
            .into_iter()
            .find(|&feature| feature.is_rays() && settings.features.choice(feature) == Some(Choice::In));
        let option = match forced {
            Some(feature) => Some(format!("--force {}", feature.name())),
            None => (settings.rays != RayRequest::default()).then(|| "--ray-sets and its options".to_owned()),
        };
        if let Some(option) = option {
            bail!(
                "{option}: the rays of --rays are traced for their closest hits alone; leave out one of them"
            );
        }
    }
    start_threads(args.run.threads)?;
    let rays = args.rays.as_deref().map(tracer::read_rays).transpose()?;
    let out = check_writable(&args.out)?;
    let mut hits = args.hits.as_deref().map(HitsFile::create).transpose()?;
    let scene = LoadedScene::load(&args.scene)?;
    let frame = Frame::build(&scene, &settings)?;
    let reflections = if rays.is_some() { None } else { reflections::record(&frame) };
    // A list of rays has no image to rasterise.
    let mut tracer = frame.tracer(rays).with_raster();
    let mut shaders = Vec::new();
    if let Some((record, of_triangles)) = reflections {
        tracer = tracer.with_reflection_record(record);
        shaders = of_triangles;
    }
    let (written, trace_s) = timed(|| record(&tracer, &shaders, &out, hits.as_mut()));
    let (bytes, steps) = written?;
    if let Some(hits) = hits {
        hits.file.finish()?;
    }
    let header = tracer.header();
    console::print(&format!(
        "{}: {} rays of {}, {} steps, {} bytes, {:.3} bytes per step\nload {:.2} s, build {:.2} s, trace and write {:.2} s\n",
        args.out.display(),
        header.frame.rays(),
        ray_sets(header),
        steps,
        bytes,
        bytes as f64 / steps.max(1) as f64,
        scene.load_s,
        frame.build_s,
        trace_s,
    ))?;
    Ok(Outcome::Done)
}

fn ray_sets(header: &TraceHeader) -> String {
    let names = of_first_sample(header).map(|set| set.kind.name()).collect::<Vec<_>>().join(" + ");
    match samples_per_pixel(header) {
        Some(samples) => format!("{names} with {samples} samples per pixel"),
        None => names,
    }
}

/// Writes the trace file of all tiles.
pub(crate) fn record_all(tracer: &FrameTracer<'_>, out: &std::path::Path) -> anyhow::Result<()> {
    record(tracer, &[], out, None).map(drop)
}

/// Traces all tiles, batch by batch, and writes them in order; `shaders` are those of the triangles where the trace keeps reflections. Returns the file's size and its number of steps.
fn record(
    tracer: &FrameTracer<'_>,
    shaders: &[u32],
    out: &std::path::Path,
    mut hits: Option<&mut HitsFile>,
) -> anyhow::Result<(u64, u64)> {
    let mut writer = TraceWriter::create_with_shaders(out, tracer.header(), tracer.topology(), shaders)?;
    let tiles = tracer.header().frame.tiles();
    let progress = Progress::tiles("tracing", u64::from(tiles));
    let batch = TILES_PER_THREAD * rayon::current_num_threads() as u32;
    let keep_hits = hits.is_some();
    for first in (0..tiles).step_by(batch as usize) {
        let range = first..first.saturating_add(batch).min(tiles);
        let traced: Vec<(EncodedTile, Vec<(u64, Hit)>)> = range
            .clone()
            .into_par_iter()
            .map_init(Tile::default, |tile, index| {
                let mut hits = Vec::new();
                tracer.trace_tile(index, tile, |number, hit| {
                    if keep_hits {
                        hits.push((number, *hit));
                    }
                })?;
                Ok((EncodedTile::new(tile, tracer.header())?, hits))
            })
            .collect::<Result<_, tracer::Error>>()?;
        for (tile, tile_hits) in &traced {
            writer.write_tile(tile)?;
            if let Some(hits) = hits.as_deref_mut() {
                hits.add(tile_hits)?;
            }
        }
        progress.set(u64::from(range.end));
    }
    let steps = writer.steps();
    if let Some(hits) = hits {
        hits.flush()?;
    }
    Ok((writer.finish(tracer.stalls())?, steps))
}

/// `HITS.csv`: one row per primary ray, in the order of the rays.
struct HitsFile {
    file: OutputFile,
    /// Number of the next ray to write.
    next: u64,
    /// Hits of the rays from `next` on, where they are known: those of one row of tiles at most.
    pending: std::collections::VecDeque<Option<Hit>>,
}

impl HitsFile {
    fn create(path: &std::path::Path) -> anyhow::Result<Self> {
        let mut file = OutputFile::create(path)?;
        let heading = file.write_all(b"ray,primitive,t,u,v\n");
        heading.map_err(|error| file.refused(&error))?;
        Ok(Self { file, next: 0, pending: std::collections::VecDeque::new() })
    }

    /// Takes the hits of a tile and writes all rays up to the first one that is still missing.
    fn add(&mut self, hits: &[(u64, Hit)]) -> anyhow::Result<()> {
        for &(number, hit) in hits {
            let place = (number - self.next) as usize;
            if place >= self.pending.len() {
                self.pending.resize(place + 1, None);
            }
            self.pending[place] = Some(hit);
        }
        while let Some(&Some(hit)) = self.pending.front() {
            let ray = self.next;
            let row = match hit.is_hit() {
                true => writeln!(self.file, "{ray},{},{},{},{}", hit.primitive, hit.t, hit.u, hit.v),
                false => writeln!(self.file, "{ray},,,,"),
            };
            row.map_err(|error| self.file.refused(&error))?;
            self.pending.pop_front();
            self.next += 1;
        }
        Ok(())
    }

    /// Writes what is buffered through to the disk, so that a full disk is known before the trace gets its name.
    fn flush(&mut self) -> anyhow::Result<()> {
        self.file.flush().map_err(|error| self.file.refused(&error))
    }
}
