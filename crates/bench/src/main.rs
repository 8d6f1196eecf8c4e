//! `motes-bench`: what `cargo xtask` runs once it is built.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use motes_bench::config::{
    Backend, BenchArgs, ConfigError, Parsed, Plan, ReproduceArgs, VerifyArgs, check_output, parse, plans,
};
use motes_bench::say::{news, result};
use motes_bench::speed::{SpeedError, count_instructions, measure, serve, small_work};
use motes_bench::{
    Estimator, Finished, Interrupt, RegressionError, paper_estimate, regress, reproduce, verify,
};

/// Reproduces the figures and tables of the paper.
#[derive(Parser)]
#[command(name = "motes-bench", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a figure, or what of it is missing, and write its tables and figure
    Reproduce(Box<ReproduceArgs>),
    /// Hold the paper's claims against finished runs
    Verify(VerifyArgs),
    /// Time filters and training, alone or in turns with other libraries
    Bench(BenchArgs),
    /// Take pieces of work on standard input and answer on standard output; what `bench` starts
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
        /// The folder with the experiment files; expectations lie in its subfolder expected
        #[arg(long, default_value = "experiments")]
        experiments: PathBuf,
    },
    /// Hold a figure's smoke profile, on every backend, against committed numbers
    Regress {
        /// The figure
        figure: String,
        /// Write the numbers instead of comparing
        #[arg(long)]
        update: bool,
        /// The folder with the experiment files; expectations lie in its subfolder expected
        #[arg(long, default_value = "experiments")]
        experiments: PathBuf,
        /// Where the runs go
        #[arg(long, default_value = "runs/regression")]
        out: PathBuf,
    },
}

fn main() -> ExitCode {
    let command = <Cli as clap::CommandFactory>::command();
    let cli = match parse::<Cli>(command, std::env::args_os()) {
        Ok(Parsed::Args(cli)) => cli,
        Ok(Parsed::Help(text)) => {
            result(text.trim_end());
            return ExitCode::SUCCESS;
        }
        Err(error) => return refuse(&error),
    };
    let interrupt = match Interrupt::on_signals() {
        Ok(interrupt) => interrupt,
        Err(error) => {
            news(&format!("error: signal handlers: {error}"));
            return ExitCode::from(3);
        }
    };
    match cli.command {
        Command::Reproduce(args) => run_reproduce(&args, &interrupt),
        Command::Verify(args) => run_verify(&args),
        Command::Bench(args) => run_bench(&args, &interrupt),
        Command::Serve => {
            serve();
            ExitCode::SUCCESS
        }
        Command::Work { name } => speed_status(small_work(&name).map(|()| true), &interrupt),
        Command::Instructions { update, experiments } => {
            let expectation = experiments.join("expected/instructions.toml");
            speed_status(count_instructions(&expectation, update), &interrupt)
        }
        Command::Regress { figure, update, experiments, out } => {
            run_regress(figure, update, experiments, out, &interrupt)
        }
    }
}

fn refuse(error: &ConfigError) -> ExitCode {
    news(&format!("error: {error}"));
    ExitCode::from(error.exit_status())
}

fn run_reproduce(args: &ReproduceArgs, interrupt: &Interrupt) -> ExitCode {
    let plans = match plans(args) {
        Ok(plans) => plans,
        Err(error) => return refuse(&error),
    };
    if let Some(error) = plans.iter().find_map(|plan| check_output(&plan.folder).err()) {
        return refuse(&error);
    }
    let (mut status, mut tried_out, estimator) = (0, Vec::new(), Estimator::default());
    for plan in &plans {
        match reproduce(plan, &estimator, interrupt) {
            Ok(Finished::Complete { ran, failed }) => {
                status = status.max(u8::from(failed > 0));
                if ran > 0 && plan.profile_name == "quick" {
                    tried_out.push(plan);
                }
            }
            Ok(Finished::Interrupted) => return ExitCode::from(interrupt.exit_status()),
            Err(error) => {
                news(&format!("error: {error}"));
                return ExitCode::from(3);
            }
        }
    }
    for plan in tried_out {
        offer_paper_profile(plan, &estimator, interrupt);
    }
    ExitCode::from(status)
}

/// What to type for the protocol to the letter, and how long it would take here.
fn offer_paper_profile(plan: &Plan, estimator: &Estimator, interrupt: &Interrupt) {
    if let Some(estimate) = paper_estimate(plan, estimator, interrupt) {
        let figure = &plan.figure;
        result(&format!(
            "the whole protocol (about {estimate} here): cargo xtask reproduce {figure} --profile paper"
        ));
    }
}

fn run_verify(args: &VerifyArgs) -> ExitCode {
    let from = match args.from() {
        Ok(from) => from,
        Err(error) => return refuse(&error),
    };
    match verify(&from, &args.experiments()) {
        Ok(text) => {
            result(text.trim_end());
            result(&format!("written to {}", from.join("verdict.md").display()));
            ExitCode::SUCCESS
        }
        Err(error) => {
            news(&format!("error: {error}"));
            ExitCode::from(error.exit_status())
        }
    }
}

fn run_bench(args: &BenchArgs, interrupt: &Interrupt) -> ExitCode {
    let measured = measure(args, interrupt).map(|table| {
        result(table.trim_end());
        result(&format!("written to {}", args.out().join("speed.md").display()));
        true
    });
    speed_status(measured, interrupt)
}

/// The status for whether all was as it should be.
fn speed_status(fine: Result<bool, SpeedError>, interrupt: &Interrupt) -> ExitCode {
    match fine {
        Ok(fine) => ExitCode::from(u8::from(!fine)),
        Err(error) => {
            news(&format!("error: {error}"));
            ExitCode::from(match error {
                SpeedError::Interrupted => interrupt.exit_status(),
                SpeedError::System { .. } | SpeedError::Worker { .. } | SpeedError::Prepare(_) => 3,
            })
        }
    }
}

fn run_regress(
    figure: String,
    update: bool,
    experiments: PathBuf,
    out: PathBuf,
    interrupt: &Interrupt,
) -> ExitCode {
    let expected = experiments.join("expected");
    let args = ReproduceArgs {
        figure,
        profile: "smoke".into(),
        methods: vec![],
        panels: vec![],
        repetitions: None,
        jobs: None,
        backend: Backend::ALL[0].name().into(),
        seed: "1".into(),
        out: Some(out.clone()),
        fresh: true,
        save_models: false,
        experiments: Some(experiments),
    };
    let plans = match plans(&args) {
        Ok(plans) => plans,
        Err(error) => return refuse(&error),
    };
    for plan in &plans {
        let expectation = expected.join(format!("{}-smoke.csv", plan.figure));
        if let Err(error) = regress(plan, &expectation, &out, update, interrupt) {
            news(&format!("error: {error}"));
            return ExitCode::from(match error {
                RegressionError::Differs { .. } | RegressionError::Failed { .. } => 1,
                RegressionError::Interrupted => interrupt.exit_status(),
                RegressionError::Store(_) | RegressionError::File { .. } => 3,
            });
        }
    }
    ExitCode::SUCCESS
}
