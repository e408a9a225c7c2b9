//! `raybudget whatif`: what a recorded frame would cost if one thing were different.

use super::compare::print;
use crate::Outcome;
use crate::args::{MachineArgs, WhatifArgs};
use crate::console;
use crate::machine::Machine;
use crate::meter::{Meter, timed};
use crate::output::OutputFolder;
use crate::report::{self, Before, Sample, SampledVariant};
use crate::sample::Plan;
use crate::settings::start_threads;
use crate::vary::{Axis, Variation};
use anyhow::bail;
use gpumodel::{Launch, Maps};
use reports::comparison::{self, Comparison, Variant};
use reports::{Report, html};
use std::collections::BTreeMap;
use tracer::{NodeFetch, TileSource, TraceFile, TraceHeader};

/// What rays are binned in: every reflection ray is traced, from a list as they arrive.
const LISTED: &str = "reflections-direct";
/// How the unchanged frame is called, and how that of the rays to bin.
const UNCHANGED: &str = "unchanged";
const UNBINNED: &str = "reflections as they arrive";

pub(crate) fn run(args: &WhatifArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let asked = changes(args)?;
    let mut unchanged = MachineArgs {
        gpu: args.base.clone(),
        costs: args.costs.clone(),
        energy: args.energy.clone(),
        ..MachineArgs::default()
    };
    if !args.binning.is_empty() {
        unchanged.technique = Some(LISTED.to_owned());
        unchanged.reflections.launch = Some(Launch::Buffer.name().to_owned());
    }
    let baseline = Machine::of_whole_frames(&unchanged)?;
    let plan = Plan::new(&args.sample, &baseline, meter)?;
    if plan.is_some() && !args.binning.is_empty() {
        bail!(
            "--binning: it sorts all reflection rays of the frame; leave out --sample, --within and --time-limit"
        );
    }
    start_threads(args.run.threads)?;
    let (trace, load_s) = timed(|| TraceFile::open(&args.trace));
    let trace = trace?;
    let folder = args.out.as_deref().map(OutputFolder::create).transpose()?;
    if let Some(folder) = &folder {
        folder.check(&["whatif.html", "whatif.md", "whatif.csv", "whatif.json"])?;
    }

    let mut changes = if asked.is_empty() { every_change(trace.header())? } else { asked };
    if plan.is_some() && args.technique.is_empty() {
        // The others are sampled; the user can ask for these.
        leave_out_unsampled(&mut changes)?;
    }
    let unchanged_label = if args.binning.is_empty() { UNCHANGED } else { UNBINNED };
    let mut labels = vec![unchanged_label.to_owned()];
    let mut machines = vec![baseline];
    for variation in &changes {
        for point in Variation::points(std::slice::from_ref(variation), &Default::default(), &unchanged)? {
            labels.push(format!("{} {}", variation.axis.name(), point.values.join(" ")));
            machines.push(Machine::of_whole_frames(&point.machine)?);
        }
    }
    let before = Before { load_s, build_s: None };
    let mut remarks = Vec::new();
    let frames = frames(&trace, &machines, plan.as_ref(), &mut remarks, (&before, meter))?;
    let variant = |(label, (report, ratios_ci95))| Variant { values: vec![label], report, ratios_ci95 };
    let mut variants: Vec<Variant> = labels.into_iter().zip(frames).map(variant).collect();
    let time = |variant: &Variant| {
        let time = variant.report.counters.get("frame_time_ms").and_then(|time| time.value.as_f64());
        time.unwrap_or(f64::INFINITY)
    };
    // The unchanged frame leads; the changes follow, the best first.
    variants[1..].sort_by(|a, b| time(a).total_cmp(&time(b)));
    let mut comparison = Comparison {
        title: trace.header().scene.clone(),
        axes: vec!["change".to_owned()],
        variants,
        remarks,
    };
    if !args.binning.is_empty() {
        let of_bins = |variant: &&Variant| variant.values[0].starts_with("binning ");
        let binned = comparison.variants.iter().filter(of_bins);
        comparison.remarks = binned.filter_map(|variant| comparison.gross_and_net(variant)).collect();
    }
    if let Some(folder) = folder {
        folder.write_all(&[
            ("whatif.html".to_owned(), html::comparison(&comparison, &[]).into()),
            ("whatif.md".to_owned(), comparison::markdown::write(&comparison).into()),
            ("whatif.csv".to_owned(), comparison::csv_table::write(&comparison).into()),
            ("whatif.json".to_owned(), comparison::json::write(&comparison).into()),
        ])?;
    }
    print(&comparison, args.format)?;
    Ok(Outcome::Done)
}

