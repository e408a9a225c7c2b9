//! The counterparts of the figures and the table of Sousa et al. 2019, from the measurements of their claims.

use super::measure::Measured;
use crate::pictures::{HEAT_MAP_PERCENTILE, MAPS, MapKind, in_sentence};
use crate::report::Answer;
use reports::chart::{BarChart, Scale, Series};
use reports::claims::{ClaimSet, SceneRole, Setup};
use reports::heat_map::{Panel, Panels, ScaleEnd, write_panels_png};
use std::fmt::Write;

/// The paper, by the letter of its claims.
const LETTER: &str = "A";

/// The traversals of the paper, as setups and as the paper name them.
const TRAVERSALS: [(&str, &str); 4] = [
    ("kd backtrack", "KD-Backtrack"),
    ("kd push-down", "KD-Pushdown"),
    ("bvh parent-link", "BVH Parent-Link"),
    ("bvh restart-trail", "BVH Trail"),
];
const LAYOUTS: [&str; 3] = ["padded", "compact", "split"];
const TECHNIQUES: [&str; 3] = ["fragment", "compute", "hybrid"];
/// Ct and Ci of the four scenarios, by rising ratio; the chosen one is the third.
const COSTS: [[&str; 2]; 4] = [["1", "3.5"], ["1.5", "3"], ["3", "1.5"], ["3.5", "1"]];
const CHOSEN: [&str; 2] = COSTS[2];
/// The scene whose heat maps the paper shows.
const MAPPED: &str = "fairy";

/// Nodes in thousands except in the Cornell Box, and sizes as printed, per traversal and scene.
const TABLE_1: [[(&str, &str); 4]; 4] = [
    [("13", "0,61 Kb"), ("139k", "6,5 Mb"), ("250k", "1,2 Mb (misprint of 11,7)"), ("320k", "15 Mb")],
    [("13", "0,20 Kb"), ("139k", "2,2 Mb"), ("253k", "3,9 Mb"), ("322k", "5 Mb")],
    [("11", "0,52 Kb"), ("66k", "3,1 Mb"), ("107k", "5 Mb"), ("134k", "6,3 Mb")],
    [("11", "0,34 Kb"), ("66k", "2,1 Mb"), ("107k", "3,3 Mb"), ("134k", "4,2 Mb")],
];

/// A place in the paper's experiments.
#[derive(Clone, Copy)]
struct Place<'a> {
    scene: &'a str,
    traversal: &'a str,
    layout: &'a str,
    technique: &'a str,
    costs: [&'a str; 2],
}

impl Place<'_> {
    fn is(&self, setup: &Setup) -> bool {
        let axis = |name: &str, value: &str| setup.get(name) == Some(value);
        setup.scene == self.scene
            && axis("traversal", self.traversal)
            && axis("layout", self.layout)
            && axis("technique", self.technique)
            && axis("ct", self.costs[0])
            && axis("ci", self.costs[1])
            && axis("gpu", "adreno-540")
            && axis("short_stack", "0")
            && axis("trail_bits", "64")
    }

    fn answer<'m>(&self, measured: &'m Measured) -> Option<&'m Answer> {
        measured.answers.iter().find(|(setup, _)| self.is(setup)).map(|(_, answer)| answer)
    }

    fn counter(&self, measured: &Measured, id: &str) -> Option<f64> {
        self.answer(measured)?.report.counters.get(id)?.value.as_f64()
    }
}

fn base<'a>(scene: &'a str, traversal: &'a str) -> Place<'a> {
    Place { scene, traversal, layout: LAYOUTS[0], technique: TECHNIQUES[0], costs: CHOSEN }
}

/// Whether these are the claims of the paper whose figures are drawn here.
pub(crate) fn is_of(claims: &ClaimSet) -> bool {
    claims.paper.letter == LETTER
}

/// Setups whose heat maps the figures show.
pub(crate) fn is_mapped(setup: &Setup) -> bool {
    let costs = [CHOSEN, COSTS[0], COSTS[3]];
    TRAVERSALS
        .iter()
        .any(|(traversal, _)| costs.iter().any(|&costs| Place { costs, ..base(MAPPED, traversal) }.is(setup)))
}

