//! A filter of particles with whatever runs beside it, its types put aside.

use std::ops::{ControlFlow, Range};

use motes_inference::map_on_threads;
use motes_models::{Seed, Simulator, StateSpaceModel, Step};
use motes_smc::{
    Bootstrap, EvidenceCheck, EvidenceWarning, FilterError, FilterHistory, FilterSettings, ParticleFilter,
    Predictive, Proposal, SecondOpinion, SmoothedPaths, SmoothingError, Verdict, WeightDiagnosis,
    backward_simulation_while,
};

use crate::error::MotesError;
use crate::estimate::Coordinate;
use crate::missed_mass::{MISSED, noise};
use crate::options::{FilterOptions, ProposalName};
use crate::running_state::{FilterState, ParticleState, SecondState};
use crate::steps::Steps;

/// A filter beside its model, and perhaps small filters and a second opinion beside the filter.
struct Filter<'m, M: StateSpaceModel + ?Sized, P: Proposal<M>> {
    model: &'m M,
    filter: ParticleFilter<&'m M, P>,
    check: Option<EvidenceCheck<&'m M, P>>,
    second: Option<Second<'m, M>>,
    /// Whether its weights know the data from the start, so that its evidence is that of all of them after the last step alone.
    looks_ahead: bool,
}

/// A bootstrap filter, and what it says of another.
struct Second<'m, M: StateSpaceModel + ?Sized> {
    bootstrap: ParticleFilter<&'m M, Bootstrap>,
    opinion: SecondOpinion,
}

/// What a filter begins with.
pub(crate) enum Start {
    /// The seed of its random numbers.
    Seed(Seed),
    /// What it was before.
    State(Box<FilterState>),
}

/// Numbers of particles from which on it pays to look at them on two threads.
const LARGE: usize = 16_384;

/// What `of` says of each coordinate, on all threads if there is much to look at.
fn of_all(
    coordinates: Range<usize>,
    is_large: bool,
    of: &(dyn Fn(usize) -> Coordinate + Sync),
) -> Vec<Coordinate> {
    if !is_large || coordinates.len() < 2 {
        return coordinates.map(of).collect();
    }
    map_on_threads(&coordinates.collect::<Vec<usize>>(), |_, coordinate| of(*coordinate))
}

impl<M: StateSpaceModel + ?Sized, P: Proposal<M>> Filter<'_, M, P> {
    fn coordinate(&self, coordinate: usize, probabilities: &[f64]) -> Coordinate {
        let filter = &self.filter;
        let (means, particles, weights) = (filter.mean(), filter.particles(), filter.weights().normalised());
        let (n, mean) = (means.len(), means[coordinate]);
        let values = particles.iter().skip(coordinate).step_by(n);
        let variance: f64 = values.zip(weights).map(|(x, weight)| weight * (x - mean) * (x - mean)).sum();
        // One particle with all weight says nothing of a spread.
        if variance == 0.0 && weights.iter().filter(|weight| **weight > 0.0).count() == 1 {
            return Coordinate { mean, sd: f64::NAN, quantiles: vec![f64::NAN; probabilities.len()] };
        }
        Coordinate { mean, sd: variance.sqrt(), quantiles: filter.quantiles(coordinate, probabilities) }
    }
}