/// A report, and intervals of the ratios of its counters to the first one's.
type Framed = (Report, BTreeMap<String, [f64; 2]>);

/// The frames of the machines, sampled where that was asked for and is of use.
fn frames(
    trace: &TraceFile,
    machines: &[Machine],
    plan: Option<&Plan>,
    remarks: &mut Vec<String>,
    (before, meter): (&Before, &Meter),
) -> anyhow::Result<Vec<Framed>> {
    if let Some(plan) = plan {
        match report::sample(trace, machines, plan, before, meter)? {
            Sample::Variants(variants) => {
                let framed = |variant: SampledVariant| (variant.answer.report, variant.ratios_ci95);
                return Ok(variants.into_iter().map(framed).collect());
            }
            Sample::Whole(reason) => remarks.push(report::every_tile(&reason)),
        }
    }
    let answers = report::trace_answers(trace, machines, Maps::Dropped, before, meter)?;
    Ok(answers.into_iter().map(|answer| (answer.report, BTreeMap::new())).collect())
}

/// Takes out techniques of which no sample can be.
fn leave_out_unsampled(changes: &mut Vec<Variation>) -> anyhow::Result<()> {
    for Variation { values, .. } in changes.iter_mut().filter(|change| change.axis == Axis::Technique) {
        let mut left = Vec::new();
        for name in std::mem::take(values) {
            let machine = MachineArgs { technique: Some(name.clone()), ..MachineArgs::default() };
            match gpumodel::unsampled(&Machine::new(&machine)?.config.technique) {
                Some(reason) => console::warn(&format!("left out technique {name}: {reason}")),
                None => left.push(name),
            }
        }
        *values = left;
    }
    changes.retain(|change| !change.values.is_empty());
    Ok(())
}

/// The changes that were asked for.
fn changes(args: &WhatifArgs) -> anyhow::Result<Vec<Variation>> {
    let lists = [
        (Axis::Gpu, &args.gpu),
        (Axis::Technique, &args.technique),
        (Axis::Layout, &args.layout),
        (Axis::PrimitiveOrder, &args.primitive_order),
        (Axis::NodeRecords, &args.node_records),
        (Axis::NodeOrder, &args.node_order),
        (Axis::Binning, &args.binning),
    ];
    let given = lists.into_iter().filter(|(_, values)| !values.is_empty());
    let lists = given.map(|(axis, values)| {
        let shown = format!("--{} {}", axis.name(), values.join(","));
        Variation::distinct(axis, values.clone(), &shown)
    });
    lists.chain(args.set.iter().map(|figure| Variation::of_figure(figure))).collect()
}

/// Every change of layout, order and technique that this trace allows, other than what it has.
fn every_change(header: &TraceHeader) -> anyhow::Result<Vec<Variation>> {
    let own_order = gpumodel::PrimitiveOrder::of(header.accel).name();
    let pairs = header.node_fetch == NodeFetch::Pair;
    let differs = |axis: &Axis, value: &str| match axis {
        Axis::Layout => value != gpumodel::PrimitiveLayout::default().name(),
        Axis::PrimitiveOrder => value != own_order,
        Axis::NodeRecords => {
            value == gpumodel::NodeRecords::Padded.name()
                || (pairs && value == gpumodel::NodeRecords::ChildBoxes.name())
        }
        Axis::NodeOrder => {
            // It parts the children of a wide node, which follow each other.
            let parts = header.node_format.is_some() && value == gpumodel::NodeOrder::VanEmdeBoas.name();
            value != gpumodel::NodeOrder::default().name() && !parts
        }
        Axis::Technique => {
            // The first is the default; those that rasterise need to know what a rasteriser draws.
            value == "compute" || (header.raster && value.starts_with("hybrid"))
        }
        _ => false,
    };
    let mut changes = Vec::new();
    for name in ["layout", "primitive-order", "node-records", "node-order", "technique"] {
        let Variation { axis, mut values } = Variation::parse(name)?;
        values.retain(|value| differs(&axis, value));
        if !values.is_empty() {
            changes.push(Variation { axis, values });
        }
    }
    if !header.raster {
        console::warn("this trace does not say what a rasteriser draws: hybrid rendering is left out");
    }
    Ok(changes)
}
