//! Batched equations whose states are known, follow or are counts, with sub-steps and inputs.

use motes_models::batch::Rows;
use motes_models::equations::{
    BatchDistribution, BatchEquations, Batched, Binomial, Column, Distribution, Poisson, Transport,
};
use motes_models::{Seed, StateSpaceModel, Step};

/// How many of fifty are left, and how many steps were made; each leaves in a step of length 1 with a probability that is an input.
struct Leaving {
    inputs: [f64; 1],
}

impl BatchEquations for Leaving {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial(&self) -> Option<Vec<BatchDistribution>> {
        Some([50.0, 0.0].map(|value| BatchDistribution::known(Column::same(value))).to_vec())
    }

    fn transition(&self, step: &Step<'_>, previous: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        let of = |at: usize| previous.iter().skip(at).step_by(2).copied();
        let stay = Column::same((1.0 - step.inputs[0]).powf(step.length));
        let left = Distribution::Binomial(Binomial { n: Column::each(of(0).collect()), p: stay });
        let made = Column::each(of(1).map(|count| count + 1.0).collect());
        Some(vec![BatchDistribution::new(left), BatchDistribution::known(made)])
    }

    fn measurement(&self, step: &Step<'_>, states: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        let mean = Column::each(states.iter().step_by(2).map(|left| left + step.inputs[0]).collect());
        Some(vec![BatchDistribution::new(Distribution::Poisson(Poisson { mean }))])
    }
}

#[test]
fn sub_steps_are_made_one_after_another_with_their_inputs() {
    let model = Batched::new(Leaving { inputs: [f64::NAN] });
    assert!(model.density().is_none() && model.noise_space().is_none() && !model.is_affine());
    assert_eq!(model.input_dim(), 1);
    let mut stream = [Seed::from_u64(1).stream()];
    let mut first = vec![f64::NAN; 2 * 4000];
    model.sample_states(&Step::of_index(0), None, &mut stream, &mut first);
    assert!(first.chunks_exact(2).all(|state| state == [50.0, 0.0]));
    let mut states = vec![f64::NAN; first.len()];
    // Half an hour without loss, then one in which a share is lost, and the input of the measurement.
    let step = Step { sub_steps: 2, inputs: &[0.0, 0.36, 1000.0], ..Step::of_index(1) };
    model.sample_states(&step, Some(Rows::all(&first, 2)), &mut stream, &mut states);
    assert!(states.chunks_exact(2).all(|state| state[1] == 2.0 && state[0].fract() == 0.0));
    let mean = states.iter().step_by(2).sum::<f64>() / 4000.0;
    // Binomial of 50 with 0.8: a mean of 40, and a standard error of √(8/4000).
    assert!((mean - 40.0).abs() < 4.0 * (8.0_f64 / 4000.0).sqrt(), "{mean}");
    // log Poisson(1000; 40 + 1000)
    let found = model.log_likelihood(&step, &[40.0, 2.0], &[1000.0]).unwrap();
    let expected = 1000.0 * 1040.0_f64.ln() - 1040.0 - (1..=1000).map(|k| f64::from(k).ln()).sum::<f64>();
    assert!((found - expected).abs() < 1e-9 * expected.abs(), "{found} is not {expected}");
    // Two rows at one time.
    let still = Step { sub_steps: 0, length: 0.0, inputs: &[0.5], ..Step::of_index(2) };
    let mut same = vec![f64::NAN; states.len()];
    model.sample_states(&still, Some(Rows::all(&states, 2)), &mut stream, &mut same);
    assert_eq!(same, states);
}
