//! The gradient of a filter's log-evidence: against differences with the same random numbers, in the mean; and planted bugs.

use motes_models::equations::Equations;
use motes_models::{OwnStep, Seed, StateGradients, Step};
use motes_proposals::{
    Amortised, AmortisedConfig, Backend, Base, Compute, Covariance, Draws, Examples, HeadConfig, Parametric,
    Precision, Sees, Times, Workspace,
};
use motes_smc::{FilterSettings, ParticleFilter, ResampleWhen};
use rand::RngExt;

use crate::conditional::{BASES, HEADS, random_in};
use crate::models::{Awkward, Growth, Linear, Noise};

/// In 64 bits, so that differences have digits.
fn proposal<M: Equations>(model: &M, base: Base, head: HeadConfig) -> Amortised {
    let compute = Compute { backend: Backend::Native, precision: Precision::F64 };
    random_in(
        model,
        AmortisedConfig { widths: vec![4], sees: Sees::All, base, head, ..AmortisedConfig::gaussian() },
        0.3,
        compute,
    )
}

/// A filter after two measurements, and what its last step says.
fn filtered<'m, M: Equations>(
    model: &'m M,
    proposal: &Amortised,
    measurements: [&[f64]; 2],
    particles: usize,
    seed: &Seed,
) -> ParticleFilter<&'m M, Amortised> {
    let settings = FilterSettings { resample_when: ResampleWhen::Never, ..FilterSettings::new(particles) };
    let mut filter = ParticleFilter::new(model, proposal.clone(), settings, seed.stream()).unwrap();
    measurements.iter().for_each(|measurement| filter.step(measurement).unwrap());
    filter
}

/// A direction among the weights of the network of later times, on which `x_0` and its weights do not depend.
fn direction(proposal: &Amortised) -> Vec<(usize, Vec<f64>)> {
    let mut stream = Seed::from_u64(31).stream();
    let names = proposal.parameters().names();
    (0..names.len())
        .filter(|at| names[*at].starts_with("later") && !names[*at].contains("inputs"))
        .map(|at| {
            let [rows, columns] = proposal.parameters().shape(at);
            (at, (0..rows * columns).map(|_| stream.random::<f64>() - 0.5).collect())
        })
        .collect()
}

fn moved(proposal: &Amortised, direction: &[(usize, Vec<f64>)], by: f64) -> Amortised {
    let mut moved = proposal.clone();
    for (at, along) in direction {
        let values = proposal.parameters().host(*at);
        let values: Vec<f64> = values.iter().zip(along).map(|(value, along)| value + by * along).collect();
        moved.parameters_mut().set_host(*at, &values).unwrap();
    }
    moved
}

/// The slope of what is minimised, along a direction.
fn along(mut workspace: Workspace, direction: &[(usize, Vec<f64>)]) -> f64 {
    let gradients = workspace.gradients();
    let of_matrix = |(at, along): &(usize, Vec<f64>)| -> f64 {
        gradients.host(*at).unwrap().iter().zip(along).map(|(slope, along)| slope * along).sum()
    };
    direction.iter().map(of_matrix).sum()
}

/// What is wrong with an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bug {
    Nothing,
    /// Weights stand in the place of their squares, as if the score of `log q` had no mean (Roeder et al. 2017 for more than one particle).
    WeightsNotSquared,
    /// The derivative of the likelihood has the wrong sign.
    LikelihoodReversed,
}

