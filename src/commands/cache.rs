//! `raybudget cache`: a stream of addresses through a hierarchy of caches.

use crate::Outcome;
use crate::args::{CacheArgs, CurveKind, Format};
use crate::console;
use crate::meter::{Meter, thread_cpu_s};
use crate::output::read_text;
use crate::progress::Progress;
use anyhow::anyhow;
use cachesim::{
    AddressFormat, AddressReader, Aet, Hierarchy, LevelConfig, LevelCounts, Levels, LineSize, MemoryCounts,
    MissCurve, Policy, StackDistances, WriteMiss,
};
use serde_json::{Value, json};
use std::fmt::Write;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

pub(crate) fn run(args: &CacheArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let levels_text = read_text(&args.levels, "a description of caches (.toml)")?;
    let levels = Levels::parse(&levels_text, &args.levels.display().to_string())?;
    let (mut hierarchy, path) = Hierarchy::chain(&levels)?;
    let progress = Progress::spinner("replaying the addresses");
    open(&args.addresses, hierarchy.units())?.replay(&mut hierarchy, path)?;
    let line = hierarchy.granule(path);
    let curve = match args.curve {
        Some(kind) => {
            let misses = miss_curve(open(&args.addresses, hierarchy.units())?, line, kind)?;
            let first = FirstLevel::new(&levels.as_slice()[0], hierarchy.counts(0), &misses);
            Some(Curve { kind, line, misses, first })
        }
        None => None,
    };
    drop(progress);
    let counts = Counts {
        levels: (levels.as_slice().iter().enumerate())
            .map(|(index, level)| (level.name.clone(), hierarchy.counts(index)))
            .collect(),
        memory: hierarchy.memory(),
        curve,
    };
    console::print(&match args.format {
        Format::Text => counts.text(),
        Format::Json => format!("{:#}\n", counts.json(meter)),
        Format::Csv => counts.csv()?,
    })?;
    Ok(Outcome::Done)
}

fn open(path: &Path, units: u32) -> anyhow::Result<AddressReader<BufReader<File>>> {
    let format = AddressFormat::of(path)?;
    let shown = path.display().to_string();
    let file = File::open(path).map_err(|error| {
        anyhow!("{shown}: cannot open: {error}; give a file of addresses (.din, .csv, .u64)")
    })?;
    Ok(AddressReader::new(BufReader::with_capacity(1 << 20, file), format, &shown, units))
}

fn miss_curve(
    addresses: AddressReader<BufReader<File>>,
    line: LineSize,
    kind: CurveKind,
) -> Result<MissCurve, cachesim::Error> {
    Ok(match kind {
        CurveKind::Exact => {
            let mut distances = StackDistances::new();
            addresses.for_each_line(line, |line| distances.touch(line))?;
            distances.curve()
        }
        CurveKind::Aet => {
            let mut aet = Aet::new();
            addresses.for_each_line(line, |line| aet.touch(line))?;
            aet.curve()
        }
    })
}

struct Counts {
    levels: Vec<(String, LevelCounts)>,
    memory: MemoryCounts,
    curve: Option<Curve>,
}

/// Misses of a fully associative LRU cache of every size.
struct Curve {
    kind: CurveKind,
    line: LineSize,
    misses: MissCurve,
    first: Option<FirstLevel>,
}

/// What a curve says of the first level, beside what its simulation does.
struct FirstLevel {
    name: String,
    sets: u64,
    ways: u64,
    misses: u64,
    estimated_misses: f64,
    /// Estimated less simulated miss ratio.
    error: f64,
}

impl FirstLevel {
    /// `None` where the level is not what a curve is of: one LRU cache of whole lines that keeps all it is asked for.
    fn new(config: &LevelConfig, counts: LevelCounts, curve: &MissCurve) -> Option<Self> {
        let whole = config.policy == Policy::Lru
            && config.count == 1
            && config.granule() == config.line
            && config.write_miss != WriteMiss::Around;
        whole.then(|| {
            let (sets, ways, misses) = (config.sets(), config.way_count(), counts.misses);
            let estimated_misses = curve.set_associative(sets, ways);
            let error = (estimated_misses - misses as f64) / curve.accesses() as f64;
            Self { name: config.name.clone(), sets, ways, misses, estimated_misses, error }
        })
    }
}

impl Curve {
    fn kind(&self) -> &'static str {
        match self.kind {
            CurveKind::Exact => "exact",
            CurveKind::Aet => "aet",
        }
    }

    /// Lines, bytes, misses and miss ratio of every size that misses less than the one before.
    fn points(&self) -> impl Iterator<Item = (u64, u64, u64, f64)> + '_ {
        let accesses = self.misses.accesses() as f64;
        self.misses
            .points()
            .map(move |(lines, misses)| (lines, lines * self.line.bytes(), misses, misses as f64 / accesses))
    }
}

