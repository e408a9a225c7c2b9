//! The reflection rays of a trace, as a source of tiles in any order.

use super::frame::{Outcome, ReflectionRay, Reflections};
use super::ray_tracer::{NO_RAY, ReflectionList, check_order};
use crate::error::Error;
use crate::ray::{NOT_CAST, Ray};
use crate::ray_set::{RayKind, RaySetId};
use crate::topology::Topology;
use crate::trace::{Frame, RayLine, RaySet, TILE_EDGE, Tile, TileSource, TraceHeader};
use crate::trace_file::reflection_lines::cast;
use glam::Vec3;
use rayon::prelude::*;

/// Most steps of reflection rays that are held at once: 4 GiB.
const MOST_STEPS: usize = 1 << 30;
/// Tiles that are read together, for each thread.
const TILES_PER_THREAD: u32 = 16;

/// The reflection rays of a trace with [`TraceHeader::reflections`], and the shadow rays from what they hit: those of the first sample.
///
/// Memory: 4 bytes per step, 16 per pixel, 36 per reflection ray, and 8 per pixel and set of shadow rays.
pub struct RecordedReflections<'a> {
    /// Of lists of its rays, but for their length.
    header: TraceHeader,
    topology: &'a Topology,
    /// By tile of the image, its reflection rays and shadow rays.
    tiles: Vec<Vec<RaySet>>,
    reflections: Reflections<'static>,
    stalls: u64,
}

/// One tile of the image.
struct Recorded {
    sets: Vec<RaySet>,
    /// By pixel.
    outcomes: Vec<Outcome>,
    lines: Vec<RayLine>,
}

impl<'a> RecordedReflections<'a> {
    /// Reads the tiles of a trace, in parallel.
    ///
    /// # Errors
    /// When the trace has no lines of reflection rays, a tile cannot be read, or the rays take too many steps.
    pub fn read<S: TileSource>(source: &'a S) -> Result<Self, Error> {
        let header = source.header();
        let (Some(_), Frame::Image { width, height }) = (&header.reflections, header.frame) else {
            return Err(Error::Options(
                "the trace keeps no reflection rays; record it again with --force mirror or --force glossy, or of a scene with such surfaces"
                    .to_owned(),
            ));
        };
        let is_of = |set: &RaySetId, kind: RayKind| set.sample == 0 && set.kind == kind;
        let of_kind =
            |kind: RayKind| (0..header.ray_sets.len()).filter(move |&set| is_of(&header.ray_sets[set], kind));
        let kept: Vec<usize> =
            of_kind(RayKind::Reflection).take(1).chain(of_kind(RayKind::ReflectionShadow)).collect();
        let tiles = header.frame.tiles();
        let batch = TILES_PER_THREAD * rayon::current_num_threads() as u32;
        let mut all: Vec<Recorded> = Vec::new();
        let mut steps = 0;
        for first in (0..tiles).step_by(batch as usize) {
            let read: Vec<Recorded> = (first..tiles.min(first + batch))
                .into_par_iter()
                .map_init(Tile::default, |tile, index| {
                    source.tile(index, tile)?;
                    Ok(recorded(tile, &kept))
                })
                .collect::<Result<_, Error>>()?;
            steps += read.iter().flat_map(|tile| &tile.sets).map(|set| set.steps.len()).sum::<usize>();
            if steps > MOST_STEPS {
                return Err(Error::Options(format!(
                    "the reflection rays of the trace take more than {MOST_STEPS} steps; record it with a smaller --size"
                )));
            }
            all.extend(read);
        }
        let header = TraceHeader {
            ray_sets: kept.iter().map(|&set| header.ray_sets[set]).collect(),
            raster: false,
            reflections: None,
            ..header.clone()
        };
        let reflections = reflections([width, height], header.frame, &all);
        let tiles = all.into_iter().map(|tile| tile.sets).collect();
        Ok(Self { header, topology: source.topology(), tiles, reflections, stalls: source.stalls() })
    }

