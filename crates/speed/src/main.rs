//! `motes-speed`: how fast filters and training are, measured alone or in turns with other libraries on equal work.
//!
//! Every contestant is a process of its own that takes tasks and answers on its pipes (`motes-speed serve` is ours), so that all
//! are driven, timed and weighed alike.

mod args;
mod draws;
mod drive;
mod equal;
mod error;
mod folder;
mod learned;
mod measure;
mod operations;
mod peak;
mod report;
mod serve;
mod small;
mod task;
mod work;
mod worker;
mod workloads;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use motes_cli::{Interrupt, Parsed, parse, result, status};

use args::MeasureArgs;
use error::SpeedError;

/// Times filters and training.
#[derive(Parser)]
#[command(name = "motes-speed", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Time filters and training, alone or in turns with other libraries, and write the tables
    Measure(MeasureArgs),
    /// Take pieces of work on standard input and answer on standard output; what `measure` starts
    #[command(hide = true)]
    Serve,
    /// Do one small fixed piece of work, for its instructions to be counted
    #[command(hide = true)]
    Work {
        /// Which one
        name: String,
    },
    /// Hold the instructions that small pieces of work take against committed numbers
    Instructions {
        /// Write the numbers instead of comparing
        #[arg(long)]
        update: bool,
        /// The file with the expected numbers
        #[arg(long, default_value = "experiments/expected/instructions.toml")]
        expected: PathBuf,
    },
}

fn main() -> ExitCode {
    let cli = match parse::<Cli>(std::env::args_os()) {
        Ok(Parsed::Args(cli)) => cli,
        Ok(Parsed::Help(text)) => {
            result(text.trim_end());
            return ExitCode::SUCCESS;
        }
        Err(error) => return stop(&error, 2),
    };
    let interrupt = match Interrupt::on_signals() {
        Ok(interrupt) => interrupt,
        Err(error) => return stop(&format!("signal handlers: {error}"), 3),
    };
    let fine = match cli.command {
        Command::Measure(args) => measure::measure(&args, &interrupt).map(|table| {
            result(table.trim_end());
            result(&format!("written to {}", args.out.join("speed.md").display()));
            true
        }),
        Command::Serve => {
            serve::serve();
            Ok(true)
        }
        Command::Work { name } => small::small_work(&name).map(|()| true),
        Command::Instructions { update, expected } => small::count_instructions(&expected, update),
    };
    match fine {
        Ok(fine) => ExitCode::from(u8::from(!fine)),
        Err(SpeedError::Interrupted) => stop(&SpeedError::Interrupted, interrupt.exit_status()),
        Err(error @ SpeedError::Only { .. }) => stop(&error, 2),
        Err(error) => stop(&error, 3),
    }
}

/// One line that says why, and the exit status.
fn stop(reason: &impl std::fmt::Display, exit_status: u8) -> ExitCode {
    status(&format!("error: {reason}"));
    ExitCode::from(exit_status)
}