impl Counts {
    fn json(&self, meter: &Meter) -> Value {
        let levels: Vec<Value> = self
            .levels
            .iter()
            .map(|(name, counts)| {
                let LevelCounts {
                    accesses,
                    hits,
                    misses,
                    writes,
                    write_misses,
                    sector_misses,
                    fills,
                    writebacks,
                    classes,
                } = *counts;
                let classes = classes.map(|classes| {
                    json!({"cold": classes.cold, "capacity": classes.capacity, "conflict": classes.conflict})
                });
                json!({
                    "name": name,
                    "accesses": accesses,
                    "hits": hits,
                    "misses": misses,
                    "writes": writes,
                    "write_misses": write_misses,
                    "sector_misses": sector_misses,
                    "fills": fills,
                    "writebacks": writebacks,
                    "miss_classes": classes,
                })
            })
            .collect();
        let MemoryCounts { reads, writes, read_bytes, write_bytes } = self.memory;
        let mut whole = json!({
            "levels": levels,
            "memory": {"reads": reads, "writes": writes, "read_bytes": read_bytes, "write_bytes": write_bytes},
        });
        if let Some(curve) = &self.curve {
            let points: Vec<Value> = curve
                .points()
                .map(|(lines, bytes, misses, ratio)| {
                    json!({"lines": lines, "bytes": bytes, "misses": misses, "miss_ratio": ratio})
                })
                .collect();
            let first = curve.first.as_ref().map(|first| {
                json!({
                    "name": first.name,
                    "sets": first.sets,
                    "ways": first.ways,
                    "misses": first.misses,
                    "estimated_misses": first.estimated_misses,
                    "miss_ratio_error": first.error,
                })
            });
            whole["curve"] = json!({
                "kind": curve.kind(),
                "line_bytes": curve.line.bytes(),
                "accesses": curve.misses.accesses(),
                "distinct_lines": curve.misses.cold_misses(),
                "first_level": first,
                "points": points,
            });
        }
        whole["run"] = json!({"wall_s": meter.wall_s(), "cpu_s": thread_cpu_s()});
        whole
    }

    fn text(&self) -> String {
        let mut out = format!(
            "{:<12}{:>16}{:>16}{:>16}{:>12}{:>16}\n",
            "level", "accesses", "hits", "misses", "miss ratio", "write-backs"
        );
        let mut line = |text: String| writeln!(out, "{text}").expect("a string takes every write");
        for (name, counts) in &self.levels {
            let ratio = match counts.accesses {
                0 => "-".to_owned(),
                accesses => format!("{:.3} %", counts.misses as f64 / accesses as f64 * 100.0),
            };
            line(format!(
                "{name:<12}{:>16}{:>16}{:>16}{ratio:>12}{:>16}",
                counts.accesses, counts.hits, counts.misses, counts.writebacks
            ));
        }
        let MemoryCounts { reads, writes, read_bytes, write_bytes } = self.memory;
        line(format!("memory: {reads} reads ({read_bytes} bytes), {writes} writes ({write_bytes} bytes)"));
        for (name, counts) in &self.levels {
            if let Some(classes) = counts.classes {
                line(format!(
                    "{name} misses: {} cold, {} capacity, {} conflict",
                    classes.cold, classes.capacity, classes.conflict
                ));
            }
        }
        if let Some(curve) = &self.curve {
            line(format!(
                "\nfully associative LRU ({}), lines of {} bytes: {} accesses, {} distinct lines",
                curve.kind(),
                curve.line.bytes(),
                curve.misses.accesses(),
                curve.misses.cold_misses()
            ));
            if let Some(first) = &curve.first {
                line(format!(
                    "estimate for {} ({} sets, {} ways): {:.0} misses, simulated {}, error in miss ratio {:+.3} %",
                    first.name,
                    first.sets,
                    first.ways,
                    first.estimated_misses,
                    first.misses,
                    first.error * 100.0
                ));
            }
            line(format!("{:>12}{:>16}{:>16}{:>12}", "lines", "bytes", "misses", "miss ratio"));
            for (lines, bytes, misses, ratio) in curve.points() {
                line(format!("{lines:>12}{bytes:>16}{misses:>16}{:>10.3} %", ratio * 100.0));
            }
        }
        out
    }

    /// The levels, or with a curve its points: a table has one shape.
    fn csv(&self) -> anyhow::Result<String> {
        let mut table = csv::Writer::from_writer(Vec::new());
        match &self.curve {
            Some(curve) => {
                table.write_record(["lines", "bytes", "misses", "miss_ratio"])?;
                for (lines, bytes, misses, ratio) in curve.points() {
                    table.serialize((lines, bytes, misses, ratio))?;
                }
            }
            None => {
                table.write_record([
                    "name",
                    "accesses",
                    "hits",
                    "misses",
                    "writes",
                    "write_misses",
                    "fills",
                    "writebacks",
                ])?;
                for (name, counts) in &self.levels {
                    let LevelCounts {
                        accesses, hits, misses, writes, write_misses, fills, writebacks, ..
                    } = *counts;
                    table.serialize((
                        name,
                        accesses,
                        hits,
                        misses,
                        writes,
                        write_misses,
                        fills,
                        writebacks,
                    ))?;
                }
            }
        }
        Ok(String::from_utf8(table.into_inner()?)?)
    }
}
