//! The `raybudget` command line: what a ray-traced frame costs a mobile GPU, and why.

mod alpha;
mod args;
mod commands;
mod console;
mod features;
mod figures;
mod frame;
mod machine;
mod meter;
mod options;
mod output;
mod pictures;
mod progress;
mod ray_sets;
mod reflections;
mod report;
mod sample;
mod secondary;
mod settings;
mod shading;
mod sustained;
mod sweep;
mod two_eyes;
mod two_level;
mod vary;
mod verify;

use args::{Cli, Command};
use clap::Parser;
use std::process::ExitCode;

/// How a command ended when nothing went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// It did what was asked.
    Done,
    /// A check failed: exit code 1.
    CheckFailed,
}

fn main() -> ExitCode {
    match run(Cli::parse()) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(1),
        Err(error) if error.is::<console::StdoutClosed>() => ExitCode::SUCCESS,
        Err(error) => {
            console::error(&error);
            ExitCode::from(2)
        }
    }
}

fn run(cli: Cli) -> anyhow::Result<Outcome> {
    let meter = meter::Meter::start();
    match cli.command {
        None => commands::profile::run(&args::ProfileArgs::bare(), &meter),
        Some(Command::Profile(args)) => commands::profile::run(&args, &meter),
        Some(Command::Render(args)) => commands::render::run(&args),
        Some(Command::Stereo(args)) => commands::stereo::run(&args, &meter),
        Some(Command::Trace(args)) => commands::trace::run(&args),
        Some(Command::Replay(args)) => commands::replay::run(&args, &meter),
        Some(Command::Check(args)) => commands::check::run(&args, &meter),
        Some(Command::Cache(args)) => commands::cache::run(&args, &meter),
        Some(Command::Compare(args)) => commands::compare::run(&args, &meter),
        Some(Command::Whatif(args)) => commands::whatif::run(&args, &meter),
        Some(Command::Sweep(args)) => commands::sweep::run(&args, &meter),
        Some(Command::Verify(args)) => commands::verify::run(&args, &meter),
        Some(Command::List(args)) => commands::list::run(&args),
        Some(Command::Completions { shell }) => commands::shell::completions(shell),
        Some(Command::Man { subcommand }) => commands::shell::man(subcommand.as_deref()),
    }
}
