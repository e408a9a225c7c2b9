//! Pictures of a frame: what its pixels cost and where their reflections come from, and how full its ray unit is.

mod panels;
mod rays;

pub(crate) use panels::{MOST_PANELS, Mapped, panels};
pub(crate) use rays::MOST_SAMPLED_PIXELS;

use crate::report::Answer;
use gpumodel::HeatMaps;
use reports::Inputs;
use reports::chart::BarChart;
use reports::coverage::{self, CoverageMaps, CoveragePanel};
use reports::heat_map::{self, HeatMap, ScaleEnd};
use reports::html::{self, PixelMap};
use reports::lane_use::{self, UnitOccupancy};

/// Pixels above this percentile share the heat map's last colour.
pub(crate) const HEAT_MAP_PERCENTILE: f64 = 99.5;

/// A figure that is kept for each pixel.
pub(crate) struct MapKind {
    /// Name of its files, without extension.
    pub(crate) file: &'static str,
    pub(crate) title: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) of: fn(&HeatMaps) -> &gpumodel::HeatMap,
}

/// All of them.
pub(crate) const MAPS: [MapKind; 3] = [
    MapKind {
        file: "node-fetches",
        title: "Node fetches per pixel",
        unit: "fetches",
        of: |maps| &maps.node_fetches,
    },
    MapKind {
        file: "loaded-bytes",
        title: "Bytes of nodes and triangles loaded per pixel",
        unit: "B",
        of: |maps| &maps.loaded_bytes,
    },
    MapKind {
        file: "dram-lines",
        title: "Lines read from DRAM by the pixel's warp",
        unit: "lines",
        of: |maps| &maps.warp_misses,
    },
];

const COVERAGE: &str = "coverage";
const COVERAGE_TITLE: &str = "Where reflections come from";
const DIVERGENCE: &str = "divergence";
const DIVERGENCE_TITLE: &str = "Lane slots that the pixel's warp wasted while it traced";
const DIVERGENCE_OF_REFLECTIONS_TITLE: &str =
    "Lane slots that the pixel's warp wasted while it traced reflection rays";
const DIVERGENCE_UNIT: &str = "%";
/// Wasted slots are shown on the whole of their range.
const DIVERGENCE_END: ScaleEnd = ScaleEnd::Value(100);
const OCCUPANCY: &str = "ray-unit-occupancy";

/// Names of all files that a frame may have.
pub(crate) fn names() -> Vec<String> {
    let pictures = MAPS.iter().map(|kind| kind.file).chain([COVERAGE, DIVERGENCE, OCCUPANCY]);
    let pictures = pictures.map(|stem| format!("{stem}.png"));
    pictures.chain(["svg", "csv"].map(|kind| format!("{OCCUPANCY}.{kind}"))).collect()
}

/// What a frame is of, in a subtitle.
pub(crate) fn frame(inputs: &Inputs) -> String {
    let Inputs { scene, accel, traversal, technique, width, height, .. } = inputs;
    let size = width.zip(*height).map_or(String::new(), |(width, height)| format!(", {width}x{height}"));
    format!("{scene}{size}, {accel} {traversal}, {technique}")
}

/// What is shown of a frame: what it has. A list of rays has no pixels.
pub(crate) struct Pictures<'a> {
    frame: String,
    gpu: &'a str,
    /// Names of files without extension, and what they show.
    maps: Vec<(&'static str, PixelMap<'a>)>,
    occupancy: Option<&'a UnitOccupancy>,
}

/// Lane slots that the warps of reflection rays wasted, in per cent, by pixel.
pub(crate) fn wasted_by_reflections(answer: &Answer) -> Option<Vec<u32>> {
    let lane_slots = answer.reflections.as_ref()?.lane_slots.as_ref()?;
    Some(lane_use::wasted_per_cent(lane_slots))
}

