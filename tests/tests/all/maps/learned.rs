//! Learned proposals of noise.

use std::ops::ControlFlow;

use motes_models::equations::Equations;
use motes_models::{ModelShape, PartialMeasurements, Seed, simulate};
use motes_proposals::{Amortised, AmortisedConfig, Backend, Base, Covariance, Family, HeadConfig, Sees};
use motes_smc::{Bootstrap, FilterSettings, ParticleFilter, Proposal, ResampleWhen};
use motes_train::{LearnConfig, LearnObjective, TrainError, learn};

use super::models::{
    ConstantVelocity, Delays, Epidemic, Population, WhiteAcceleration, cases, delays, moves, people,
    positions,
};
use super::score::score;

const GAUSSIAN: HeadConfig = HeadConfig::Gaussian { covariance: Covariance::Full };
const FLOW: HeadConfig = HeadConfig::Flow { pieces: 6, covariance: Covariance::Full };

/// A proposal of the noise, learned in a few steps.
fn learned<M: Equations>(model: &M, base: Base, head: HeadConfig) -> Amortised {
    let config =
        AmortisedConfig { widths: vec![16, 16], sees: Sees::All, base, head, ..AmortisedConfig::gaussian() };
    let seed = Seed::from_u64(1);
    let shape = ModelShape::of(model);
    let mut proposal = Amortised::create(&config, &shape, 0, Backend::Native.into(), &seed).unwrap();
    let settings = LearnConfig {
        steps: 300,
        sequences: 64,
        horizon: 6,
        rows: 300,
        validate_every: 50,
        ..LearnConfig::new()
    };
    let found = learn(&mut proposal, model, &[], &settings, &seed, |_, _| ControlFlow::Continue(())).unwrap();
    println!("gain {:.3} to {:.3}", found.validation[0].1, found.best_gain());
    assert!(found.best_gain() > found.validation[0].1);
    proposal
}

/// With each base and head, the share that a proposal has of itself and another.
#[test]
fn learned_noise_leaves_evidence_unbiased() {
    let plain = FilterSettings::new(50);
    let shared = FilterSettings { defensive_weight: Some(0.3), ..plain };
    let epidemic = Epidemic { resets: true, shares: true };
    let accelerated = WhiteAcceleration { shares: true };
    let found = [
        score(&epidemic, &learned(&epidemic, Base::Linearised, FLOW), plain, &cases()),
        score(&accelerated, &learned(&accelerated, Base::Transition, GAUSSIAN), plain, &positions()),
        score(&ConstantVelocity, &learned(&ConstantVelocity, Base::Transition, FLOW), shared, &moves()),
        score(&Population, &learned(&Population, Base::Transition, GAUSSIAN), plain, &people()),
        score(&Delays, &learned(&Delays, Base::Transition, FLOW), plain, &delays()),
    ];
    println!("learned: z = {found:.1?}");
    assert!(found.iter().all(|z| z.abs() < 4.0));
}

/// The mean of `K_eff/K` over held-out sequences, resampled at each step.
fn ess_fraction<M: Equations>(model: &M, proposal: &(impl Proposal<M> + Clone)) -> f64 {
    let (sequences, steps) = (10, 20);
    let mut sum = 0.0;
    for sequence in 0..sequences {
        let seed = Seed::from_u64(99).nth(sequence);
        let data = simulate(model, steps, &mut seed.child("data").stream()).unwrap().measurements;
        let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(100) };
        let mut filter = ParticleFilter::new(model, proposal.clone(), settings, seed.stream()).unwrap();
        for row in data.rows() {
            filter.step(row).unwrap();
            sum += filter.effective_sample_size() / 100.0;
        }
    }
    sum / (sequences as usize * steps) as f64
}

#[test]
fn learned_noise_pays_where_the_transition_is_blind() {
    let proposal = learned(&Delays, Base::Transition, FLOW);
    let [of_learned, of_bootstrap] = [ess_fraction(&Delays, &proposal), ess_fraction(&Delays, &Bootstrap)];
    println!("effective share: learned {of_learned:.2}, bootstrap {of_bootstrap:.2}");
    assert!(of_learned > of_bootstrap + 0.1);
}

/// A filter's particles do not tell which noise they were made of.
#[test]
fn learning_from_a_filters_states_is_refused_by_name() {
    let config = AmortisedConfig { widths: vec![4], ..AmortisedConfig::gaussian() };
    let seed = Seed::from_u64(1);
    let shape = ModelShape::of(&Delays);
    let mut proposal = Amortised::create(&config, &shape, 0, Backend::Native.into(), &seed).unwrap();
    let series = PartialMeasurements::new(1, vec![Some(2.0); 12]).unwrap();
    let settings = LearnConfig { objective: LearnObjective::Wake, steps: 2, ..LearnConfig::new() };
    let said = learn(&mut proposal, &Delays, &[series], &settings, &seed, |_, _| ControlFlow::Continue(()));
    let said = said.unwrap_err();
    assert!(matches!(said, TrainError::Model(_)), "{said}");
    assert!(said.to_string().contains("simulations"), "{said}");
}

/// A proposal for another number of draws is refused before anything is drawn.
#[test]
fn a_proposal_of_other_draws_is_refused_by_name() {
    let config = AmortisedConfig { widths: vec![4], ..AmortisedConfig::gaussian() };
    let shape = ModelShape::of(&WhiteAcceleration { shares: true });
    let seed = Seed::from_u64(1);
    let proposal = Amortised::create(&config, &shape, 0, Backend::Native.into(), &seed).unwrap();
    let model = WhiteAcceleration { shares: false };
    let mut filter = ParticleFilter::new(&model, proposal, FilterSettings::new(10), seed.stream()).unwrap();
    filter.step(&[0.1]).unwrap();
    let said = filter.step(&[0.1]).unwrap_err().to_string();
    assert!(said.contains("the number of draws Q"), "{said}");
}
