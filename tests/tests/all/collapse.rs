//! Why a proposal trained without an entropy term looks superb at the last time and poor before it.

use std::ops::ControlFlow;

use motes_models::kalman::{self, Belief};
use motes_models::{GraphDiffusion, GraphDiffusionConfig, Measurements, ModelShape, Seed, simulate};
use motes_proposals::{Backend, Family, Fcnn, FcnnConfig};
use motes_smc::{FilterBank, FilterSettings};
use motes_train::{TrainConfig, train};

const HORIZON: usize = 12;

/// `Σ_t ‖estimate_t − mean_t‖² / Σ_t ‖mean_t‖²`, and the same at the last time alone.
fn errors<'a>(estimates: &[Vec<f64>], beliefs: impl Iterator<Item = &'a Belief>) -> [f64; 2] {
    let terms: Vec<[f64; 2]> = estimates
        .iter()
        .zip(beliefs)
        .map(|(estimate, belief)| {
            let pairs = estimate.iter().zip(belief.mean.iter());
            pairs.fold([0.0; 2], |[d, m], (e, x)| [d + (e - x) * (e - x), m + x * x])
        })
        .collect();
    let all = terms.iter().fold([0.0; 2], |[d, m], [e, x]| [d + e, m + x]);
    let last = terms[HORIZON - 1];
    [all[0] / all[1], last[0] / last[1]]
}

/// The averaged estimates of 50 filters with a trained proposal, and their mean effective sample size.
fn estimates(system: &GraphDiffusion, measurements: &Measurements) -> (Vec<Vec<f64>>, f64) {
    let (seed, filters, particles) = (Seed::from_u64(90), 50, 20);
    let config = FcnnConfig { widths: vec![64, 128], ..FcnnConfig::paper() };
    let mut proposal = Fcnn::create(
        &config,
        &ModelShape::of(system),
        HORIZON,
        Backend::Native.into(),
        &seed.child("weights"),
    )
    .unwrap();
    let config = TrainConfig { steps: 400, ..TrainConfig::paper(particles) };
    let mut stream = seed.child("training").stream();
    train(&mut proposal, system, measurements, &config, &mut stream, |_, _| ControlFlow::Continue(()))
        .unwrap();
    let settings = FilterSettings::new(particles);
    let mut bank = FilterBank::new(system, proposal, settings, filters, &seed.child("filter")).unwrap();
    let (mut found, mut effective) = (vec![], 0.0);
    for measurement in measurements.rows() {
        bank.step(measurement).unwrap();
        let (mut average, mut mean) = (vec![0.0; 10], vec![0.0; 10]);
        for filter in 0..filters {
            bank.mean(filter, &mut mean);
            average.iter_mut().zip(&mean).for_each(|(sum, value)| *sum += value / filters as f64);
            effective += bank.weights(filter).effective_sample_size() / (filters * HORIZON) as f64;
        }
        found.push(average);
    }
    (found, effective)
}

#[test]
fn the_likelihood_alone_leads_to_the_smoothed_trajectory() {
    let seed = Seed::from_u64(91);
    let system =
        GraphDiffusion::random(&GraphDiffusionConfig::new(10), &mut seed.child("graph").stream()).unwrap();
    let measurements = simulate(&system, HORIZON, &mut seed.child("data").stream()).unwrap().measurements;
    let model = system.moment_matched().unwrap();
    let filtered = kalman::filter(&model, &measurements).unwrap();
    let smoothed = kalman::smooth(&filtered).unwrap();

    let (collapsed, effective) = estimates(&system, &measurements);
    let [to_filtered, last] = errors(&collapsed, filtered.steps.iter().map(|step| &step.filtered));
    let [to_smoothed, _] = errors(&collapsed, smoothed.beliefs.iter());
    println!(
        "over all times {to_filtered:.1e} from filtered means and {to_smoothed:.1e} from smoothed means"
    );
    println!("at the last time {last:.1e}; effective sample size {effective:.1} of 20");
    // The estimates are those of hindsight, which at the last time is no hindsight.
    assert!(to_smoothed < 0.01 * to_filtered && last < 0.01 * to_filtered);
    assert!(effective < 5.0);
}