/// A scene's title, and what it was traced on where that is another.
fn title(role: &SceneRole, measured: &Measured) -> String {
    match measured.measurements.stand_in_of(&role.name) {
        Some(stand_in) => format!("{} ({stand_in})", role.title),
        None => role.title.clone(),
    }
}

/// All charts, by the stem of their files.
pub(crate) fn charts(claims: &ClaimSet, measured: &Measured) -> Vec<(String, BarChart)> {
    let scenes: Vec<&SceneRole> =
        claims.scenes.iter().filter(|role| measured.scenes.contains_key(&role.name)).collect();
    let mut charts = Vec::new();
    for (figure, stem, id, what, label, unit) in [
        (5, "fps-by-traversal", "fps", "Frames per second", "frames per second (1/s)", 1.0),
        (
            6,
            "node-fetches-by-traversal",
            "node_fetches_per_pixel",
            "Node fetches per pixel",
            "node fetches per pixel",
            1.0,
        ),
        (
            7,
            "memory-read-by-traversal",
            "sp_memory_read_bytes_per_second",
            "SP Memory Read",
            "SP memory read (GB/s)",
            1e-9,
        ),
        (8, "alu-by-traversal", "alu_per_fragment", "ALU per fragment", "ALU operations per fragment", 1.0),
    ] {
        let series = TRAVERSALS.map(|(traversal, name)| Series {
            name: name.to_owned(),
            values: scenes
                .iter()
                .map(|role| Some(base(&role.name, traversal).counter(measured, id)? * unit))
                .collect(),
        });
        charts.push((
            stem.to_owned(),
            BarChart {
                title: format!("{what} by traversal"),
                subtitle: subtitle(figure, "fragment shader, padded layout, Ct 3 Ci 1.5"),
                value_label: label.to_owned(),
                groups: scenes.iter().map(|role| title(role, measured)).collect(),
                series: series.into(),
                scale: if id == "fps" { Scale::Log } else { Scale::Linear },
            },
        ));
    }
    for role in scenes {
        charts.extend(charts_of_scene(role, measured));
    }
    charts
}

fn subtitle(figure: u32, conditions: &str) -> String {
    format!("Adreno 540 model, 1024x1024, {conditions}; counterpart of figure {figure} of Sousa et al. 2019")
}

/// Layouts, costs and techniques in one scene, by traversal.
fn charts_of_scene(role: &SceneRole, measured: &Measured) -> Vec<(String, BarChart)> {
    let scene = title(role, measured);
    let chart = |title: String, subtitle: String, label: &str, series: Vec<Series>| BarChart {
        title,
        subtitle,
        value_label: label.to_owned(),
        groups: TRAVERSALS.iter().map(|&(_, name)| name.to_owned()).collect(),
        series,
        scale: Scale::Linear,
    };
    let fps = "frames per second (1/s)";
    let of = |id: &str, unit: f64, vary: &dyn Fn(&mut Place<'_>)| -> Vec<Option<f64>> {
        let of_traversal = |&(traversal, _): &(&str, &str)| {
            let mut place = base(&role.name, traversal);
            vary(&mut place);
            Some(place.counter(measured, id)? * unit)
        };
        TRAVERSALS.iter().map(of_traversal).collect()
    };
    let layouts = |id: &str, unit: f64| -> Vec<Series> {
        let series = |layout: &'static str| Series {
            name: layout.to_owned(),
            values: of(id, unit, &|place| place.layout = layout),
        };
        LAYOUTS.map(series).into()
    };
    let costs = COSTS.map(|costs: [&'static str; 2]| Series {
        name: format!("Ct {} Ci {}", costs[0], costs[1]),
        values: of("fps", 1.0, &|place| place.costs = costs),
    });
    let techniques = TECHNIQUES.map(|technique: &'static str| Series {
        name: technique.to_owned(),
        values: of("fps", 1.0, &|place| place.technique = technique),
    });
    let mut charts = vec![
        (
            format!("fps-by-layout-{}", role.name),
            chart(
                format!("{scene}: frames per second by primitive layout"),
                subtitle(9, "fragment shader, Ct 3 Ci 1.5"),
                fps,
                layouts("fps", 1.0),
            ),
        ),
        (
            format!("memory-read-by-layout-{}", role.name),
            chart(
                format!("{scene}: SP memory read by primitive layout"),
                subtitle(if role.name == "cornell" { 10 } else { 11 }, "fragment shader, Ct 3 Ci 1.5"),
                "SP memory read (MB/s)",
                layouts("sp_memory_read_bytes_per_second", 1e-6),
            ),
        ),
        (
            format!("fps-by-costs-{}", role.name),
            chart(
                format!("{scene}: frames per second by SAH costs"),
                subtitle(12, "fragment shader, padded layout"),
                fps,
                costs.into(),
            ),
        ),
        (
            format!("fps-by-technique-{}", role.name),
            chart(
                format!("{scene}: frames per second by rendering technique"),
                subtitle(14, "padded layout, Ct 3 Ci 1.5"),
                fps,
                techniques.into(),
            ),
        ),
    ];
    charts.retain(|(_, chart)| chart.series.iter().flat_map(|series| &series.values).any(Option::is_some));
    charts
}

