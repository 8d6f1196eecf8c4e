//! Stretches of filters that run along recorded series with the present weights, one series after another.

use motes_models::{OwnModel, OwnStep, PartialMeasurements, Seed, StateGradients};
use motes_proposals::{Amortised, Draws, Parametric};
use motes_smc::{FilterError, FilterSettings, ParticleFilter};

use crate::TrainError;

/// Particles of a filter: few, so that a poor proposal shows in its evidence.
const PARTICLES: usize = 32;

/// A filter that learning goes along with.
pub(super) struct Stretches<'a, M: OwnModel + ?Sized> {
    model: &'a M,
    /// Series, and how many of their first times are learned from.
    series: &'a [(&'a PartialMeasurements, usize)],
    /// Times of a stretch.
    times: usize,
    seed: Seed,
    running: Option<ParticleFilter<&'a M, Amortised>>,
    /// How many filters were begun.
    begun: usize,
    previous: Vec<f64>,
    slopes: Vec<f64>,
    shares: Vec<f64>,
}

impl<'a, M: OwnModel + StateGradients + ?Sized> Stretches<'a, M> {
    /// Stretches of about so many rows.
    pub(super) fn new(
        model: &'a M,
        series: &'a [(&'a PartialMeasurements, usize)],
        rows: usize,
        seed: Seed,
    ) -> Self {
        let times = rows.div_ceil(PARTICLES);
        let [previous, slopes, shares] = [(); 3].map(|()| Vec::new());
        Stretches { model, series, times, seed, running: None, begun: 0, previous, slopes, shares }
    }

    /// Goes on by a stretch, with the weights of `proposal`, up to the end of a series. `draws` gets its particles; the mean log-evidence of its times
    /// comes back.
    ///
    /// Times whose measurement has gaps give no draws: there the proposal is its base. A filter that collapses ends its series.
    ///
    /// # Errors
    /// [`TrainError::Recorded`] if no series gives a draw of a later time.
    pub(super) fn next(&mut self, proposal: &Amortised, draws: &mut Draws) -> Result<f64, TrainError> {
        // The rest of a series may be without a draw, and so may each whole one.
        let begun = self.begun;
        while self.begun - begun <= self.series.len() {
            draws.clear();
            let (log_evidence, times) = self.advance(proposal, draws)?;
            if !draws.later.is_empty() {
                return Ok(log_evidence / times as f64);
            }
        }
        let reason = "no filter draws at a second time with a whole measurement".into();
        Err(TrainError::Recorded { reason })
    }

    fn advance(&mut self, proposal: &Amortised, draws: &mut Draws) -> Result<(f64, usize), TrainError> {
        let mut filter = match self.running.take() {
            Some(mut filter) => {
                let values = filter.proposal_mut().parameters_mut().values_mut();
                values.clone_from(proposal.parameters().values());
                filter
            }
            None => {
                let stream = self.seed.nth(self.begun as u64).stream();
                self.begun += 1;
                let failed = |error: FilterError| TrainError::Recorded { reason: error.to_string() };
                let settings = FilterSettings::new(PARTICLES);
                ParticleFilter::new(self.model, proposal.clone(), settings, stream).map_err(failed)?
            }
        };
        let (series, until) = self.series[(self.begun - 1) % self.series.len()];
        let (before, first) = (filter.log_evidence(), filter.time());
        let last = (first + self.times).min(until);
        for (time, row) in series.rows().enumerate().take(last).skip(first) {
            if filter.step_at(&self.model.step_of_index(time), row).is_err() {
                return Ok((filter.log_evidence() - before, time.max(first + 1) - first));
            }
            if let Some(whole) = row.iter().copied().collect::<Option<Vec<f64>>>() {
                self.add(proposal, &filter, time, &whole, draws)?;
            }
        }
        let log_evidence = filter.log_evidence() - before;
        if last < until {
            self.running = Some(filter);
        }
        Ok((log_evidence, (last - first).max(1)))
    }

    /// Adds the particles of a step, each by the square of its weight over the times of a stretch.
    fn add(
        &mut self,
        proposal: &Amortised,
        filter: &ParticleFilter<&'a M, Amortised>,
        time: usize,
        measurement: &[f64],
        draws: &mut Draws,
    ) -> Result<(), TrainError> {
        let n = self.model.state_dim();
        let states = filter.particles();
        self.slopes.resize(states.len(), 0.0);
        let step = self.model.step_of_index(time);
        self.model.likelihood_gradients(&step, states, measurement, &mut self.slopes);
        self.previous.clear();
        if let Some(all) = filter.previous_particles() {
            for ancestor in filter.ancestors() {
                self.previous.extend_from_slice(&all[ancestor * n..][..n]);
            }
        }
        let share = 1.0 / self.times as f64;
        self.shares.clear();
        self.shares.extend(filter.weights().normalised().iter().map(|weight| weight * weight * share));
        let measurements = measurement.repeat(PARTICLES);
        let previous = (time > 0).then_some(self.previous.as_slice());
        let step = OwnStep { step, previous, states, noise: None, measurements: &measurements };
        Ok(proposal.add_draws(self.model, &step, &self.slopes, &self.shares, draws)?)
    }
}
