//! What an amortised proposal conditions to: draws with the density that is asked at their points, inside the support.

use motes_models::equations::Equations;
use motes_models::{ModelShape, Seed, StateSpaceModel, Step};
use motes_proposals::{
    Amortised, AmortisedConfig, AmortisedScratch, Backend, Base, Compute, Covariance, Family, HeadConfig,
    Parametric, Sees,
};
use motes_smc::{Conditional, Context, Linearised, LinearisedScratch, Proposal};
use rand::RngExt;

use crate::models::{Awkward, Linear, Noise};

/// An amortised proposal whose weights are random: anything that learning could make of it.
pub(crate) fn random<M: Equations>(model: &M, base: Base, head: HeadConfig, size: f64) -> Amortised {
    random_of(
        model,
        AmortisedConfig { widths: vec![8], sees: Sees::All, base, head, ..AmortisedConfig::gaussian() },
        size,
    )
}

/// [`random`] with any settings.
pub(crate) fn random_of<M: Equations>(model: &M, config: AmortisedConfig, size: f64) -> Amortised {
    random_in(model, config, size, Backend::Native.into())
}

/// [`random_of`] in any precision.
pub(crate) fn random_in<M: Equations>(
    model: &M,
    config: AmortisedConfig,
    size: f64,
    compute: Compute,
) -> Amortised {
    let seed = Seed::from_u64(4);
    let shape = ModelShape::on_dependences(model, &seed);
    let mut proposal = Amortised::create(&config, &shape, 0, compute, &seed).unwrap();
    let mut stream = seed.child("more").stream();
    for index in 0..proposal.parameters().len() {
        if proposal.parameters().names()[index].contains("inputs") {
            continue;
        }
        let mut values = proposal.parameters().host(index);
        values.iter_mut().for_each(|value| *value += size * (2.0 * stream.random::<f64>() - 1.0));
        proposal.parameters_mut().set_host(index, &values).unwrap();
    }
    proposal
}

/// Every head that there is.
pub(crate) const HEADS: [HeadConfig; 6] = [
    HeadConfig::Gaussian { covariance: Covariance::Full },
    HeadConfig::Mixture { components: 3, covariance: Covariance::Full },
    HeadConfig::Flow { pieces: 6, covariance: Covariance::Full },
    HeadConfig::Kernel,
    HeadConfig::Gaussian { covariance: Covariance::Shared },
    HeadConfig::Flow { pieces: 6, covariance: Covariance::Shared },
];

/// Every base.
pub(crate) const BASES: [Base; 2] = [Base::Transition, Base::Linearised];

fn draws_have_their_density<M: Equations>(model: &M, measurement: &[f64]) {
    let count = 70;
    let n = model.state_dim();
    let mut previous = vec![0.0; count * n];
    model.sample_states(&Step::of_index(0), None, &mut [Seed::from_u64(5).stream()], &mut previous);
    for (base, head) in BASES.into_iter().flat_map(|base| HEADS.map(|head| (base, head))) {
        let mut proposal = random(model, base, head, 0.2);
        for time in [0, 1] {
            let before = (time > 0).then_some(previous.as_slice());
            let context = Context::new(Step::of_index(time), before, count);
            let mut scratch = AmortisedScratch::default();
            let mut conditional =
                proposal.condition_batch(model, context, measurement, &mut (), &mut scratch).unwrap();
            let (mut states, mut along, mut at) = (vec![0.0; count * n], vec![0.0; count], vec![0.0; count]);
            conditional.sample(&mut Seed::from_u64(6).streams(7), &mut states, &mut along);
            conditional.log_density(&states, &mut at);
            let mut of_transition = vec![0.0; count];
            match time {
                0 => model.density().unwrap().log_densities(
                    &Step::of_index(0),
                    None,
                    &states,
                    &mut of_transition,
                ),
                _ => {
                    let rows = motes_models::batch::Rows::all(&previous, n);
                    model.density().unwrap().log_densities(
                        &Step::of_index(time),
                        Some(rows),
                        &states,
                        &mut of_transition,
                    );
                }
            }
            for row in 0..count {
                let (along, at) = (along[row], at[row]);
                assert!((along - at).abs() < 1e-6 * (1.0 + at.abs()), "{base:?}, {head:?}: {along} for {at}");
                assert!(of_transition[row].is_finite(), "{base:?}, {head:?}: drawn outside of the support");
            }
        }
    }
}

