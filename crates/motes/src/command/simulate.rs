//! `motes simulate`.

use motes::output::{Output, simulated_table};
use motes::{
    Data, MotesError, of_starts, simulate, simulate_along, simulate_from_draws, simulate_from_priors,
};
use motes_cli::Interrupt;

use super::args::SimulateArgs;
use super::failure::Failure;
use super::fitted_args::ModelAtFit;
use super::progress::Progress;
use super::say::warn;

pub(super) fn run(args: &SimulateArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let ModelAtFit { model, draws } = args.fitted.of(args.model.read()?, &args.model.set)?;
    if args.inputs.is_none()
        && let Some(column) = model.undated_column()
    {
        return Err(Failure::new(
            2,
            format!(
                "the times in the column {column} are dates, and the model says of none when it is; give those of the rows by --inputs, or that of x_0 by start = 2024-01-01 in [time]"
            ),
        ));
    }
    let output = args.output.clone().map_or(Output::Standard, Output::File);
    let failed = |source| MotesError::Output { file: output.name(), source };
    output.check().map_err(failed)?;
    let inputs = args.inputs.as_ref().map(|path| Data::open_inputs(path, &model)).transpose()?;
    let count = args.series * inputs.as_ref().map_or(1, |inputs| inputs.series.len());
    let progress = Progress::new(count, args.model.quiet);
    if !args.prior && draws.is_none() {
        warn(of_starts(&model).as_slice(), args.model.quiet, false);
    }
    let proceed = |done| {
        progress.done(done);
        interrupt.check()
    };
    let (steps, series, seed) = (args.steps.unwrap_or(1), args.series, args.model.seed);
    let simulated = match (args.prior, &inputs) {
        (false, inputs) if let Some(draws) = &draws => {
            simulate_from_draws(&model, draws, inputs.as_ref(), steps, series, seed, proceed)
        }
        (true, inputs) => simulate_from_priors(&model, inputs.as_ref(), steps, series, seed, proceed),
        (false, Some(inputs)) => simulate_along(&model, inputs, series, seed, proceed),
        (false, None) => simulate(&model, steps, series, seed, proceed),
    };
    progress.finish();
    output.write(&simulated_table(&model, &simulated?)).map_err(failed)?;
    Ok(0)
}
