//! What becomes of the frame rate on a phone that warms.

use super::markup::{Cell, Column, Escaped, Group, Table, terms};
use crate::sustained::{Heat, Minute, NodeHeat, Sustained, SustainedPoint, charge, span};
use crate::units::digits;

pub(super) fn write(sustained: Option<&Sustained>) -> String {
    let Some(sustained) = sustained else { return String::new() };
    let Sustained { phone, seconds, ambient_celsius, operating_points, minutes, nodes, .. } = sustained;
    let intro = format!(
        "<p>The frame drawn again and again for {}, on {} in air of {ambient_celsius} degrees Celsius.</p>\n",
        span(*seconds),
        Escaped(phone)
    );
    let tables = [points(operating_points), by_minute(minutes), heat(nodes)].map(|table| table.to_string());
    format!("{intro}{}{}", facts(sustained), tables.concat())
}

fn facts(sustained: &Sustained) -> String {
    let Sustained {
        peak_fps,
        sustained_fps,
        stability,
        throttled_after_s,
        outcome,
        ended_after_s,
        switches,
        heat,
        battery,
        ..
    } = sustained;
    let Heat { in_j, stored_j, to_air_j } = *heat;
    let lowered = throttled_after_s.map_or("never".to_owned(), span);
    let end = match outcome.as_str() {
        "shut_down" => "the phone shuts down",
        "ran_away" => "leakage runs away, and the phone shuts down",
        _ => "all of it was drawn",
    };
    let heat =
        format!("{} J in, {} J kept, {} J to the air", digits(in_j), digits(stored_j), digits(to_air_j));
    let battery = battery.as_ref().map(|battery| ("battery", charge(battery)));
    terms(
        [
            ("at first", format!("{} frames per second", digits(*peak_fps))),
            (
                "in the last minute",
                format!("{} frames per second, {:.1} %", digits(*sustained_fps), 100.0 * stability),
            ),
            ("clock first lowered after", lowered),
            ("changes of the clock", switches.to_string()),
            ("end", format!("{end}, after {}", span(*ended_after_s))),
            ("heat", heat),
        ]
        .into_iter()
        .chain(battery),
    )
}

fn points(points: &[SustainedPoint]) -> Table {
    let row = |point: &SustainedPoint| {
        let SustainedPoint {
            mhz,
            volts,
            fps,
            gpu_w,
            dram_w,
            leakage_w,
            settles_at_celsius,
            seconds,
            leakage_celsius: _,
        } = point;
        let settles = settles_at_celsius.map_or(Cell::Absent("no balance".to_owned()), Cell::number);
        let figures = [mhz, volts, fps, gpu_w, dram_w, leakage_w].map(|figure| Cell::number(*figure));
        figures.into_iter().chain([settles, Cell::number(*seconds)]).collect()
    };
    let titles = [
        "clock, MHz",
        "supply, V",
        "frames/s",
        "GPU, W",
        "memory, W",
        "leakage, W",
        "settles at, \u{b0}C",
        "time, s",
    ];
    Table {
        label: "The frame at each clock".to_owned(),
        columns: titles.map(Column::figures).into(),
        groups: vec![Group { title: None, rows: points.iter().map(row).collect() }],
        filter: false,
    }
}

fn by_minute(minutes: &[Minute]) -> Table {
    let row = |Minute { until_s, fps, energy_j, frame_energy_j }: &Minute| {
        [until_s, fps, energy_j, frame_energy_j].map(|figure| Cell::number(*figure)).into()
    };
    Table {
        label: "Each minute".to_owned(),
        columns: ["until, s", "frames/s", "energy, J", "of which GPU and memory, J"]
            .map(Column::figures)
            .into(),
        groups: vec![Group { title: None, rows: minutes.iter().map(row).collect() }],
        filter: false,
    }
}

fn heat(nodes: &[NodeHeat]) -> Table {
    let row = |NodeHeat { name, peak_celsius, last_celsius }: &NodeHeat| {
        vec![Cell::Words(name.clone()), Cell::number(*peak_celsius), Cell::number(*last_celsius)]
    };
    let figures = ["highest, \u{b0}C", "at the end, \u{b0}C"].map(Column::figures);
    Table {
        label: "Temperatures of the phone's parts".to_owned(),
        columns: std::iter::once(Column::words("part")).chain(figures).collect(),
        groups: vec![Group { title: None, rows: nodes.iter().map(row).collect() }],
        filter: false,
    }
}
