//! States at what a fit found: over the data, and predicted after them.

use std::sync::Arc;

use motes::output::{EstimateTable, Report};
use motes::{
    Data, Estimate, FilterOptions, Forecast, MaximumFit, Model, ModelNames, MotesError, PosteriorFit,
    ProposalName, Warning, check_forecasts, filter, filter_draws,
};
use motes_cli::Interrupt;

use super::fitted_args::spread;

/// What states are found of.
pub(super) struct StateRequest<'a> {
    pub(super) model: &'a Model,
    pub(super) data: &'a Data,
    pub(super) seed: u64,
    /// Rows after the data that are predicted.
    pub(super) forecast: usize,
    /// Their times and inputs, where those are given.
    pub(super) ahead: Option<Arc<Data>>,
}

/// The states over the data and after them, with the settings that they were found by.
pub(super) struct FitStates {
    estimates: Vec<Estimate>,
    forecasts: Vec<Vec<Forecast>>,
    options: FilterOptions,
    /// The table of them.
    pub(super) table: String,
    /// Why they are in doubt.
    pub(super) warnings: Vec<Warning>,
}

impl StateRequest<'_> {
    /// Those that average over draws of the posterior.
    pub(super) fn over_posterior(
        &self,
        fitted: &PosteriorFit,
        interrupt: &Interrupt,
    ) -> Result<FitStates, MotesError> {
        let models = spread(&fitted.draw_values(), self.model)?;
        let options = self.options(&fitted.proposal, fitted.particles);
        let found = filter_draws(&models, self.data, &options, &|_| interrupt.check())?;
        let table = self.table(&options).of_posterior(self.data, &found);
        Ok(FitStates::new(found.estimates, found.forecasts, options, table, found.warnings))
    }

    /// Those at the maximum of the likelihood.
    pub(super) fn at_maximum(
        &self,
        found: &MaximumFit,
        interrupt: &Interrupt,
    ) -> Result<FitStates, MotesError> {
        let estimates = found.names.iter().zip(&found.parameters);
        let values: Vec<(String, f64)> = estimates.map(|(name, of)| (name.clone(), of.estimate)).collect();
        let model = self.model.with_parameters(&values)?;
        let options = self.options(&found.proposal, found.particles);
        let filtered = filter(&model, self.data, &options, |_| interrupt.check())?;
        let table = self.table(&options).filtered(self.data, &filtered);
        Ok(FitStates::new(filtered.estimates, filtered.forecasts, options, table, filtered.warnings))
    }

    /// Refuses forecasts that need what is not known, before the fit.
    pub(super) fn check(&self) -> Result<(), MotesError> {
        check_forecasts(self.model, self.data, &self.options("bootstrap", 1))
    }

    /// The same without what is predicted.
    pub(super) fn without_forecasts(&self) -> StateRequest<'_> {
        StateRequest { forecast: 0, ahead: None, ..*self }
    }

    /// A filter like the estimator of the likelihood, where that goes row by row.
    fn options(&self, proposal: &str, particles: usize) -> FilterOptions {
        let defaults = FilterOptions::default();
        FilterOptions {
            // One that looks ahead is none, and one that was learned is not known by its name.
            proposal: match proposal.parse() {
                Ok(ProposalName::LookAhead) | Err(_) => ProposalName::Bootstrap,
                Ok(proposal) => proposal,
            },
            particles: particles.max(defaults.particles),
            predictive: true,
            forecast: self.forecast,
            ahead: self.ahead.clone(),
            seed: self.seed,
            ..defaults
        }
    }

    fn table(&self, options: &FilterOptions) -> EstimateTable {
        let FilterOptions { quantiles, predictive, .. } = options;
        let (names, columns) = (ModelNames::from(self.model), &self.data.columns);
        EstimateTable::of_filter(&names, columns, quantiles, *predictive, options.has_forecasts())
    }
}

impl FitStates {
    fn new(
        estimates: Vec<Estimate>,
        forecasts: Vec<Vec<Forecast>>,
        options: FilterOptions,
        table: String,
        warnings: Vec<Warning>,
    ) -> Self {
        let of_states =
            |warning: Warning| Warning { text: format!("states.csv: {}", warning.text), ..warning };
        FitStates {
            estimates,
            forecasts,
            options,
            table,
            warnings: warnings.into_iter().map(of_states).collect(),
        }
    }

    /// What a page shows of them.
    pub(super) fn report<'a>(&'a self, data: &'a Data, names: &'a ModelNames) -> Report<'a> {
        Report {
            title: "",
            names,
            data,
            estimates: &self.estimates,
            quantiles: &self.options.quantiles,
            forecasts: &self.forecasts,
            summary: &[],
            settings: &[],
            warnings: &[],
            command: "",
        }
    }
}
