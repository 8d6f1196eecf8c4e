//! `motes simulate`.

use motes::output::{Output, simulated_table};
use motes::{MotesError, simulate};
use motes_cli::Interrupt;

use super::args::SimulateArgs;
use super::failure::Failure;
use super::progress::Progress;

pub(super) fn run(args: &SimulateArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read()?;
    let output = args.output.clone().map_or(Output::Standard, Output::File);
    let failed = |source| MotesError::Output { file: output.name(), source };
    output.check().map_err(failed)?;
    let mut progress = Progress::new(args.series, args.model.quiet);
    let simulated = simulate(&model, args.steps, args.series, args.model.seed, |done| {
        progress.done(done);
        interrupt.check()
    });
    progress.finish();
    output.write(&simulated_table(&model, &simulated?)).map_err(failed)?;
    Ok(0)
}
