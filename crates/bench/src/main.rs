//! `motes-bench`: what `cargo xtask` runs once it is built.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use motes_bench::cluster::{self, ClusterError, SubmitOutcome};
use motes_bench::config::{ConfigError, Engine, Plan, ReproduceArgs, VerifyArgs, check_output, plans};
use motes_bench::{
    Estimator, RegressionError, RunOutcome, StudyError, benchmark_plans, is_benchmark, is_study,
    paper_estimate, regress, reproduce, run_benchmark, run_study, verify,
};
use motes_cli::{Interrupt, Parsed, parse, result, status};
use motes_proposals::networks::open_device;

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
    /// Do the share of a task of a job array
    #[command(hide = true)]
    Work {
        /// The folder of the submission
        submission: PathBuf,
        /// The number of the task
        task: usize,
    },
    /// Make tables, figures and verdicts after a job array
    #[command(hide = true)]
    Finish {
        /// The folder of the submission
        submission: PathBuf,
    },
    /// Leave a file, which tells that this program runs on a node and sees the folder
    #[command(hide = true)]
    Probed {
        /// The file
        file: PathBuf,
    },
}

fn main() -> ExitCode {
    let cli = match parse::<Cli>(std::env::args_os()) {
        Ok(Parsed::Args(cli)) => cli,
        Ok(Parsed::Help(text)) => {
            result(text.trim_end());
            return ExitCode::SUCCESS;
        }
        Err(error) => return refuse(&error.into()),
    };
    let interrupt = match Interrupt::on_signals() {
        Ok(interrupt) => interrupt,
        Err(error) => {
            status(&format!("error: signal handlers: {error}"));
            return ExitCode::from(3);
        }
    };
    match cli.command {
        Command::Reproduce(args) if is_benchmark(&args.figure) => run_benchmarks(&args, &interrupt),
        Command::Reproduce(args) if is_study(&args.figure) => match run_study(&args, &interrupt) {
            Ok(()) => ExitCode::SUCCESS,
            Err(StudyError::Interrupted) => {
                status("stopped; the same command goes on with what is missing");
                ExitCode::from(interrupt.exit_status())
            }
            Err(error) => {
                status(&format!("error: {error}"));
                ExitCode::from(error.exit_status())
            }
        },
        Command::Reproduce(args) if args.cluster.runs_nothing() || args.cluster.engine == Engine::Slurm => {
            run_on_cluster(&args, &interrupt)
        }
        Command::Reproduce(args) => run_reproduce(&args, &interrupt),
        Command::Verify(args) => run_verify(&args),
        Command::Regress { figure, update, experiments, out } => {
            run_regress(figure, update, experiments, out, &interrupt)
        }
        Command::Work { submission, task } => match cluster::work(&submission, task, &interrupt) {
            Ok(()) if interrupt.check().is_break() => ExitCode::from(interrupt.exit_status()),
            done => ended(done.map(|()| true), &interrupt),
        },
        Command::Finish { submission } => ended(cluster::finish(&submission), &interrupt),
        Command::Probed { file } => match std::fs::write(&file, "") {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                status(&format!("error: {}: {error}", file.display()));
                ExitCode::from(3)
            }
        },
    }
}

/// How a command for a cluster ends: with success, if all is well.
fn ended(done: Result<bool, ClusterError>, interrupt: &Interrupt) -> ExitCode {
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            status(&format!("error: {error}"));
            ExitCode::from(match error {
                ClusterError::Interrupted => interrupt.exit_status(),
                error => error.exit_status(),
            })
        }
    }
}

/// Hands what is missing to Slurm, prints its scripts, or says how far it has come or how long it would take.
fn run_on_cluster(args: &ReproduceArgs, interrupt: &Interrupt) -> ExitCode {
    match on_cluster(args, interrupt) {
        // Their tables are made here and now.
        Ok(Some(SubmitOutcome::Complete)) => run_reproduce(args, interrupt),
        done => ended(done.map(|_| true), interrupt),
    }
}