    /// Its rays, and what becomes of each pixel's: nothing was looked up on the screen.
    pub fn reflections(&self) -> &Reflections<'static> {
        &self.reflections
    }

    /// Its rays in an order, at each place the one that `order` has there, or none at [`NO_RAY`]; with the shadow rays from what they hit, or without.
    ///
    /// # Errors
    /// When `order` does not have each ray once.
    pub fn list(&self, order: Vec<u32>, with_shadows: bool) -> Result<RecordedList<'_>, Error> {
        check_order(&order, self.reflections.rays().len())?;
        let mut header = self.header.clone();
        header.frame = Frame::List { rays: order.len() as u32 };
        if !with_shadows {
            header.ray_sets.truncate(1);
        }
        Ok(RecordedList { recorded: self, order, header })
    }
}

fn recorded(tile: &mut Tile, kept: &[usize]) -> Recorded {
    let is_cast: Vec<usize> = cast(&tile.ray_sets, kept[0]).collect();
    let mut outcomes: Vec<Outcome> = tile.ray_sets[0]
        .hits
        .iter()
        .map(|&hit| if hit < NOT_CAST { Outcome::Fallback } else { Outcome::Sky })
        .collect();
    is_cast.into_iter().for_each(|ray| outcomes[ray] = Outcome::Query);
    let sets = kept.iter().map(|&set| {
        let mut set = std::mem::take(&mut tile.ray_sets[set]);
        set.steps.shrink_to_fit();
        set
    });
    Recorded { sets: sets.collect(), outcomes, lines: std::mem::take(&mut tile.reflections) }
}

fn reflections(size: [u32; 2], frame: Frame, tiles: &[Recorded]) -> Reflections<'static> {
    let [width, height] = size;
    let mut outcomes = vec![Outcome::Sky; width as usize * height as usize];
    let mut rays = Vec::new();
    for (index, tile) in (0..).zip(tiles) {
        let rect = frame.tile(index);
        let mut lines = tile.lines.iter();
        for (local, &outcome) in (0..).zip(&tile.outcomes) {
            let pixel = (rect.y + local / rect.width) * width + rect.x + local % rect.width;
            outcomes[pixel as usize] = outcome;
            let line = if outcome == Outcome::Query { lines.next() } else { None };
            if let Some(line) = line {
                let [origin, direction] = [line.origin, line.direction].map(Vec3::from_array);
                let ray = Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY };
                rays.push(ReflectionRay { pixel, ray });
            }
        }
    }
    rays.sort_unstable_by_key(|ray| ray.pixel);
    Reflections::recorded(size, outcomes, rays)
}

/// Reflection rays of a trace in an order.
pub struct RecordedList<'a> {
    recorded: &'a RecordedReflections<'a>,
    /// From a place in the frame to the ray there, or to [`NO_RAY`].
    order: Vec<u32>,
    header: TraceHeader,
}

impl TileSource for RecordedList<'_> {
    fn header(&self) -> &TraceHeader {
        &self.header
    }

    fn topology(&self) -> &Topology {
        self.recorded.topology
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), Error> {
        tile.draws.clear();
        tile.reflections.clear();
        tile.ray_sets.resize_with(self.header.ray_sets.len(), Default::default);
        tile.ray_sets.iter_mut().for_each(RaySet::clear);
        let image = self.recorded.header.frame;
        let [width, _] = self.recorded.reflections.size();
        let columns = width.div_ceil(TILE_EDGE);
        let rect = self.header.frame.tile(index);
        for place in rect.x..rect.x + rect.width {
            let Some(pixel) = self.pixel(place) else {
                let (rays, shadows) = tile.ray_sets.split_first_mut().expect("reflection rays are there");
                rays.end_ray(NOT_CAST)?;
                shadows.iter_mut().for_each(RaySet::skip_ray);
                continue;
            };
            let (x, y) = (pixel % width, pixel / width);
            let from = y / TILE_EDGE * columns + x / TILE_EDGE;
            let of_tile = image.tile(from);
            let ray = ((y - of_tile.y) * of_tile.width + x - of_tile.x) as usize;
            for (set, recorded) in tile.ray_sets.iter_mut().zip(&self.recorded.tiles[from as usize]) {
                set.steps.extend_from_slice(&recorded.steps[recorded.range(ray)]);
                set.end_ray(recorded.hits[ray])?;
            }
        }
        Ok(())
    }

    fn stalls(&self) -> u64 {
        self.recorded.stalls
    }
}

impl ReflectionList for RecordedList<'_> {
    fn pixel(&self, place: u32) -> Option<u32> {
        let ray = self.order[place as usize];
        (ray != NO_RAY).then(|| self.recorded.reflections.rays()[ray as usize].pixel)
    }
}
