//! What each pass moves for each kind of buffer, through each level.

use super::markup::{Cell, Column, Escaped, Group, Table, bar, series_class};
use crate::counters::Value;
use crate::report::{Buffer, Report, Traffic};
use crate::units;

/// A place that bytes go through, and how many a row of traffic sends there.
struct Level {
    name: String,
    /// What its bytes are, where it is a cache.
    about: &'static str,
    bytes: Box<dyn Fn(&Traffic) -> u64>,
}

pub(super) fn write(report: &Report) -> String {
    if report.traffic.is_empty() {
        return String::new();
    }
    let levels = levels(&report.traffic);
    let buffers = distinct(report.traffic.iter().map(|row| row.buffer.as_str()));
    let passes = distinct(report.traffic.iter().map(|row| row.pass.as_str()));
    let seconds = report.counters.get("frame_time_ms").and_then(|counter| counter.value.as_f64());
    let mut out = String::from(
        "<p>Bars of one level share a scale; levels do not. A cache is charged for the whole lines that are asked of it.</p>\n",
    );
    out += &legend(&buffers);
    out += "<div class=\"beside\"><div>\n";
    for level in &levels {
        out += &panel(level, &report.traffic, (&passes, &buffers), seconds.map(|ms| ms * 1e-3));
    }
    out += &format!("</div>\n<div>{}</div></div>\n", table(&report.traffic, &levels, &buffers));
    out
}

/// Caches from the cores to memory, then memory.
fn levels(traffic: &[Traffic]) -> Vec<Level> {
    // Rows name the caches of their own path only, each in the order of the GPU's description.
    let mut names: Vec<&str> = Vec::new();
    for row in traffic {
        let mut place = 0;
        for level in &row.levels {
            match names.iter().position(|name| *name == level.name) {
                Some(known) => place = known + 1,
                None => {
                    names.insert(place, &level.name);
                    place += 1;
                }
            }
        }
    }
    let cache = |name: &str| {
        let name = name.to_owned();
        let shown = name.clone();
        let bytes = move |row: &Traffic| {
            row.levels.iter().find(|level| level.name == name).map_or(0, |level| level.bytes)
        };
        Level { name: shown, about: " asked of it", bytes: Box::new(bytes) }
    };
    let memory = [
        Level { name: "DRAM read".to_owned(), about: "", bytes: Box::new(|row| row.dram_read_bytes) },
        Level { name: "DRAM write".to_owned(), about: "", bytes: Box::new(|row| row.dram_write_bytes) },
    ];
    names.into_iter().map(cache).chain(memory).collect()
}

fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    names.fold(Vec::new(), |mut known, name| {
        if !known.contains(&name) {
            known.push(name);
        }
        known
    })
}

fn legend(buffers: &[&str]) -> String {
    let entry = |(series, name): (usize, &&str)| {
        format!("<li><i class=\"key {}\"></i>{}</li>", series_class(series), Escaped(name))
    };
    format!("<ul class=\"legend\">{}</ul>\n", buffers.iter().enumerate().map(entry).collect::<String>())
}

fn shown(bytes: u64) -> String {
    let (number, unit) = units::scaled(&Value::Count(bytes), "B").expect("a count is a figure");
    format!("{number} {unit}")
}

/// A level: a bar for each pass.
fn panel(
    Level { name, about, bytes }: &Level,
    traffic: &[Traffic],
    (passes, buffers): (&[&str], &[&str]),
    seconds: Option<f64>,
) -> String {
    let of_pass = |pass: &str| traffic.iter().filter(|row| row.pass == pass).map(bytes).sum::<u64>();
    let all: u64 = traffic.iter().map(bytes).sum();
    let most = passes.iter().map(|pass| of_pass(pass)).max().unwrap_or(0);
    if most == 0 {
        return String::new();
    }
    let rate = seconds.filter(|seconds| *seconds > 0.0).map(|seconds| {
        let (size, unit) = units::scale("B/s", all as f64 / seconds);
        format!(", {} {unit}", units::digits(all as f64 / seconds / size))
    });
    let mut out = format!(
        "<div class=\"level\"><h3>{} <small>{}{about}{}</small></h3>\n",
        Escaped(name),
        shown(all),
        rate.unwrap_or_default()
    );
    for pass in passes.iter().filter(|pass| of_pass(pass) > 0) {
        let part = |(series, buffer): (usize, &&str)| {
            let rows = traffic.iter().filter(|row| row.pass == *pass && row.buffer == **buffer);
            let of_buffer: u64 = rows.map(bytes).sum();
            let sentence = format!("{pass}, {buffer}: {}", shown(of_buffer));
            (of_buffer > 0).then(|| (series, sentence, of_buffer as f64 / most as f64))
        };
        let parts: Vec<_> = buffers.iter().enumerate().filter_map(part).collect();
        let total = shown(of_pass(pass));
        let bar = bar(&format!("{pass}: {total} in {name}"), &parts);
        out += &format!(
            "<div class=\"row\"><span>{}</span>{bar}<span class=\"n\">{total}</span></div>\n",
            Escaped(pass)
        );
    }
    out + "</div>\n"
}

fn table(traffic: &[Traffic], levels: &[Level], buffers: &[&str]) -> String {
    let series = |buffer: &str| buffers.iter().position(|name| *name == buffer).unwrap_or_default();
    let row = |row: &Traffic| {
        let names = [Cell::name(&row.buffer, series(&row.buffer)), Cell::Words(row.pass.clone())];
        let bytes = levels.iter().map(|level| match (level.bytes)(row) {
            0 => Cell::Absent("nothing moves here".to_owned()),
            bytes => Cell::bytes(bytes),
        });
        names.into_iter().chain(bytes).collect()
    };
    let columns = [Column::words("buffer"), Column::words("pass")];
    let table = Table {
        label: "Bytes by pass, buffer and level".to_owned(),
        columns: columns.into_iter().chain(levels.iter().map(|level| Column::figures(&level.name))).collect(),
        groups: vec![Group { title: None, rows: traffic.iter().map(row).collect() }],
        filter: true,
    };
    table.to_string()
}

/// What the buffers of each kind take and move.
pub(super) fn buffers(buffers: &[Buffer]) -> String {
    if buffers.is_empty() {
        return String::new();
    }
    let row =
        |Buffer { name, bytes, line_accesses, line_misses, dram_read_bytes, dram_write_bytes }: &Buffer| {
            vec![
                Cell::Words(name.clone()),
                Cell::bytes(*bytes),
                Cell::count(*line_accesses),
                Cell::count(*line_misses),
                Cell::bytes(*dram_read_bytes),
                Cell::bytes(*dram_write_bytes),
            ]
        };
    let figures = ["size", "lines touched", "lines missed", "read from DRAM", "written to DRAM"];
    let table = Table {
        label: "What each kind of buffer takes and moves".to_owned(),
        columns: std::iter::once(Column::words("buffer")).chain(figures.map(Column::figures)).collect(),
        groups: vec![Group { title: None, rows: buffers.iter().map(row).collect() }],
        filter: false,
    };
    table.to_string()
}
