//! `raybudget replay`: what a recorded frame costs on a GPU.

use super::{deliver, open_report_files};
use crate::Outcome;
use crate::args::ReplayArgs;
use crate::machine::Machine;
use crate::meter::{Meter, timed};
use crate::report::{self, Before};
use crate::settings::start_threads;
use gpumodel::Maps;
use tracer::TraceFile;

pub(crate) fn run(args: &ReplayArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let machine = Machine::new(&args.machine)?;
    start_threads(args.run.threads)?;
    let (trace, load_s) = timed(|| TraceFile::open(&args.trace));
    let trace = trace?;
    let files = open_report_files(&args.report)?;
    let before = Before { load_s, build_s: None };
    let maps = if files.is_some() { Maps::Kept } else { Maps::Dropped };
    let answer = report::answer(&trace, &machine, maps, &before, meter)?;
    deliver(&answer, files, args.report.format)?;
    Ok(Outcome::Done)
}