#[test]
fn a_draw_has_the_density_that_is_asked_at_its_point() {
    draws_have_their_density(&Linear, &[0.4]);
    for noise in [Noise::HalfLine, Noise::Interval, Noise::HeavyTails] {
        draws_have_their_density(&Awkward(noise), &[3.0, 0.5]);
    }
}

/// Fails where something of the weights is kept from the step before: one who learns while it filters would draw from another proposal than it differentiates.
#[test]
fn weights_that_change_between_two_steps_count_from_the_next_on() {
    let config = |head| AmortisedConfig { head, ..AmortisedConfig::gaussian() };
    for head in HEADS {
        let [mut changed, mut other] = [0.1, 0.3].map(|size| random_of(&Linear, config(head), size));
        let (previous, at) = ([0.3, -1.0, 2.0, 0.1], [0.2, 0.4, 1.5, -0.3]);
        let density = |proposal: &mut Amortised, time: usize| {
            let context = Context::new(Step::of_index(time), Some(&previous), 2);
            let (mut scratch, mut found) = (AmortisedScratch::default(), [0.0; 2]);
            proposal
                .condition_batch(&Linear, context, &[0.7], &mut (), &mut scratch)
                .unwrap()
                .log_density(&at, &mut found);
            found
        };
        let before = density(&mut changed, 1);
        for index in 0..other.parameters().len() {
            let values = other.parameters().host(index);
            changed.parameters_mut().set_host(index, &values).unwrap();
        }
        let expected = density(&mut other, 2);
        assert_ne!(before, expected);
        assert_eq!(density(&mut changed, 2), expected, "{head:?}");
    }
}

#[test]
fn outside_of_the_support_the_density_is_zero() {
    let model = Awkward(Noise::Interval);
    let mut proposal = random(&model, Base::Transition, HEADS[1], 0.2);
    let context = Context::new(Step::of_index(1), Some(&[0.0, 0.0, 0.0]), 3);
    let mut scratch = AmortisedScratch::default();
    let mut conditional =
        proposal.condition_batch(&model, context, &[1.0, 0.2], &mut (), &mut scratch).unwrap();
    let mut density = [0.0; 3];
    conditional.log_density(&[-0.9, 0.1, 1.3], &mut density);
    assert_eq!((density[0], density[2]), (f64::NEG_INFINITY, f64::NEG_INFINITY));
    assert!(density[1].is_finite());
}

#[test]
fn untrained_it_is_its_base() {
    let config = AmortisedConfig::gaussian();
    let seed = Seed::from_u64(7);
    let shape = ModelShape::of(&Linear);
    let mut untrained = Amortised::create(&config, &shape, 0, Backend::Native.into(), &seed).unwrap();
    let mut linearised = Linearised::new(&Linear).unwrap();
    let previous = [0.3, -1.0, 2.0, 0.1];
    for time in [0, 1] {
        let context = Context::new(Step::of_index(time), (time > 0).then_some(&previous), 2);
        let at = [0.2, 0.4, 1.5, -0.3];
        let (mut found, mut expected) = ([0.0; 2], [0.0; 2]);
        let mut scratch = AmortisedScratch::default();
        untrained
            .condition_batch(&Linear, context, &[0.7], &mut (), &mut scratch)
            .unwrap()
            .log_density(&at, &mut found);
        let mut scratch = LinearisedScratch::default();
        let mut conditional =
            linearised.condition_batch(&Linear, context, &[0.7], &mut (), &mut scratch).unwrap();
        conditional.log_density(&at, &mut expected);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-10, "time {time}: {found} for {expected}");
        }
    }
}
