//! `cargo xtask …`: builds the program that does the work and becomes it.

mod ci;
mod docs;
mod process;
mod python;
mod runner;
mod slurm;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use motes_cli::{Parsed, parse, result, status};

/// Commands of the Motes workspace.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a figure, or what of it is missing, and write its tables and figure
    #[command(disable_help_flag = true)]
    Reproduce(TaskArguments),
    /// Hold the paper's claims against finished runs: reproduced, not reproduced or not run
    #[command(disable_help_flag = true)]
    Verify(TaskArguments),
    /// Time filters and training, alone or in turns with other libraries, and write the tables
    #[command(disable_help_flag = true)]
    Bench(TaskArguments),
    /// Build the Python package into a virtual environment and test it, or build its wheel
    Python(python::PythonArgs),
    /// Build the site of the pages, follow its links, and run the commands and Python code of the pages
    Docs(docs::DocsArgs),
    /// Run a sweep on a real Slurm of this machine, with faults, and hold its tables against those of a local run
    SlurmTest(slurm::SlurmArgs),
    /// Everything that has to hold before a change lands: format, lints, tests, docs, regression run
    Ci {
        /// Then also the tests that take long, properties with many more inputs, and each crate built from its package
        #[arg(long)]
        thorough: bool,
        /// Write the regression run's numbers anew instead of comparing with them, after the other checks
        #[arg(long)]
        update_expectations: bool,
    },
}

/// What the program that does the work looks at.
#[derive(Args)]
struct TaskArguments {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

fn main() -> ExitCode {
    let cli = match parse::<Cli>(std::env::args_os()) {
        Ok(Parsed::Args(cli)) => cli,
        Ok(Parsed::Help(text)) => {
            result(text.trim_end());
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            status(&format!("error: {error}"));
            return ExitCode::from(2);
        }
    };
    let root = root();
    match cli.command {
        Command::Reproduce(handed) => runner::reproduce(&root, &handed.arguments),
        Command::Verify(handed) => runner::verify(&root, &handed.arguments),
        Command::Bench(handed) => runner::measure(&root, &handed.arguments),
        Command::Python(args) => python::python(&root, &args),
        Command::Docs(args) => docs::docs(&root, &args),
        Command::SlurmTest(args) => slurm::test(&root, &args),
        Command::Ci { thorough, update_expectations } => ci::check(&root, thorough, update_expectations),
    }
}

/// The workspace's folder: of the checkout that cargo runs this for, which is not always the one that it was compiled in, where two of
/// them share a target folder.
fn root() -> PathBuf {
    let here = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    Path::new(&here).parent().unwrap_or(Path::new(".")).to_path_buf()
}
