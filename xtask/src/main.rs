//! `cargo xtask …`: checks its input, builds, and hands over to the program that does the work.

mod ci;
mod process;

// The very file that the runner uses, not a crate: linking the runner would link a network library into this tool.
#[path = "../../crates/bench/src/config/mod.rs"]
#[allow(dead_code, unused_imports, reason = "the runner uses the rest")]
mod config;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use config::{ConfigError, Parsed, ReproduceArgs, check_output, parse, plans};

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
    /// Everything that has to hold before a change lands: format, lints, tests, docs, regression run
    Ci {
        /// Write the regression run's numbers anew instead of comparing with them, after the other checks
        #[arg(long)]
        update_expectations: bool,
    },
}

fn main() -> ExitCode {
    let cli = match parse::<Cli>(Cli::command(), std::env::args()) {
        Ok(Parsed::Args(cli)) => cli,
        Ok(Parsed::Help(text)) => {
            print!("{text}");
            return ExitCode::SUCCESS;
        }
        Err(error) => return refuse(&error),
    };
    match cli.command {
        Command::Reproduce(args) => reproduce(*args),
        Command::Ci { update_expectations } => ci::check(&root(), update_expectations),
    }
}

/// The workspace's folder.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new(".")).to_path_buf()
}

fn refuse(error: &ConfigError) -> ExitCode {
    eprintln!("error: {error}");
    ExitCode::from(error.exit_status())
}

/// Refuses what it can see to be wrong, then builds the runner in release mode and becomes it.
fn reproduce(mut args: ReproduceArgs) -> ExitCode {
    // Like cargo, work on the workspace from whatever folder of it the command is given in.
    args.experiments.get_or_insert_with(|| root().join("experiments"));
    args.out.get_or_insert_with(|| root().join("runs"));
    let plans = match plans(&args) {
        Ok(plans) => plans,
        Err(error) => return refuse(&error),
    };
    if let Some(error) = plans.iter().find_map(|plan| check_output(&plan.folder).err()) {
        return refuse(&error);
    }
    let program = process::target_folder(&root()).join("release").join("motes-bench");
    if !program.exists() {
        eprintln!(
            "building the runner in release mode; the first build takes about ten minutes on two cores"
        );
    }
    let build = ["build", "--release", "--package", "motes-bench"];
    if let Err(status) = process::cargo(&root(), &build, &[]) {
        return status;
    }
    let given = std::env::args().skip(1);
    let folders =
        [("--experiments", args.experiments.unwrap_or_default()), ("--out", args.out.unwrap_or_default())];
    let mut arguments: Vec<std::ffi::OsString> = given.map(Into::into).collect();
    for (option, folder) in folders {
        let there = |argument: &std::ffi::OsString| {
            argument.to_str().is_some_and(|text| text == option || text.starts_with(&format!("{option}=")))
        };
        if !arguments.iter().any(there) {
            arguments.extend([option.into(), folder.into_os_string()]);
        }
    }
    process::become_program(&program, &arguments)
}
