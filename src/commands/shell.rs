//! `raybudget completions` and `raybudget man`, made from the one definition of the command line.

use crate::Outcome;
use crate::args::Cli;
use crate::console;
use anyhow::anyhow;
use clap::CommandFactory;
use clap_complete::Shell;

pub(crate) fn completions(shell: Shell) -> anyhow::Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "raybudget", &mut script);
    console::print(&String::from_utf8(script)?)?;
    Ok(Outcome::Done)
}

pub(crate) fn man(subcommand: Option<&str>) -> anyhow::Result<Outcome> {
    let mut command = Cli::command();
    command.build();
    let command = match subcommand {
        None => command,
        Some(name) => {
            let names: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
            let refused = || anyhow!("man {name}: no such command; use one of: {}", names.join(", "));
            let page = command.find_subcommand(name).ok_or_else(refused)?;
            page.clone()
        }
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    console::print(&String::from_utf8(page)?)?;
    Ok(Outcome::Done)
}
