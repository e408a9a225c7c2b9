//! `raybudget replay`: what a recorded frame costs on a GPU.

use super::{deliver, open_report_files};
use crate::Outcome;
use crate::args::{MissTrace, ReplayArgs};
use crate::machine::Machine;
use crate::meter::{Meter, timed};
use crate::output::OutputFile;
use crate::report::{self, Answer, Before};
use crate::sample::Plan;
use crate::settings::start_threads;
use anyhow::bail;
use cachesim::{MissTraceFormat, MissTraceWriter};
use gpumodel::{Fidelity, Maps};
use std::num::NonZeroU64;
use tracer::TraceFile;

pub(crate) fn run(args: &ReplayArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let mut machine = Machine::new(&args.machine)?;
    machine.config.keeps_misses = args.miss_trace.is_some();
    if args.miss_trace.is_some() && machine.config.fidelity != Fidelity::Timed {
        bail!("--miss-trace: the order of requests needs time event by event; add --fidelity timed");
    }
    let plan = Plan::new(&args.sample, &machine, meter)?;
    start_threads(args.run.threads)?;
    let (trace, load_s) = timed(|| TraceFile::open(&args.trace));
    let trace = trace?;
    let misses = args.miss_trace.as_deref().map(OutputFile::create).transpose()?;
    let files = open_report_files(&args.report)?;
    let before = Before { load_s, build_s: None };
    let maps = if files.is_some() { Maps::Kept } else { Maps::Dropped };
    let answer = match &plan {
        Some(plan) => report::sampled_answer(&trace, &machine, plan, maps, &before, meter)?,
        None => {
            let machines = std::slice::from_ref(&machine);
            report::trace_answers(&trace, machines, maps, &before, meter)?.remove(0)
        }
    };
    if let Some(file) = misses {
        write_misses(file, args.miss_trace_format, &answer, &machine)?;
    }
    deliver(&answer, files, args.report.format)?;
    Ok(Outcome::Done)
}

fn write_misses(
    file: OutputFile,
    format: MissTrace,
    answer: &Answer,
    machine: &Machine,
) -> anyhow::Result<()> {
    let clock_ps = NonZeroU64::new(machine.config.gpu.dram.simulated().timings()?.clock);
    let format = match format {
        MissTrace::Dramsim3 => MissTraceFormat::DramSim3 { clock_ps: clock_ps.unwrap_or(NonZeroU64::MIN) },
        MissTrace::Ramulator2 => MissTraceFormat::Ramulator2,
    };
    let misses = answer.replayed.timed.iter().flat_map(|timed| &timed.misses);
    let mut writer = MissTraceWriter::new(file, format);
    for miss in misses {
        writer.record(miss.at_ps, miss.address, miss.write)?;
    }
    writer.finish()?.finish()
}