/// Heat maps side by side on one scale, by the stem of their files: the traversals as in figure 6, and the extreme costs as in figure 13.
pub(crate) fn heat_maps(claims: &ClaimSet, measured: &Measured) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut pictures = Vec::new();
    let Some(role) = claims.scenes.iter().find(|role| role.name == MAPPED) else { return Ok(pictures) };
    let scene = title(role, measured);
    for kind in &MAPS {
        let rows: [(&str, u32, &[[&str; 2]]); 2] =
            [("traversals", 6, &[CHOSEN]), ("costs", 13, &[COSTS[3], COSTS[0]])];
        for (stem, figure, costs) in rows {
            let places: Vec<(String, Place<'_>)> = costs
                .iter()
                .flat_map(|&costs| {
                    TRAVERSALS.iter().map(move |&(traversal, name)| {
                        (
                            format!("{name}, Ct {} Ci {}", costs[0], costs[1]),
                            Place { costs, ..base(MAPPED, traversal) },
                        )
                    })
                })
                .collect();
            if let Some(picture) = panels(kind, &scene, figure, &places, measured)? {
                pictures.push((format!("{}-by-{stem}", kind.file), picture));
            }
        }
    }
    Ok(pictures)
}

fn panels(
    kind: &MapKind,
    scene: &str,
    figure: u32,
    places: &[(String, Place<'_>)],
    measured: &Measured,
) -> anyhow::Result<Option<Vec<u8>>> {
    let mut width = 0;
    let mut panels = Vec::new();
    for (label, place) in places {
        let Some(maps) = place.answer(measured).and_then(|answer| answer.replayed.maps.as_ref()) else {
            continue;
        };
        let map = (kind.of)(maps);
        width = map.width;
        panels.push(Panel { label: label.clone(), values: &map.values });
    }
    if panels.is_empty() {
        return Ok(None);
    }
    let picture = write_panels_png(&Panels {
        title: format!("{scene}: {}", in_sentence(kind.title)),
        subtitle: format!(
            "Adreno 540 model, fragment shader, padded layout; counterpart of figure {figure} of Sousa et al. 2019"
        ),
        unit: kind.unit.to_owned(),
        width,
        panels,
        columns: TRAVERSALS.len(),
        end: ScaleEnd::Percentile(HEAT_MAP_PERCENTILE),
    })?;
    Ok(Some(picture))
}

/// Table 1 of the paper beside ours, as Markdown.
pub(crate) fn table_1(claims: &ClaimSet, measured: &Measured) -> String {
    let mut out = String::from(
        "| structure | scene | nodes | paper | bytes per node | size (KiB) | paper |\n|---|---|---:|---:|---:|---:|---:|\n",
    );
    for ((traversal, name), published) in TRAVERSALS.iter().zip(TABLE_1) {
        for (role, (nodes, size)) in claims.scenes.iter().zip(published) {
            let place = base(&role.name, traversal);
            let of = |id: &str| place.counter(measured, id);
            let (Some(count), Some(bytes)) = (of("structure_nodes"), of("structure_bytes")) else { continue };
            writeln!(
                out,
                "| {name} | {} | {count} | {nodes} | {} | {:.2} | {size} |",
                title(role, measured),
                bytes / count,
                bytes / 1024.0
            )
            .expect("a string takes every write");
        }
    }
    out
}
