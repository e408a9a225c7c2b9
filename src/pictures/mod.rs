//! Pictures of a frame: what its pixels cost and where their reflections come from, and how full its ray unit is.

mod panels;

pub(crate) use panels::{MOST_PANELS, Mapped, panels};

use crate::report::Answer;
use gpumodel::HeatMaps;
use reports::coverage::{self, CoverageMaps, CoveragePanel};
use reports::heat_map::{self, HeatMap, ScaleEnd};
use reports::{Inputs, lane_use};

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
const DIVERGENCE_TITLE: &str = "Lane slots that the pixel's warp wasted while it traced reflection rays";
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

/// The pictures of a frame as files, names and bytes: those that it has. A list of rays has no pixels.
pub(crate) fn of_answer(answer: &Answer) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let Answer { report, replayed, reflections, occupancy, .. } = answer;
    let Inputs { gpu, width, .. } = &report.inputs;
    let frame = frame(&report.inputs);
    let mut files = Vec::new();
    if let (Some(maps), Some(width)) = (&replayed.maps, *width) {
        let queries = if reflections.is_some() { ", ray queries alone" } else { "" };
        for kind in &MAPS {
            let map = HeatMap {
                title: kind.title.to_owned(),
                subtitle: format!("{frame}{queries}"),
                unit: kind.unit.to_owned(),
                width,
                values: &(kind.of)(maps).values,
                end: ScaleEnd::Percentile(HEAT_MAP_PERCENTILE),
            };
            files.push((format!("{}.png", kind.file), heat_map::write_png(&map)?));
        }
    }
    if let Some(maps) = reflections {
        let of_pixels = CoverageMaps {
            title: COVERAGE_TITLE.to_owned(),
            subtitle: frame.clone(),
            width: maps.width,
            panels: vec![CoveragePanel { label: String::new(), coverage: &maps.coverage }],
            columns: 1,
        };
        files.push((format!("{COVERAGE}.png"), coverage::write_png(&of_pixels)?));
        if let Some(lane_slots) = &maps.lane_slots {
            let map = HeatMap {
                title: DIVERGENCE_TITLE.to_owned(),
                subtitle: format!("{frame}, {gpu}"),
                unit: DIVERGENCE_UNIT.to_owned(),
                width: maps.width,
                values: &lane_use::wasted_per_cent(lane_slots),
                end: DIVERGENCE_END,
            };
            files.push((format!("{DIVERGENCE}.png"), heat_map::write_png(&map)?));
        }
    }
    if let Some(occupancy) = occupancy {
        let chart = occupancy.chart(format!("{frame}, {gpu}"));
        files.push((format!("{OCCUPANCY}.svg"), chart.svg()?.into_bytes()));
        files.push((format!("{OCCUPANCY}.png"), chart.png()?));
        files.push((format!("{OCCUPANCY}.csv"), occupancy.csv().into_bytes()));
    }
    Ok(files)
}

/// A title as it reads within a sentence: its first letter small.
pub(crate) fn in_sentence(title: &str) -> String {
    let mut letters = title.chars();
    letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
}