fn on_cluster(args: &ReproduceArgs, interrupt: &Interrupt) -> Result<Option<SubmitOutcome>, ClusterError> {
    args.cluster.check(args.fresh)?;
    let plans = plans(args)?;
    if args.cluster.status {
        cluster::show_status(&plans, &args.out)?;
    } else if !args.cluster.project.is_empty() {
        cluster::project(&plans, args, &Estimator::default(), interrupt)?;
    } else if args.dry_run {
        cluster::dry_run(&plans, args)?;
    } else {
        plans.iter().try_for_each(|plan| check_output(&plan.folder))?;
        return cluster::submit(&plans, args, &Estimator::default(), interrupt).map(Some);
    }
    Ok(None)
}

fn refuse(error: &ConfigError) -> ExitCode {
    status(&format!("error: {error}"));
    ExitCode::from(error.exit_status())
}

fn run_reproduce(args: &ReproduceArgs, interrupt: &Interrupt) -> ExitCode {
    let plans = match args.cluster.check(args.fresh).and_then(|()| plans(args)) {
        Ok(plans) => plans,
        Err(error) => return refuse(&error),
    };
    if !args.dry_run
        && let Err(error) = open_device(args.backend)
    {
        status(&format!("error: --backend {}: {error}", args.backend));
        return ExitCode::from(2);
    }
    if args.dry_run {
        plans.iter().for_each(|plan| result(&plan.to_string()));
        return ExitCode::SUCCESS;
    }
    if let Some(error) = plans.iter().find_map(|plan| check_output(&plan.folder).err()) {
        return refuse(&error);
    }
    let (mut exit_status, mut tried_out, estimator) = (0, Vec::new(), Estimator::default());
    for plan in &plans {
        match reproduce(plan, &estimator, interrupt) {
            Ok(RunOutcome::Complete { ran, failed }) => {
                exit_status = exit_status.max(u8::from(failed > 0));
                if ran > 0 && plan.profile_name == "quick" {
                    tried_out.push(plan);
                }
            }
            Ok(RunOutcome::Interrupted) => return ExitCode::from(interrupt.exit_status()),
            Err(error) => {
                status(&format!("error: {error}"));
                return ExitCode::from(3);
            }
        }
    }
    for plan in tried_out {
        offer_paper_profile(plan, &estimator, interrupt);
    }
    ExitCode::from(exit_status)
}

fn run_benchmarks(args: &ReproduceArgs, interrupt: &Interrupt) -> ExitCode {
    let plans = match benchmark_plans(args) {
        Ok(plans) => plans,
        Err(error) => return refuse(&error),
    };
    if args.dry_run {
        plans.iter().for_each(|plan| result(&plan.to_string()));
        return ExitCode::SUCCESS;
    }
    if let Some(error) = plans.iter().find_map(|plan| check_output(&plan.folder).err()) {
        return refuse(&error);
    }
    let mut exit_status = 0;
    for plan in &plans {
        if let Err(error) = run_benchmark(plan, interrupt) {
            if error.is_interrupted() {
                status("stopped; the same command goes on with the proposals that are learned");
                return ExitCode::from(interrupt.exit_status());
            }
            status(&format!("error: {error}"));
            exit_status = exit_status.max(error.exit_status());
        }
    }
    ExitCode::from(exit_status)
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
    let from = match args.results() {
        Ok(from) => from,
        Err(error) => return refuse(&error),
    };
    match verify(from, &args.experiments) {
        Ok(text) => {
            result(text.trim_end());
            result(&format!("written to {}", from.join("verdict.md").display()));
            ExitCode::SUCCESS
        }
        Err(error) => {
            status(&format!("error: {error}"));
            ExitCode::from(error.exit_status())
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
        profile: "smoke".into(),
        out: out.clone(),
        experiments,
        ..ReproduceArgs::of(&figure)
    };
    let plans = match plans(&args) {
        Ok(plans) => plans,
        Err(error) => return refuse(&error),
    };
    for plan in &plans {
        let expectation = expected.join(format!("{}-smoke.csv", plan.figure));
        if let Err(error) = regress(plan, &expectation, &out, update, interrupt) {
            status(&format!("error: {error}"));
            return ExitCode::from(match error {
                RegressionError::Differs { .. } | RegressionError::Failed { .. } => 1,
                RegressionError::NotBuilt(_) => 2,
                RegressionError::Interrupted => interrupt.exit_status(),
                RegressionError::Store(_) | RegressionError::File { .. } => 3,
            });
        }
    }
    ExitCode::SUCCESS
}
