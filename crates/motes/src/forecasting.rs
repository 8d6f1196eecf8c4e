//! What is predicted after the last row of a series.

use crate::continuations::Continuations;
use crate::engine::Running;
use crate::error::MotesError;
use crate::estimate::{Estimate, Forecast};
use crate::known_inputs::all_known;
use crate::model::Model;
use crate::options::ProposalName;
use crate::timeline::{Clock, RowTime};
use crate::warning::Warning;

impl Running<'_> {
    /// Predicts the next row, at which nothing is measured, a gap as the last one ahead.
    ///
    /// # Errors
    /// As [`Running::predict_row`].
    pub fn predict(&mut self) -> Result<Estimate, MotesError> {
        self.predict_row(None).map(|forecast| forecast.estimate)
    }

    /// Predicts the next row, at which nothing is measured: one with this time and these inputs, or a gap as the last one ahead.
    ///
    /// # Errors
    /// As [`Running::step_row`], and [`MotesError::Ahead`] if an input is not known then.
    pub fn predict_row(&mut self, row: Option<RowTime<'_>>) -> Result<Forecast, MotesError> {
        let mut clock = self.clock.clone();
        let forecast = self.go_on(&mut clock, row)?;
        self.clock = clock;
        self.clock.comes_back();
        Ok(forecast)
    }

    /// [`Running::predict_row`] of who has no more rows, and a clock that says where the series is. Where measurements are inputs of later steps, many continuations of the series are simulated, and
    /// the filter stays where it is.
    ///
    /// # Errors
    /// As [`Running::predict_row`], and [`MotesError::Simulation`] where a continuation runs to numbers that are not finite.
    pub fn predict_by(
        &mut self,
        clock: &mut Clock,
        row: Option<RowTime<'_>>,
    ) -> Result<Forecast, MotesError> {
        if self.time > 0
            && self.continuations.is_none()
            && let Some(particles) = self.filter.weighted()
        {
            // Another one for each series.
            let seed = self.forecast_seed.nth(self.filter.log_evidence().to_bits());
            self.continuations = Continuations::of(self.model, particles, clock, &seed);
        }
        match &mut self.continuations {
            Some(continuations) => continuations.next(self.model, row, self.asked.probabilities()),
            None => self.go_on(clock, row).map_err(|error| self.explain_ahead(error)),
        }
    }

    /// Says what would help where an exact filter has nothing that a forecast could go on from.
    fn explain_ahead(&self, error: MotesError) -> MotesError {
        match (error, self.model.fed_back_measurement()) {
            (MotesError::Ahead(_), Some(column)) if self.kind == ProposalName::Exact.kind() => {
                let reason = format!(
                    "a forecast draws the measurement {column}, an input of later steps, and an exact filter draws nothing; take --proposal bootstrap"
                );
                MotesError::Proposal { proposal: "exact".to_string(), reason }
            }
            (error, _) => error,
        }
    }

    /// Takes the filter to a row at which nothing is measured.
    fn go_on(&mut self, clock: &mut Clock, row: Option<RowTime<'_>>) -> Result<Forecast, MotesError> {
        let steps = self.model.steps_ahead(clock, row).map_err(|error| MotesError::Ahead(Box::new(error)))?;
        // What a measurement needs and nobody knows is no number there; states do without it.
        let known = all_known(&steps);
        let nothing = vec![None; self.model.measurements().len()];
        let is_predictive = std::mem::take(&mut self.is_predictive);
        let estimate = self.step_by(&known, &nothing);
        self.is_predictive = is_predictive;
        let (estimate, last) = (estimate?, steps.last().cloned().unwrap_or_default());
        let predictive = self.filter.measurement(&last.step(), &nothing, self.asked.probabilities());
        self.unknown = self.unknown.take().or_else(|| self.model.unknown_input(&last.step()));
        let estimate = Estimate { ess: None, log_evidence: None, predictive, ..estimate };
        Ok(self.model.forecast(Some(clock), row, last.step().time, estimate))
    }

    /// What is to be said of forecasts of measurements that need an input which nobody gave.
    pub fn forecast_warning(&self, series: Option<&str>) -> Option<Warning> {
        let input = self.unknown.as_ref()?;
        let cure =
            match self.kind == ProposalName::Exact.kind() && self.model.fed_back_measurement().is_some() {
                true => "it is drawn by --proposal bootstrap, and by no exact filter",
                false => "it is not known ahead; give its values by --inputs",
            };
        let text = format!("forecasts of measurements that need the input {input} are empty: {cure}");
        Some(Warning { series: series.map(String::from), text })
    }
}

impl Model {
    /// What is predicted for the row that a clock is at.
    pub(crate) fn forecast(
        &self,
        clock: Option<&Clock>,
        row: Option<RowTime<'_>>,
        time: f64,
        estimate: Estimate,
    ) -> Forecast {
        let given = row.and_then(|row| row.label).map(String::from);
        let is_given = given.is_some();
        let label = given.or_else(|| clock?.label_of_last(self.timeline()?));
        Forecast { time, label, is_given, estimate }
    }
}
