//! Heat maps that can be asked for the figures of a pixel.
//!
//! The page holds the figures themselves and draws them; what it can say without a script is their distribution.

use super::markup::{Cell, Column, Escaped, Group, Table};
use super::packed::Packed;
use crate::coverage;
use crate::heat_map::scale::{Scale, there};
use crate::heat_map::{HeatMap, NO_VALUE, Unpaintable, rows};
use crate::picture::{Rgb, UNPAINTED, ramp};
use gpumodel::reflections::Coverage;
use serde::Serialize;

/// Figures that a map may have whole, about those of 2048 x 2048 pixels. A larger frame is reduced, so that a page stays below some 20 MB.
const MOST_FIGURES: usize = 1 << 22;

/// Something of each pixel.
pub enum PixelMap<'a> {
    /// A figure.
    Heat(HeatMap<'a>),
    /// Where its reflection comes from.
    Coverage {
        /// What is shown.
        title: String,
        /// Pixels per row.
        width: u32,
        /// Row by row from the top left.
        coverage: &'a [Coverage],
    },
}

/// The maps as the page's script reads them.
#[derive(Serialize)]
struct Data<'a> {
    /// Values across and down.
    size: [u32; 2],
    /// Pixels across and down that a value stands for.
    reduce: u32,
    ramp: [Rgb; 9],
    none: Rgb,
    maps: Vec<MapData<'a>>,
}

#[derive(Serialize)]
struct MapData<'a> {
    title: &'a str,
    unit: &'a str,
    /// Value of the last colour; none for classes.
    end: Option<u32>,
    /// Value of pixels that have none; no pixel lacks one where it is missing.
    none: Option<u32>,
    classes: Vec<(&'static str, Rgb)>,
    #[serde(flatten)]
    packed: Packed,
}

/// A section of all maps of one frame, with `rays` of its pixels beside them; nothing without a map.
///
/// # Errors
/// When a map has no values, not a whole number of rows, or another size than the first.
pub(super) fn write(maps: &[&PixelMap<'_>], rays: &str) -> Result<String, Unpaintable> {
    let Some(first) = maps.first() else { return Ok(String::new()) };
    let frame = first.size()?;
    for map in maps {
        let size = map.size()?;
        if size != frame {
            return Err(Unpaintable(format!(
                "maps of {size:?} and {frame:?} pixels on one page: expected maps of one frame"
            )));
        }
    }
    let reduce = (1..)
        .find(|by| frame.map(|side| side.div_ceil(*by) as usize).iter().product::<usize>() <= MOST_FIGURES);
    let reduce = reduce.expect("one value for all is few enough");
    let size = frame.map(|side| side.div_ceil(reduce));
    let data = Data {
        size,
        reduce,
        ramp: ramp::POINTS,
        none: UNPAINTED,
        maps: maps.iter().map(|map| map.data(frame, reduce)).collect(),
    };
    let json = serde_json::to_string(&data).expect("strings and whole numbers");
    let json = json.replace('<', "\\u003c");
    let note = if reduce > 1 {
        format!(
            "<p>Maps are reduced: a figure stands for the {reduce} \u{d7} {reduce} pixels around it, their mean.</p>\n"
        )
    } else {
        String::new()
    };
    let viewer = viewer(maps, size, rays);
    Ok(format!(
        "{note}{viewer}{}<script type=\"application/json\" id=\"map-data\">{json}</script>\n",
        distributions(maps)
    ))
}

/// Places for the script to fill; unseen without it.
fn viewer(maps: &[&PixelMap<'_>], [width, height]: [u32; 2], rays: &str) -> String {
    let choice = |(index, map): (usize, &&PixelMap<'_>)| {
        let checked = if index == 0 { " checked" } else { "" };
        let title = Escaped(map.title());
        format!(
            "<label><input type=\"radio\" name=\"map\" value=\"{index}\"{checked}><span>{title}</span></label>\n"
        )
    };
    let choices: String = maps.iter().enumerate().map(choice).collect();
    let [right, bottom] = [width - 1, height - 1];
    format!(
        "<noscript><p>The maps need a script to be drawn; the same pictures lie beside this page as PNG files.</p></noscript>\n\
         <div class=\"viewer needs-js\">\n<fieldset class=\"choice\"><legend>Map</legend>{choices}</fieldset>\n\
         <div class=\"view\"><div class=\"canvas\"><canvas id=\"map\" width=\"{width}\" height=\"{height}\" tabindex=\"0\" role=\"application\" \
         aria-label=\"Map of the frame; arrow keys move to another pixel, with Shift by 16\" aria-describedby=\"readout\"></canvas>\
         <i id=\"mark\"></i></div>\n<div id=\"scale\"></div></div>\n\
         <div class=\"reading\"><div class=\"place\"><label>x <input id=\"at-x\" type=\"number\" min=\"0\" max=\"{right}\" value=\"0\"></label>\
         <label>y <input id=\"at-y\" type=\"number\" min=\"0\" max=\"{bottom}\" value=\"0\"></label>\
         <button id=\"pin\" type=\"button\" aria-pressed=\"false\">Hold</button></div>\n\
         <canvas id=\"loupe\" width=\"13\" height=\"13\" aria-hidden=\"true\"></canvas>\n\
         <table id=\"readout\" aria-live=\"polite\"></table>\n\
         <p class=\"hint\">Point, touch, or use the arrow keys. A click holds the pixel.</p>{rays}</div>\n</div>\n"
    )
}

/// What can be said of the maps without looking at a pixel.
fn distributions(maps: &[&PixelMap<'_>]) -> String {
    let row = |map: &&PixelMap<'_>| {
        let PixelMap::Heat(map) = *map else { return None };
        let mut values: Vec<u32> = there(map.values).collect();
        if values.is_empty() {
            return None;
        }
        values.sort_unstable();
        let mean = values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64;
        let at = |percentile: f64| {
            let rank = (values.len() as f64 * percentile / 100.0).ceil() as usize;
            Cell::count(u64::from(values[rank.clamp(1, values.len()) - 1]))
        };
        let names = [Cell::Words(map.title.clone()), Cell::Words(map.unit.clone()), Cell::number(mean)];
        Some(names.into_iter().chain([0.0, 50.0, 95.0, 99.0, 100.0].map(at)).collect())
    };
    let figures = ["mean", "least", "median", "95 %", "99 %", "most"].map(Column::figures);
    let rows: Vec<Vec<Cell>> = maps.iter().filter_map(row).collect();
    let table = Table {
        label: "Distribution of the figures of all pixels".to_owned(),
        columns: [Column::words("per pixel"), Column::words("unit")].into_iter().chain(figures).collect(),
        groups: vec![Group { title: None, rows }],
        filter: false,
    };
    table.to_string()
}

impl PixelMap<'_> {
    fn title(&self) -> &str {
        match self {
            Self::Heat(map) => &map.title,
            Self::Coverage { title, .. } => title,
        }
    }

    fn size(&self) -> Result<[u32; 2], Unpaintable> {
        let (width, values) = match self {
            Self::Heat(map) => (map.width, map.values.len()),
            Self::Coverage { width, coverage, .. } => (*width, coverage.len()),
        };
        Ok([width, rows(width, values)?])
    }

    fn data(&self, frame: [u32; 2], reduce: u32) -> MapData<'_> {
        let width = frame[0].div_ceil(reduce) as usize;
        match self {
            Self::Heat(map) => {
                let values = reduced(frame, reduce, map.values, mean);
                let most = there(&values).max().unwrap_or(0);
                let lacks = values.contains(&NO_VALUE).then_some(most + 1);
                let values: Vec<u32> = values
                    .into_iter()
                    .map(|value| if value == NO_VALUE { most + 1 } else { value })
                    .collect();
                MapData {
                    title: &map.title,
                    unit: &map.unit,
                    end: Some(Scale::of(&[map.values], map.end).end),
                    none: lacks,
                    classes: Vec::new(),
                    packed: Packed::new(width, &values),
                }
            }
            Self::Coverage { title, coverage, .. } => {
                let classes: Vec<u32> = coverage.iter().map(|&class| class as u32).collect();
                MapData {
                    title,
                    unit: "",
                    end: None,
                    none: None,
                    classes: coverage::ALL
                        .map(|class| (coverage::name(class), coverage::colour(class)))
                        .into(),
                    packed: Packed::new(width, &reduced(frame, reduce, &classes, most_common)),
                }
            }
        }
    }
}

