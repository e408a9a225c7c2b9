//! Maps of several frames side by side, on one scale.

use super::{
    COVERAGE, COVERAGE_TITLE, DIVERGENCE, DIVERGENCE_END, DIVERGENCE_OF_REFLECTIONS_TITLE, DIVERGENCE_UNIT,
    HEAT_MAP_PERCENTILE, MAPS, in_sentence,
};
use gpumodel::HeatMaps;
use gpumodel::reflections::{Coverage, ReflectionMaps};
use reports::coverage::{self, CoverageMaps, CoveragePanel};
use reports::heat_map::{Panel, Panels, ScaleEnd, write_panels_png};
use reports::{Inputs, lane_use};

/// Panels of one picture, at most and side by side.
pub(crate) const MOST_PANELS: usize = 16;
const PANEL_COLUMNS: usize = 4;

/// Maps of one frame.
pub(crate) struct Mapped {
    pub(crate) inputs: Inputs,
    /// What it is called among the others.
    pub(crate) label: String,
    pub(crate) heat: Option<HeatMaps>,
    pub(crate) reflections: Option<ReflectionMaps>,
}

/// The maps of all frames of a scene in one picture each, where there are several.
pub(crate) fn panels(maps: &[Mapped]) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut scenes: Vec<&str> = maps.iter().map(|mapped| mapped.inputs.scene.as_str()).collect();
    scenes.dedup();
    let mut files = Vec::new();
    for (index, scene) in scenes.iter().enumerate() {
        let of_scene: Vec<&Mapped> = maps.iter().filter(|mapped| mapped.inputs.scene == *scene).collect();
        if of_scene.len() < 2 || of_scene.len() > MOST_PANELS {
            continue;
        }
        let page = Page { scene, conditions: conditions(&of_scene) };
        let queries_alone = of_scene.iter().all(|mapped| mapped.reflections.is_some());
        let number = if index == 0 { String::new() } else { format!("-{}", index + 1) };
        let mut add = |stem: &str, picture: Option<Vec<u8>>| {
            files.extend(picture.map(|picture| (format!("{stem}{number}.png"), picture)));
        };
        for kind in &MAPS {
            let of_frame = |mapped: &&Mapped| {
                let map = (kind.of)(mapped.heat.as_ref()?);
                Some((mapped.label.clone(), map.width, map.values.clone()))
            };
            let end = ScaleEnd::Percentile(HEAT_MAP_PERCENTILE);
            let title = format!("{}{}", kind.title, if queries_alone { ", ray queries alone" } else { "" });
            add(kind.file, page.heat(&title, kind.unit, end, of_scene.iter().filter_map(of_frame))?);
        }
        let divergence = of_scene.iter().filter_map(|mapped| {
            let maps = mapped.reflections.as_ref()?;
            let lane_slots = maps.lane_slots.as_ref()?;
            Some((mapped.label.clone(), maps.width, lane_use::wasted_per_cent(lane_slots)))
        });
        add(
            DIVERGENCE,
            page.heat(DIVERGENCE_OF_REFLECTIONS_TITLE, DIVERGENCE_UNIT, DIVERGENCE_END, divergence)?,
        );
        add(COVERAGE, page.coverage(&of_scene)?);
    }
    Ok(files)
}

/// What the maps of a scene have in common.
fn conditions(frames: &[&Mapped]) -> String {
    let parts: [fn(&Inputs) -> String; 3] = [
        |inputs| inputs.gpu.clone(),
        |inputs| inputs.technique.clone(),
        |inputs| format!("{} triangles", inputs.layout),
    ];
    let common = parts.iter().filter_map(|part| {
        let first = part(&frames[0].inputs);
        frames.iter().all(|frame| part(&frame.inputs) == first).then_some(first)
    });
    common.collect::<Vec<_>>().join(", ")
}

/// What stands above the maps of a scene.
struct Page<'a> {
    scene: &'a str,
    conditions: String,
}

impl Page<'_> {
    fn title(&self, title: &str) -> String {
        format!("{}: {}", self.scene, in_sentence(title))
    }

    /// `maps` are labels, widths and values.
    fn heat(
        &self,
        title: &str,
        unit: &str,
        end: ScaleEnd,
        maps: impl Iterator<Item = (String, u32, Vec<u32>)>,
    ) -> anyhow::Result<Option<Vec<u8>>> {
        let maps: Vec<_> = maps.collect();
        let [(_, width, _), _, ..] = maps.as_slice() else { return Ok(None) };
        let picture = write_panels_png(&Panels {
            title: self.title(title),
            subtitle: [self.conditions.as_str(), "one scale for all"].join("; "),
            unit: unit.to_owned(),
            width: *width,
            panels: maps.iter().map(|(label, _, values)| Panel { label: label.clone(), values }).collect(),
            columns: PANEL_COLUMNS,
            end,
        })?;
        Ok(Some(picture))
    }

    /// Each map that differs from all before it.
    fn coverage(&self, frames: &[&Mapped]) -> anyhow::Result<Option<Vec<u8>>> {
        let mut distinct: Vec<(Vec<&str>, u32, &[Coverage])> = Vec::new();
        for frame in frames {
            let Some(ReflectionMaps { width, coverage, .. }) = &frame.reflections else { continue };
            match distinct.iter_mut().find(|(_, _, other)| *other == coverage.as_slice()) {
                Some((labels, ..)) => labels.push(&frame.label),
                None => distinct.push((vec![&frame.label], *width, coverage)),
            }
        }
        let Some(&(_, width, _)) = distinct.first() else { return Ok(None) };
        let panel =
            |(labels, _, coverage): (Vec<&str>, u32, _)| CoveragePanel { label: labels.join("; "), coverage };
        let maps = CoverageMaps {
            title: self.title(COVERAGE_TITLE),
            subtitle: self.conditions.clone(),
            width,
            panels: distinct.into_iter().map(panel).collect(),
            columns: PANEL_COLUMNS,
        };
        Ok(Some(coverage::write_png(&maps)?))
    }
}
