//! Filters and smoothers over the posterior of parameters.

use std::time::Instant;

use motes::output::{EstimateTable, Output, Report, mixture_json, report};
use motes::{
    Data, FilterOptions, FitParameters, Model, ModelNames, MotesError, PosteriorEstimates, filter_draws,
    on_threads, smooth_draws,
};
use motes_cli::{Interrupt, status};

use super::args::OutputArgs;
use super::failure::Failure;
use super::fitted_args::spread;
use super::model_args::ModelArgs;
use super::progress::Progress;
use super::say::{warn, write};
use super::summary::command_line;

/// What is asked for.
pub(super) struct MixtureRequest<'a> {
    pub(super) model: &'a Model,
    pub(super) draws: &'a FitParameters,
    pub(super) data: &'a Data,
    pub(super) options: &'a FilterOptions,
    pub(super) args: &'a ModelArgs,
    pub(super) output: &'a OutputArgs,
    /// Of a smoother, the number of its trajectories.
    pub(super) paths: Option<usize>,
}

/// Parts that progress is told in.
const PARTS: usize = 10_000;

/// Filters, or smooths, at draws of the posterior, and writes what they say.
pub(super) fn run(asked: &MixtureRequest<'_>, interrupt: &Interrupt) -> Result<u8, Failure> {
    let models = spread(asked.draws, asked.model)?;
    let start = Instant::now();
    let mixed = mixed(asked, &models, interrupt)?;
    let seconds = start.elapsed().as_secs_f64();
    if let Some(output) = asked.output.table() {
        let (names, columns) = (ModelNames::from(asked.model), &asked.data.columns);
        let table = match asked.paths {
            None => {
                let (options, has_forecasts) = (asked.options, asked.options.has_forecasts());
                EstimateTable::of_filter(
                    &names,
                    columns,
                    &options.quantiles,
                    options.predictive,
                    has_forecasts,
                )
            }
            Some(_) => EstimateTable::new(&names, columns, &asked.options.quantiles),
        };
        write(&output, &table.of_posterior(asked.data, &mixed))?;
    }
    if let Some(path) = &asked.output.report {
        write(&Output::File(path.clone()), &page(asked, &mixed)?)?;
    }
    if asked.output.json {
        write(&Output::Standard, &mixture_json(&mixed, asked.options, seconds))?;
    }
    if !asked.args.quiet {
        let draws = mixed.draws;
        status(&format!(
            "motes: averaged over {draws} draws of the posterior, {} particles each",
            asked.options.particles
        ));
    }
    Ok(warn(&mixed.warnings, asked.args.quiet, asked.output.strict))
}

fn mixed(
    asked: &MixtureRequest<'_>,
    models: &[Model],
    interrupt: &Interrupt,
) -> Result<PosteriorEstimates, MotesError> {
    let MixtureRequest { data, options, args, .. } = asked;
    let rows = data.rows.len() * models.len();
    let progress = Progress::new(PARTS, args.quiet);
    let mixed = match asked.paths {
        None => on_threads(args.threads, || {
            filter_draws(models, data, options, &|done| {
                progress.done(PARTS * done / rows);
                interrupt.check()
            })
        }),
        Some(paths) => on_threads(args.threads, || {
            smooth_draws(models, data, options, paths, |share| {
                progress.done((share * PARTS as f64) as usize);
                interrupt.check()
            })
        }),
    };
    progress.finish();
    mixed?
}

fn page(asked: &MixtureRequest<'_>, mixed: &PosteriorEstimates) -> Result<String, MotesError> {
    let warnings: Vec<String> = mixed.warnings.iter().map(ToString::to_string).collect();
    let title =
        if asked.paths.is_some() { "Smoother over the posterior" } else { "Filter over the posterior" };
    let settings = [
        ("model".to_string(), asked.args.model.display().to_string()),
        ("draws of the posterior".into(), mixed.draws.to_string()),
        ("proposal".into(), asked.options.proposal.to_string()),
        ("particles".into(), asked.options.particles.to_string()),
        ("seed".into(), asked.options.seed.to_string()),
    ];
    report(&Report {
        title,
        names: &ModelNames::from(asked.model),
        data: asked.data,
        estimates: &mixed.estimates,
        quantiles: &asked.options.quantiles,
        forecasts: &mixed.forecasts,
        summary: &[("times".to_string(), asked.data.rows.len().to_string())],
        settings: &settings,
        warnings: &warnings,
        command: &command_line(),
    })
    .map_err(|error| MotesError::Report(error.to_string()))
}