/// A value for each square of so many pixels.
fn reduced([width, height]: [u32; 2], by: u32, values: &[u32], of: fn(&[u32]) -> u32) -> Vec<u32> {
    if by == 1 {
        return values.to_vec();
    }
    let corners =
        (0..height).step_by(by as usize).flat_map(|y| (0..width).step_by(by as usize).map(move |x| (x, y)));
    let square = |(left, top): (u32, u32)| {
        let rows = top..(top + by).min(height);
        let places = rows.flat_map(|y| (left..(left + by).min(width)).map(move |x| (y * width + x) as usize));
        of(&places.map(|place| values[place]).collect::<Vec<_>>())
    };
    corners.map(square).collect()
}

/// Rounded; of those that there are.
fn mean(values: &[u32]) -> u32 {
    crate::heat_map::scale::mean_and_max(values).map_or(NO_VALUE, |(mean, _)| mean.round() as u32)
}

/// The smallest of the values that stand there most often.
fn most_common(values: &[u32]) -> u32 {
    let times = |value: u32| values.iter().filter(|&&other| other == value).count();
    let best = values.iter().copied().max_by_key(|&value| (times(value), std::cmp::Reverse(value)));
    best.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reduced_map_has_the_mean_of_what_there_is_or_what_there_is_most_of() {
        let values = [1, 3, 9, 5, NO_VALUE, 11, 2, NO_VALUE, NO_VALUE];
        assert_eq!(reduced([3, 3], 2, &values, mean), [3, 10, 2, NO_VALUE]);
        assert_eq!(reduced([3, 3], 1, &values, mean), values);
        assert_eq!(reduced([3, 2], 2, &[1, 2, 4, 2, 1, 3], most_common), [1, 3]);
    }

    #[test]
    fn maps_of_two_sizes_are_refused() {
        let heat = |width, values| {
            PixelMap::Heat(HeatMap {
                title: "t".into(),
                subtitle: String::new(),
                unit: "u".into(),
                width,
                values,
                end: crate::heat_map::ScaleEnd::Value(5),
            })
        };
        let four = [1, 2, 3, 4];
        assert!(write(&[&heat(2, &four), &heat(2, &four)], "").is_ok());
        assert!(write(&[&heat(2, &four), &heat(4, &four)], "").is_err());
        assert!(write(&[&heat(3, &four)], "").is_err());
    }
}