impl<M, P> Steps for Filter<'_, M, P>
where
    M: Simulator + ?Sized,
    P: Proposal<M, Memory = ()> + Clone + Send,
{
    fn step(&mut self, step: &Step<'_>, measurement: &[Option<f64>]) -> Result<(), FilterError> {
        let Filter { filter, check, second, looks_ahead, .. } = self;
        let Some(check) = check else { return filter.step_at(step, measurement) };
        // On the second thread, where there is one.
        let (done, ()) = rayon_core::join(
            || filter.step_at(step, measurement),
            || {
                check.advance(step, measurement);
                if let Some(Second { bootstrap, .. }) = second {
                    // One that fails has no opinion.
                    let _ = bootstrap.step_at(step, measurement);
                }
            },
        );
        done?;
        check.take_in(filter, measurement);
        match second {
            Some(Second { bootstrap, opinion }) if !*looks_ahead => opinion.step(filter, bootstrap),
            _ => Ok(()),
        }
    }

    fn measurement_ahead(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Result<Vec<Predictive>, FilterError> {
        self.filter.measurement_ahead(step, measurement, probabilities)
    }

    fn measurement(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Vec<Predictive> {
        self.filter.measurement(step, measurement, probabilities)
    }

    fn difference(&self) -> f64 {
        self.second.as_ref().map_or(0.0, |second| second.opinion.difference())
    }

    fn standard_error(&self) -> Option<f64> {
        self.check.as_ref().and_then(EvidenceCheck::standard_error)
    }

    fn evidence_warnings(&self) -> Vec<EvidenceWarning> {
        self.check.as_ref().map(EvidenceCheck::warnings).unwrap_or_default()
    }

    fn verdict(&self) -> Option<Verdict> {
        self.second.as_ref().filter(|_| !self.looks_ahead).map(|second| second.opinion.verdict())
    }

    fn missed(&self) -> Option<f64> {
        let Second { bootstrap, .. } = self.second.as_ref().filter(|_| self.looks_ahead)?;
        let larger = bootstrap.log_evidence() - self.filter.log_evidence();
        let enough = MISSED + noise(self.standard_error());
        (bootstrap.failure().is_none() && larger > enough).then_some(larger)
    }

    fn state(&self, probabilities: &[f64]) -> Vec<Coordinate> {
        let n = self.filter.mean().len();
        of_all(0..n, self.is_large(), &|coordinate| self.coordinate(coordinate, probabilities))
    }

    fn weighted(&self) -> Option<(&[f64], &[f64])> {
        Some((self.filter.particles(), self.filter.weights().normalised()))
    }

    fn particles(&self) -> usize {
        self.filter.particles().len()
    }

    fn is_large(&self) -> bool {
        self.filter.particles().len() >= LARGE
    }

    fn means(&self) -> &[f64] {
        self.filter.mean()
    }

    fn quantiles(&self, coordinate: usize, probabilities: &[f64]) -> Vec<f64> {
        self.filter.quantiles(coordinate, probabilities)
    }

    fn diagnosis(&self) -> Option<WeightDiagnosis> {
        Some(self.filter.diagnosis())
    }

    fn effective_sample_size(&self) -> Option<f64> {
        Some(self.filter.effective_sample_size())
    }

    fn log_evidence(&self) -> f64 {
        self.filter.log_evidence()
    }

    fn record(&self, history: &mut FilterHistory) -> Result<(), SmoothingError> {
        history.record(&self.filter)
    }

    fn backward(
        &self,
        history: &FilterHistory,
        paths: usize,
        seed: &Seed,
        proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<SmoothedPaths, SmoothingError> {
        backward_simulation_while(self.model, history, paths, seed, proceed)
    }

    fn failure(&self) -> Option<&FilterError> {
        self.filter.failure()
    }

    fn snapshot(&self) -> FilterState {
        let second = |second: &Second<'_, M>| SecondState {
            bootstrap: second.bootstrap.snapshot(),
            opinion: second.opinion.clone(),
        };
        FilterState::Particles(Box::new(ParticleState {
            filter: self.filter.snapshot(),
            check: self.check.as_ref().map(EvidenceCheck::snapshot),
            second: self.second.as_ref().map(second),
        }))
    }

    fn of_particle(&self, particle: usize) -> (Option<&[f64]>, &[f64]) {
        let filter = &self.filter;
        let n = filter.mean().len();
        let row = |at: usize| at * n..(at + 1) * n;
        let previous = filter.previous_particles().map(|all| &all[row(filter.ancestors()[particle])]);
        (previous, &filter.particles()[row(particle)])
    }
}

/// A checkpoint that is none of such a filter.
pub(crate) fn of_another_kind() -> MotesError {
    MotesError::Packed { what: "checkpoint".into(), reason: "it is of a filter of another kind".into() }
}

/// The filter of a model and a proposal that the options ask for.
pub(crate) fn boxed<'m, M: Simulator + ?Sized>(
    model: &'m M,
    proposal: impl Proposal<M, Memory = ()> + Clone + Send + 'm,
    options: &FilterOptions,
    start: Start,
) -> Result<Box<dyn Steps + 'm>, MotesError> {
    let seed = match start {
        Start::Seed(seed) => seed,
        Start::State(state) => {
            let FilterState::Particles(state) = *state else { return Err(of_another_kind()) };
            let ParticleState { filter, check, second } = *state;
            let restored = |SecondState { bootstrap, opinion }| {
                ParticleFilter::restore(model, Bootstrap, bootstrap)
                    .map(|bootstrap| Second { bootstrap, opinion })
            };
            return Ok(Box::new(Filter {
                model,
                check: check
                    .map(|check| EvidenceCheck::restore(model, proposal.clone(), check))
                    .transpose()?,
                filter: ParticleFilter::restore(model, proposal, filter)?,
                second: second.map(restored).transpose()?,
                looks_ahead: false,
            }));
        }
    };
    let settings = options.settings();
    // Random numbers of their own: whatever is checked, nothing else changes.
    let check = match options.check {
        true => Some(EvidenceCheck::new(model, proposal.clone(), settings, &seed.child("check"))?),
        false => None,
    };
    let looks_ahead = proposal.looks_ahead();
    let filter = ParticleFilter::new(model, proposal, settings, seed.stream())?;
    let second = match options.check && options.proposal != ProposalName::Bootstrap {
        true => {
            let stream = seed.child("second opinion").stream();
            let settings = FilterSettings { defensive_weight: None, ..settings };
            let bootstrap = ParticleFilter::new(model, Bootstrap, settings, stream)?;
            Some(Second { bootstrap, opinion: SecondOpinion::new() })
        }
        false => None,
    };
    Ok(Box::new(Filter { model, filter, check, second, looks_ahead }))
}
