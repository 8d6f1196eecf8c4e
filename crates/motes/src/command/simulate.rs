//! `motes simulate`.

use motes::output::{Output, simulated_table};
use motes::{Data, MotesError, simulate, simulate_along};
use motes_cli::Interrupt;

use super::args::SimulateArgs;
use super::failure::Failure;
use super::progress::Progress;

pub(super) fn run(args: &SimulateArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read()?;
    let output = args.output.clone().map_or(Output::Standard, Output::File);
    let failed = |source| MotesError::Output { file: output.name(), source };
    output.check().map_err(failed)?;
    let inputs = args.inputs.as_ref().map(|path| Data::open_inputs(path, &model)).transpose()?;
    let count = args.series * inputs.as_ref().map_or(1, |inputs| inputs.series.len());
    let mut progress = Progress::new(count, args.model.quiet);
    let proceed = |done| {
        progress.done(done);
        interrupt.check()
    };
    let simulated = match &inputs {
        Some(inputs) => simulate_along(&model, inputs, args.series, args.model.seed, proceed),
        None => simulate(&model, args.steps.unwrap_or(1), args.series, args.model.seed, proceed),
    };
    progress.finish();
    output.write(&simulated_table(&model, &simulated?)).map_err(failed)?;
    Ok(0)
}
