//! The command line: what can be asked, and what each answer is made of.

mod args;
mod check;
mod compare;
mod compare_fits;
mod evidence;
mod evidence_args;
mod failure;
mod filter;
mod filter_page;
mod fit;
mod fit_args;
mod fit_states;
mod fitted_args;
mod input;
mod kind_args;
mod learn;
mod mixture;
mod model_args;
mod numbers;
mod objective_args;
mod progress;
mod proposal_arg;
mod say;
mod share;
mod simulate;
mod smooth;
mod spinner;
mod stream;
mod summary;
mod undeclared;

use std::process::ExitCode;

use clap::CommandFactory;
use motes_cli::{Interrupt, Parsed, one_of, parse, result, status};

use args::{Cli, Command};
use failure::Failure;

/// Does what the arguments say.
pub(crate) fn run() -> ExitCode {
    let cli = match parse::<Cli>(std::env::args_os()) {
        Ok(Parsed::Args(cli)) => cli,
        Ok(Parsed::Help(text)) => {
            result(text.trim_end());
            return ExitCode::SUCCESS;
        }
        Err(error) => return refuse(&Failure::new(2, error)),
    };
    let interrupt = match Interrupt::on_signals() {
        Ok(interrupt) => interrupt,
        Err(error) => return refuse(&Failure::new(3, format!("signal handlers: {error}"))),
    };
    let done = match cli.command {
        Command::Filter(args) => filter::run(&args, &interrupt),
        Command::Check(args) => check::run(&args, &interrupt),
        Command::Compare(args) => compare::run(&args, &interrupt),
        Command::Fit(args) => fit::run(&args, &interrupt),
        Command::Learn(args) => learn::run(&args, &interrupt),
        Command::Evidence(args) => evidence::run(&args, &interrupt),
        Command::Simulate(args) => simulate::run(&args, &interrupt),
        Command::Smooth(args) => smooth::run(&args, &interrupt),
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "motes", &mut text);
            result(String::from_utf8_lossy(&text).trim_end());
            Ok(0)
        }
        Command::Man { about } => man(about.as_deref()),
    };
    match done {
        Ok(exit_status) => ExitCode::from(exit_status),
        Err(failure) if failure.is_interrupt() => {
            status(&format!("motes: {failure}"));
            ExitCode::from(interrupt.exit_status())
        }
        Err(failure) => refuse(&failure),
    }
}

fn refuse(failure: &Failure) -> ExitCode {
    status(&format!("motes: {failure}"));
    ExitCode::from(failure.exit_status())
}

/// The manual page, of one command or of all.
fn man(about: Option<&str>) -> Result<u8, Failure> {
    let mut all = Cli::command();
    all.build();
    let command = match about {
        None => all,
        Some(name) => match all.find_subcommand(name) {
            Some(command) => command.clone(),
            None => {
                let names = all.get_subcommands().map(clap::Command::get_name);
                return Err(Failure::new(2, format!("man {name}: {}", one_of(name, names))));
            }
        },
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page).map_err(|error| Failure::new(3, error))?;
    result(String::from_utf8_lossy(&page).trim_end());
    Ok(0)
}
