//! The noise of models that are stated by equations.

use super::guided::{Guide, GuidedDraws};
use super::linearised::Linearisation;
use super::scores::NoiseScores;
use super::sites::SiteQuery;
use super::{Draw, NoiseSpace};
use crate::batch::{LANES, by_widest_vectors};
use crate::equations::advance::make_state;
use crate::equations::distribution::Distribution;
use crate::equations::lanes::Lanes;
use crate::equations::statement::{Draws, Equations};
use crate::equations::tiles::{rows_of, rows_of_mut};
use crate::{StateSpaceModel, Step};

/// Keeps what each draw is, and answers with its mean.
struct DrawList(Vec<Draw>);

impl Draws<f64> for DrawList {
    fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
        self.0.push(match distribution {
            Distribution::Normal(_) => Draw::Normal,
            _ if distribution.is_discrete() => Draw::Count,
            _ => Draw::Continuous,
        });
        distribution.moments()[0]
    }
}

/// Answers each draw with what its noise is transported to; NaN where there are more draws than noise.
struct NoiseDraws<'a> {
    noise: &'a [Lanes],
}

impl Draws<Lanes> for NoiseDraws<'_> {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<Lanes>) -> Lanes {
        let Some((v, rest)) = self.noise.split_first() else { return Lanes::from(f64::NAN) };
        self.noise = rest;
        distribution.tile_from_normal(*v)
    }
}

impl<M: Equations> NoiseSpace for M {
    fn draws(&self, step: &Step<'_>) -> Vec<Draw> {
        let [n, _] = self.dimensions();
        let (mut list, mut state) = (DrawList(Vec::new()), vec![0.0; n]);
        make_state(self, &self.step_of_index(0), None, &mut list, &mut state);
        if step.index > 0 {
            let previous = state.clone();
            list.0.clear();
            make_state(self, step, Some(&previous), &mut list, &mut state);
        }
        list.0
    }

    fn are_alike(&self, one: &Step<'_>, other: &Step<'_>) -> bool {
        // The start has no state before it.
        let may_be_moved = !self.depends_on_time() && (one.index > 0) == (other.index > 0);
        let moved = Step { index: one.index, time: one.time, ..*other };
        if may_be_moved { moved == *one } else { other == one }
    }

    fn tile_states(&self, step: &Step<'_>, previous: Option<&[f64]>, noise: &[f64], states: &mut [f64]) {
        let mut draws = NoiseDraws { noise: rows_of(noise) };
        let states = rows_of_mut(states);
        by_widest_vectors(
            #[inline(always)]
            || {
                step.lift(|step| make_state(self, step, previous.map(rows_of), &mut draws, states));
            },
        );
        // A number that no draw took is as wrong as one that is missing.
        if !draws.noise.is_empty() {
            states.fill(Lanes::from(f64::NAN));
        }
    }

    fn tile_guided_states(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        guide: Guide<'_>,
        noise: &mut [f64],
        states: &mut [f64],
    ) -> Lanes {
        let mut guided = GuidedDraws::new(guide, rows_of_mut(noise));
        let states = rows_of_mut(states);
        by_widest_vectors(
            #[inline(always)]
            || {
                step.lift(|step| make_state(self, step, previous.map(rows_of), &mut guided, states));
            },
        );
        guided.log_ratio()
    }

    fn tile_noise_scores(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let draws = jacobian.len() / (measurement.len() * LANES).max(1);
        let mut scores = NoiseScores {
            model: self,
            step,
            previous: previous.map(rows_of),
            draws,
            measurement,
            slopes: rows_of_mut(slopes),
            information: rows_of_mut(information),
            jacobian: rows_of_mut(jacobian),
        };
        match draws {
            0 => {}
            1 => scores.along::<2>(),
            _ => scores.along::<3>(),
        }
    }

    fn tile_linearised(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        noise: &[f64],
        particles: usize,
        states: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let directions = jacobian.len() / states.len().max(1);
        let mut asked = Linearisation {
            model: self,
            step,
            previous: previous.map(rows_of),
            noise: rows_of(noise),
            particles,
            directions,
            states: rows_of_mut(states),
            jacobian: rows_of_mut(jacobian),
        };
        match directions {
            0 | 1 => asked.along::<2>(),
            _ => asked.along::<3>(),
        }
    }

    fn tile_sites(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<Lanes>],
        particles: usize,
        slopes: &mut [f64],
        roots: &mut [f64],
    ) {
        let mut asked = SiteQuery {
            model: self,
            step: &step.end(self.inputs().len()),
            states: rows_of(states),
            measurement,
            particles,
            slopes: rows_of_mut(slopes),
            roots: rows_of_mut(roots),
        };
        match asked.states.len() {
            0 => {}
            1 => asked.along::<2>(),
            _ => asked.along::<3>(),
        }
    }
}
