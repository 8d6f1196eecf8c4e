//! `cargo xtask …`: checks its input, builds, and hands over to the program that does the work.

mod ci;
mod process;

// The very file that the runner uses, not a crate: linking the runner would link a network library into this tool.
#[path = "../../crates/bench/src/config/mod.rs"]
#[allow(dead_code, unused_imports, reason = "the runner uses the rest")]
mod config;

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use config::{BenchArgs, ConfigError, Parsed, ReproduceArgs, VerifyArgs, check_output, parse, plans};

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
    Reproduce(Box<ReproduceArgs>),
    /// Hold the paper's claims against finished runs: reproduced, not reproduced or not run
    Verify(VerifyArgs),
    /// Time filters and training, alone or in turns with other libraries, and write the tables
    Bench(BenchArgs),
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

fn main() -> ExitCode {
    let cli = match parse::<Cli>(Cli::command(), std::env::args_os()) {
        Ok(Parsed::Args(cli)) => cli,
        Ok(Parsed::Help(text)) => {
            let _ = std::io::stdout().write_all(text.as_bytes());
            return ExitCode::SUCCESS;
        }
        Err(error) => return refuse(&error),
    };
    match cli.command {
        Command::Reproduce(args) => reproduce(*args),
        Command::Verify(args) => verify(args),
        Command::Bench(args) => bench(args),
        Command::Ci { thorough, update_expectations } => ci::check(&root(), thorough, update_expectations),
    }
}

/// The workspace's folder: of the checkout that cargo runs this for, which is not always the one that it was compiled in, where two of
/// them share a target folder.
fn root() -> PathBuf {
    let here = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    Path::new(&here).parent().unwrap_or(Path::new(".")).to_path_buf()
}

fn refuse(error: &ConfigError) -> ExitCode {
    process::say(&format!("error: {error}"));
    ExitCode::from(error.exit_status())
}

/// Refuses what it can see to be wrong, then builds the runner in release mode and becomes it.
fn reproduce(mut args: ReproduceArgs) -> ExitCode {
    // Like cargo, work on the workspace from whatever folder of it the command is given in.
    let (experiments_given, out_given) = (args.experiments.is_some(), args.out.is_some());
    args.experiments.get_or_insert_with(|| root().join("experiments"));
    args.out.get_or_insert_with(|| root().join("runs"));
    let plans = match plans(&args) {
        Ok(plans) => plans,
        Err(error) => return refuse(&error),
    };
    if let Some(error) = plans.iter().find_map(|plan| check_output(&plan.folder).err()) {
        return refuse(&error);
    }
    hand_over(
        "reproduce",
        [("--experiments", experiments_given, args.experiments), ("--out", out_given, args.out)],
    )
}

/// Refuses a folder that is not there, then builds the runner and becomes it.
fn verify(mut args: VerifyArgs) -> ExitCode {
    let (experiments_given, from_given) = (args.experiments.is_some(), args.from.is_some());
    args.experiments.get_or_insert_with(|| root().join("experiments"));
    args.from.get_or_insert_with(|| root().join("experiments/reference"));
    if let Err(error) = args.from() {
        return refuse(&error);
    }
    hand_over(
        "verify",
        [("--experiments", experiments_given, args.experiments), ("--from", from_given, args.from)],
    )
}

/// Builds the runner, which times itself.
fn bench(args: BenchArgs) -> ExitCode {
    hand_over(
        "bench",
        [
            ("--out", args.out.is_some(), Some(root().join("runs/speed"))),
            ("--peer-scripts", args.peer_scripts.is_some(), Some(root().join("crates/bench/peers"))),
        ],
    )
}

/// Builds the runner in release mode and becomes it, with the arguments as they were given, and in front of them (of a
/// possible `--`, that is) where things are if that was left open.
fn hand_over(command: &str, folders: [(&str, bool, Option<PathBuf>); 2]) -> ExitCode {
    let program = process::built("release", "motes-bench");
    if !program.exists() {
        process::say(
            "building the runner in release mode; the first build takes some minutes (seven on two cores)",
        );
    }
    let build = ["build", "--release", "--package", "motes-bench"];
    if let Err(status) = process::cargo(&root(), &build, &[]) {
        return status;
    }
    let mut arguments: Vec<OsString> = vec![command.into()];
    for (option, given, folder) in folders {
        if !given {
            arguments.extend([option.into(), folder.unwrap_or_default().into_os_string()]);
        }
    }
    arguments.extend(std::env::args_os().skip(2));
    process::become_program(&program, &arguments)
}
