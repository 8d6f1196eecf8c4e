//! Running the filters of a unit.

use std::time::Instant;

use motes_models::StateSpaceModel;
use motes_smc::{FilterBank, FilterSettings, FixedLagSmoother, ParticleFilter, Proposal, ResampleWhen};

use super::evaluation::Evaluation;
use super::run::Run;
use crate::config::{Estimand, Filter};
use crate::metric::Metric;
use crate::metrics::{Recorded, metrics, metrics_of_smoothing, metrics_of_survivors};
use crate::problem::Model;
use crate::recorded_series::series;
use crate::unit_error::{UnitError, failed};

impl Run<'_> {
    /// Runs the filters of a unit with one proposal.
    pub(super) fn run_filters<P: Proposal<Model>>(
        self,
        model: &Model,
        proposal: P,
    ) -> Result<Evaluation, UnitError> {
        let Run { unit, problem, .. } = self;
        let start = Instant::now();
        let (filters, n) = (unit.filter_runs, unit.system.dimension());
        let seed = unit.own_seed().child("filter");
        let settings = filter_settings(&unit.filter);
        let bank = FilterBank::new(model, proposal, settings, filters, &seed).map_err(failed)?;
        let mut bank = if unit.held_out { bank.keeping_collapsed() } else { bank };
        let mut recorded = Recorded::with_capacity(filters, unit.system.horizon(), n);
        let mut mean = vec![0.0; n];
        for measurement in problem.trajectory.measurements.rows() {
            self.go_on()?;
            bank.step(measurement).map_err(failed)?;
            recorded.report.add(&bank.diagnosis());
            for filter in 0..filters {
                bank.mean(filter, &mut mean);
                recorded.means.extend_from_slice(&mean);
                recorded.effective_sample_sizes.push(bank.weights(filter).effective_sample_size());
            }
        }
        recorded.log_evidence.extend((0..filters).map(|filter| bank.log_evidence(filter)));
        Ok(self.found(&recorded, start))
    }

    /// Smooths by `lag` later measurements, as far as there are any, in filters that run one after the other.
    pub(super) fn smooth<M: StateSpaceModel + ?Sized, P: Proposal<M> + Clone>(
        self,
        model: &M,
        proposal: &P,
        lag: usize,
    ) -> Result<Evaluation, UnitError> {
        let Run { unit, problem, .. } = self;
        let start = Instant::now();
        let (runs, n, horizon) = (unit.filter_runs, unit.system.dimension(), unit.system.horizon());
        let seed = unit.own_seed().child("filter");
        let settings = filter_settings(&unit.filter);
        let mut recorded = Recorded::with_capacity(runs, horizon, n);
        recorded.means.resize(horizon * runs * n, 0.0);
        for run in 0..runs {
            let stream = seed.nth(run as u64).stream();
            let filter = ParticleFilter::new(model, proposal.clone(), settings, stream).map_err(failed)?;
            let mut smoother = FixedLagSmoother::new(filter, lag);
            for (time, measurement) in problem.trajectory.measurements.rows().enumerate() {
                self.go_on()?;
                smoother.step(measurement).map_err(failed)?;
                recorded.report.add(&smoother.filter().diagnosis());
                recorded.effective_sample_sizes.push(smoother.filter().effective_sample_size());
                // At the end there is nothing more to wait for.
                let last = if time + 1 == horizon { 0 } else { lag };
                for back in (last..=lag.min(time)).rev() {
                    let at = ((time - back) * runs + run) * n;
                    smoother.mean(back, &mut recorded.means[at..at + n]).map_err(failed)?;
                }
            }
            recorded.log_evidence.push(smoother.filter().log_evidence());
        }
        Ok(self.found(&recorded, start))
    }

    fn found(self, recorded: &Recorded, start: Instant) -> Evaluation {
        let timings = vec![Metric::new("filter_seconds", start.elapsed().as_secs_f64())];
        let Run { unit, problem, references, .. } = self;
        let (metrics, series) = if unit.held_out {
            let survivors = recorded.survivors(unit.system.dimension());
            let metrics = metrics_of_survivors(problem, references, &survivors, recorded.filters);
            (metrics, if survivors.filters > 0 { series(unit, problem, &survivors) } else { None })
        } else {
            let metrics = match unit.estimand {
                Estimand::Filtering => metrics(problem, references, recorded),
                Estimand::Smoothing => metrics_of_smoothing(problem, references, recorded),
            };
            (metrics, series(unit, problem, recorded))
        };
        Evaluation { metrics, timings, series, earlier: vec![] }
    }
}

fn filter_settings(filter: &Filter) -> FilterSettings {
    FilterSettings {
        particles: filter.particles,
        resampling: filter.resampling,
        resample_when: ResampleWhen::EssBelow(filter.ess_threshold),
        defensive_weight: filter.defensive_weight,
    }
}
