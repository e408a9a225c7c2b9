//! A report, or a comparison of several, as one page of HTML that asks the network for nothing.
//!
//! Everything but the maps can be read without a script: tables are written here, and the scripts sort and filter them, show what counters
//! mean, and look up pixels. The same report gives the same bytes but for the section "This run".

mod comparison;
mod counters;
mod energy;
mod facts;
mod markup;
mod packed;
mod pixels;
mod rays;
mod summary;
mod sustained;
mod time;
mod traffic;

pub use comparison::comparison;
pub use pixels::PixelMap;
pub use rays::{Ray, RayEnd, RaySample};

use crate::chart::{MOST_SERIES, series_colour};
use crate::heat_map::Unpaintable;
use crate::report::Report;
use markup::{Escaped, section};

const STYLE: &str = include_str!("assets/page.css");
const SCRIPTS: [&str; 5] = [
    include_str!("assets/tables.js"),
    include_str!("assets/tips.js"),
    include_str!("assets/unpack.js"),
    include_str!("assets/rays.js"),
    include_str!("assets/pixels.js"),
];

/// A chart that belongs to a report.
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// An SVG document without a prolog, made by [`chart`](crate::chart).
    pub svg: String,
}

/// What a page shows beside the report.
#[derive(Default)]
pub struct Pictures<'a> {
    /// Of the frame's pixels.
    pub maps: Vec<&'a PixelMap<'a>>,
    /// Steps of some of the rays of these pixels.
    pub rays: Option<RaySample>,
    /// Charts.
    pub charts: Vec<Chart>,
}

/// The page.
///
/// # Errors
/// When a map has no values, not a whole number of rows, or another size than the first.
pub fn write(report: &Report, pictures: &Pictures<'_>) -> Result<String, Unpaintable> {
    let Pictures { maps, rays, charts } = pictures;
    let pixels = pixels::write(maps, &rays::write(rays.as_ref()))?;
    let sections = [
        ("summary", "Summary", summary::write(report)),
        ("time", "Frame time", time::write(report)),
        ("traffic", "Bandwidth", traffic::write(report)),
        ("counters", "Counters", counters::write(report)),
        ("pixels", "Pixels", pixels),
        ("energy", "Energy", energy::write(report.energy.as_ref())),
        ("sustained", "On a phone that warms", sustained::write(report.sustained.as_ref())),
        ("charts", "Charts", charts.iter().map(chart).collect()),
        ("buffers", "Buffers", traffic::buffers(&report.buffers)),
        ("inputs", "Inputs and hashes", facts::inputs(report)),
        ("left-out", "Left out, and estimates", facts::honesty(report)),
        ("run", "This run", facts::run(&report.run)),
    ];
    let title = format!("{} on {}", report.inputs.scene, report.inputs.gpu);
    Ok(page(&title, &summary::heading(report), &sections))
}

/// A page of sections: id, title, body.
fn page(title: &str, heading: &str, sections: &[(&str, &str, String)]) -> String {
    let there = || sections.iter().filter(|(_, _, body)| !body.is_empty());
    let links: String = there().map(|(id, title, _)| format!("<a href=\"#{id}\">{title}</a>\n")).collect();
    let body: String = there().map(|(id, title, body)| section(id, title, body)).collect();
    let (title, colours, scripts) = (Escaped(title), colours(), SCRIPTS.concat());
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}</title>\n<style>\n{colours}{STYLE}</style>\n<script>document.documentElement.classList.add(\"js\");</script>\n</head>\n<body>\n\
         {heading}<nav aria-label=\"Sections\">\n{links}</nav>\n<main>\n{body}</main>\n<div id=\"tip\" role=\"tooltip\" hidden></div>\n<script>\n{scripts}</script>\n</body>\n</html>\n"
    )
}

fn chart(Chart { title, svg }: &Chart) -> String {
    let title = Escaped(title);
    format!(
        "<figure><div class=\"scroll\" role=\"region\" aria-label=\"{title}\" tabindex=\"0\">{svg}</div></figure>\n"
    )
}

/// The colours of series, as classes and as variables that a dark page can change.
fn colours() -> String {
    let of_series = |series: usize| {
        let ([red, green, blue], striped) = series_colour(series);
        let stripes = if striped { ";--stripe:var(--page)" } else { "" };
        format!(".s{series}{{--series:#{red:02x}{green:02x}{blue:02x}{stripes}}}\n")
    };
    (0..MOST_SERIES).map(of_series).collect()
}