impl<'a> Pictures<'a> {
    /// Of a frame and what [`wasted_by_reflections`] says of it.
    pub(crate) fn new(answer: &'a Answer, wasted: Option<&'a [u32]>) -> Self {
        let Answer { report, replayed, reflections, occupancy, .. } = answer;
        let Inputs { gpu, width, .. } = &report.inputs;
        let frame = frame(&report.inputs);
        let mut maps = Vec::new();
        if let (Some(heat), Some(width)) = (&replayed.maps, *width) {
            let queries = if reflections.is_some() { ", ray queries alone" } else { "" };
            maps.extend(MAPS.iter().map(|kind| {
                let map = HeatMap {
                    title: kind.title.to_owned(),
                    subtitle: format!("{frame}{queries}"),
                    unit: kind.unit.to_owned(),
                    width,
                    values: &(kind.of)(heat).values,
                    end: ScaleEnd::Percentile(HEAT_MAP_PERCENTILE),
                };
                (kind.file, PixelMap::Heat(map))
            }));
            maps.extend(heat.wasted_slots.as_ref().map(|map| {
                let subtitle = format!("{frame}, {gpu}");
                (DIVERGENCE, divergence(DIVERGENCE_TITLE, subtitle, width, &map.values))
            }));
        }
        if let Some(of_pixels) = reflections {
            let coverage = PixelMap::Coverage {
                title: COVERAGE_TITLE.to_owned(),
                width: of_pixels.width,
                coverage: &of_pixels.coverage,
            };
            maps.push((COVERAGE, coverage));
            maps.extend(wasted.map(|values| {
                let title = DIVERGENCE_OF_REFLECTIONS_TITLE;
                (DIVERGENCE, divergence(title, format!("{frame}, {gpu}"), of_pixels.width, values))
            }));
        }
        Self { frame, gpu, maps, occupancy: occupancy.as_ref() }
    }

    /// Names and bytes of files.
    pub(crate) fn files(&self) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
        let mut files = Vec::new();
        for (stem, map) in &self.maps {
            let png = match map {
                PixelMap::Heat(map) => heat_map::write_png(map)?,
                PixelMap::Coverage { title, width, coverage } => coverage::write_png(&CoverageMaps {
                    title: title.clone(),
                    subtitle: self.frame.clone(),
                    width: *width,
                    panels: vec![CoveragePanel { label: String::new(), coverage }],
                    columns: 1,
                })?,
            };
            files.push((format!("{stem}.png"), png));
        }
        if let Some(occupancy) = self.occupancy {
            let chart = self.occupancy_chart(occupancy);
            files.push((format!("{OCCUPANCY}.svg"), chart.svg()?.into_bytes()));
            files.push((format!("{OCCUPANCY}.png"), chart.png()?));
            files.push((format!("{OCCUPANCY}.csv"), occupancy.csv().into_bytes()));
        }
        Ok(files)
    }

    fn occupancy_chart(&self, occupancy: &UnitOccupancy) -> BarChart {
        occupancy.chart(self.subtitle())
    }

    /// What charts of the frame say below their title.
    pub(crate) fn subtitle(&self) -> String {
        format!("{}, {}", self.frame, self.gpu)
    }

    /// The report with all pictures in one page.
    pub(crate) fn page(&self, answer: &Answer) -> anyhow::Result<String> {
        let mut charts = Vec::new();
        if let Some(load) = &answer.load {
            let chart = load.chart(self.subtitle());
            charts.push(html::Chart { svg: chart.svg()?, title: chart.title });
        }
        if let Some(occupancy) = self.occupancy {
            let chart = self.occupancy_chart(occupancy);
            charts.push(html::Chart { svg: chart.svg()?, title: chart.title });
        }
        let rays = answer.rays.as_ref();
        let pictures = html::Pictures {
            maps: self.maps.iter().map(|(_, map)| map).collect(),
            rays: rays.and_then(|(sample, sets)| rays::traced(sample, sets, &answer.report)),
            charts,
        };
        Ok(html::write(&answer.report, &pictures)?)
    }
}

fn divergence<'a>(title: &str, subtitle: String, width: u32, values: &'a [u32]) -> PixelMap<'a> {
    PixelMap::Heat(HeatMap {
        title: title.to_owned(),
        subtitle,
        unit: DIVERGENCE_UNIT.to_owned(),
        width,
        values,
        end: DIVERGENCE_END,
    })
}

/// A title as it reads within a sentence: its first letter small.
pub(crate) fn in_sentence(title: &str) -> String {
    let mut letters = title.chars();
    letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
}
