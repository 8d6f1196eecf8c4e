//! Proposals that miss a mode, and whether anybody notices.

use motes_models::{StateSpaceModel, Step, Stream, fill_standard_normal};
use motes_smc::{
    Conditional, Context, FilterSettings, Proposal, ProposalError, Transition, Verdict, particles_by_stream,
};

use super::models::{Growth, judge_all};

/// A proposal of the growth model that draws positive states only.
#[derive(Clone, Copy)]
enum Positive {
    /// `|x|` of an `x` near the root of `20 y_t`, with a fifth of `|N(0, 10²)|`: its weights are even.
    Root { of: f64 },
    /// `|x|` of an `x` that the transition draws.
    Folded,
}

struct PositiveBlock<'a, M: ?Sized> {
    proposal: Positive,
    model: &'a M,
    context: Context<'a>,
}

impl<M: StateSpaceModel> Proposal<M> for Positive {
    type Memory = ();
    type Scratch = ();
    type Conditional<'a>
        = PositiveBlock<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(
        &mut self,
        _model: &M,
        _step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        let Some(measurement) = measurement[0] else { return Ok(false) };
        if let Positive::Root { of } = self {
            *of = 20.0 * measurement.max(0.0);
        }
        Ok(true)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        (): &'a mut (),
    ) -> Result<PositiveBlock<'a, M>, ProposalError> {
        Ok(PositiveBlock { proposal: *self, model, context })
    }
}

const NEAR: f64 = 2.0;
const WIDE: f64 = 10.0;

/// The density of `|z|` for `z ~ N(mean, sd²)`, at `x ≥ 0`.
fn folded_normal(x: f64, mean: f64, sd: f64) -> f64 {
    let at = |x: f64| (-0.5 * ((x - mean) / sd).powi(2)).exp() / (sd * std::f64::consts::TAU.sqrt());
    at(x) + at(-x)
}

impl<M: StateSpaceModel> Conditional for PositiveBlock<'_, M> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        match self.proposal {
            Positive::Folded => {
                Transition::new(self.model, self.context).sample(streams, states, log_density);
                states.iter_mut().for_each(|x| *x = x.abs());
            }
            Positive::Root { of } => {
                let particles = states.len();
                for (stream, states) in particles_by_stream(streams, states, 1, particles) {
                    fill_standard_normal(stream, states);
                    for (k, x) in states.iter_mut().enumerate() {
                        *x = if k % 5 == 0 { WIDE * *x } else { of.sqrt() + NEAR * *x }.abs();
                    }
                }
            }
        }
        self.log_density(states, log_density);
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        match self.proposal {
            Positive::Folded => {
                let mirrored: Vec<f64> = states.iter().map(|x| -x).collect();
                let mut of_mirrored = vec![0.0; states.len()];
                let mut transition = Transition::new(self.model, self.context);
                transition.log_density(states, log_density);
                transition.log_density(&mirrored, &mut of_mirrored);
                for (log, other) in log_density.iter_mut().zip(of_mirrored) {
                    let largest = log.max(other);
                    *log = largest + ((*log - largest).exp() + (other - largest).exp()).ln();
                }
            }
            Positive::Root { of } => {
                for (log, x) in log_density.iter_mut().zip(states) {
                    *log =
                        (0.8 * folded_normal(*x, of.sqrt(), NEAR) + 0.2 * folded_normal(*x, 0.0, WIDE)).ln();
                }
            }
        }
    }
}

const SEQUENCES: u64 = 60;

#[test]
fn a_missing_mode_is_warned_of_where_weights_say_nothing() {
    let settings = FilterSettings::new(1000);
    for (name, proposal, horizon, least) in [
        ("near the root", Positive::Root { of: 0.0 }, 100, 0.95),
        // Misses have to add up.
        ("near the root, half as long", Positive::Root { of: 0.0 }, 50, 0.8),
        // Its own weights warn of each of these, so that much of it is not to be judged.
        ("folded", Positive::Folded, 100, 0.75),
    ] {
        let judged = judge_all(&Growth, || proposal, settings, horizon, 0..SEQUENCES);
        let (mut warned, mut unsuspected, mut sizes) = (0, 0, 0.0);
        for judged in &judged {
            if let Verdict::Warns { first_step, difference, error } = judged.verdict {
                warned += 1;
                assert!(
                    first_step < horizon && difference > 5.0 && error < 0.2 * difference,
                    "{}",
                    judged.verdict
                );
            }
            unsuspected += usize::from(judged.report.warnings().next().is_none());
            sizes += judged.report.effective_sample_size().unwrap() / SEQUENCES as f64;
        }
        println!(
            "{name}, {horizon} steps: {warned} of {SEQUENCES} are warned of; {unsuspected} have no warning of their own, at {sizes:.0} \
             effective particles of 1000"
        );
        assert!(warned as f64 >= least * SEQUENCES as f64, "{name}: {warned} of {SEQUENCES}");
    }
}