/// The estimated slope of the log-evidence along a direction, and the difference quotient with the same random numbers.
fn slopes<M: Equations>(
    model: &M,
    proposal: &Amortised,
    measurements: [&[f64]; 2],
    particles: usize,
    seed: &Seed,
    bug: Bug,
) -> [f64; 2] {
    let direction = direction(proposal);
    let filter = filtered(model, proposal, measurements, particles, seed);
    let states = filter.particles();
    let mut of_likelihood = vec![0.0; states.len()];
    model.likelihood_gradients(&Step::of_index(1), states, measurements[1], &mut of_likelihood);
    if bug == Bug::LikelihoodReversed {
        of_likelihood.iter_mut().for_each(|slope| *slope = -*slope);
    }
    let weights = filter.weights().normalised();
    let share = |weight: &f64| if bug == Bug::WeightsNotSquared { *weight } else { weight * weight };
    let shares: Vec<f64> = weights.iter().map(share).collect();
    let repeated = measurements[1].repeat(particles);
    let step = OwnStep {
        step: Step::of_index(1),
        previous: filter.previous_particles(),
        states,
        noise: None,
        measurements: &repeated,
    };
    let mut draws = Draws::default();
    proposal.add_draws(model, &step, &of_likelihood, &shares, &mut draws).unwrap();
    let memory = Workspace::new(proposal.parameters());
    let found = proposal.differentiate_evidence(Times::Later, &draws.later, memory).unwrap();
    let mut estimate = -along(found, &direction);
    if particles == 1 {
        // All of the derivative: with the score, which has no part in the estimate.
        let mut examples = Examples::default();
        proposal.encode(model, &step, &mut examples).unwrap();
        let memory = Workspace::new(proposal.parameters());
        let (_, score) = proposal.differentiate_gain(Times::Later, &examples.later, 0.0, memory).unwrap();
        estimate += along(score, &direction);
    }
    let h = 1e-5;
    let evidence = |by: f64| {
        filtered(model, &moved(proposal, &direction, by), measurements, particles, seed).log_evidence()
    };
    [estimate, (evidence(h) - evidence(-h)) / (2.0 * h)]
}

fn differentiable() -> impl Iterator<Item = (Base, HeadConfig)> {
    let heads = HEADS.into_iter().filter(|head| !matches!(head, HeadConfig::Mixture { .. }));
    heads
        .chain([HeadConfig::Gaussian { covariance: Covariance::Diagonal }])
        .flat_map(|head| BASES.into_iter().map(move |base| (base, head)))
}

fn exact_with_one_particle<M: Equations>(model: &M, measurements: [&[f64]; 2]) {
    for (base, head) in differentiable() {
        let proposal = proposal(model, base, head);
        for number in 0..10 {
            let seed = Seed::from_u64(32).nth(number);
            let [found, expected] = slopes(model, &proposal, measurements, 1, &seed, Bug::Nothing);
            assert!(
                (found - expected).abs() < 1e-5 * (1.0 + expected.abs()),
                "{base:?}, {head:?}: {found} for {expected}"
            );
        }
    }
}

/// With one particle, path and score together are the derivative itself.
#[test]
fn path_and_score_are_the_derivative_of_the_evidence_of_one_particle() {
    exact_with_one_particle(&Linear, [&[0.4], &[-1.3]]);
    exact_with_one_particle(&Growth, [&[0.4], &[2.0]]);
    for noise in [Noise::HalfLine, Noise::Interval, Noise::HeavyTails] {
        exact_with_one_particle(&Awkward(noise), [&[3.0, 0.5], &[2.0, 1.1]]);
    }
}

/// How far the mean estimate is from the mean difference with the same random numbers, in standard errors.
fn score(head: HeadConfig, bug: Bug) -> f64 {
    let proposal = proposal(&Growth, Base::Transition, head);
    let differences: Vec<f64> = (0..20_000)
        .map(|number| {
            let seed = Seed::from_u64(33).nth(number);
            let [found, expected] = slopes(&Growth, &proposal, [&[0.4], &[2.0]], 3, &seed, bug);
            found - expected
        })
        .collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    mean / (variance / n).sqrt()
}

#[test]
fn the_mean_of_the_estimate_is_the_derivative_of_the_mean_log_evidence() {
    for head in [HEADS[0], HEADS[2]] {
        let z = score(head, Bug::Nothing);
        assert!(z.abs() < 4.0, "{head:?}: z = {z}");
    }
}

#[test]
fn wrong_estimates_are_caught() {
    for bug in [Bug::WeightsNotSquared, Bug::LikelihoodReversed] {
        let z = score(HEADS[0], bug);
        assert!(z.abs() > 4.0, "{bug:?}: z = {z}");
    }
}
