//! Errors shrink as 1/√K.

use motes_models::{LinearGaussian, Seed};
use motes_smc::{Bootstrap, FilterBank, FilterSettings, MinDegeneracy, Proposal, ResampleWhen};
use motes_tests::reference;

/// RMSE of the last mean and of log Ẑ over 400 runs with `particles` particles.
fn errors<P: Proposal<LinearGaussian> + Clone>(proposal: &P, particles: usize) -> [f64; 2] {
    let (reference, runs) = (reference(), 400);
    let settings =
        FilterSettings { resample_when: ResampleWhen::EssBelow(0.5), ..FilterSettings::new(particles) };
    let seed = Seed::from_u64(30).nth(particles as u64);
    let mut bank = FilterBank::new(&reference.model, proposal.clone(), settings, runs, &seed).unwrap();
    for measurement in reference.measurements.rows() {
        bank.step(measurement).unwrap();
    }
    let mut sums = [0.0; 2];
    for run in 0..runs {
        let mut mean = [0.0];
        bank.mean(run, &mut mean);
        sums[0] += (mean[0] - reference.last_mean).powi(2);
        sums[1] += (bank.log_evidence(run) - reference.log_evidence).powi(2);
    }
    sums.map(|sum| (sum / runs as f64).sqrt())
}

/// The least-squares slope of log error on log K.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let covariance: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    covariance / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

fn assert_converges<P: Proposal<LinearGaussian> + Clone>(proposal: &P) {
    let sizes = [64, 128, 256, 512, 1024, 2048];
    let errors: Vec<[f64; 2]> = sizes.iter().map(|&k| errors(proposal, k)).collect();
    for kind in 0..2 {
        let points: Vec<(f64, f64)> =
            sizes.iter().zip(&errors).map(|(&k, e)| ((k as f64).ln(), e[kind].ln())).collect();
        let slope = slope(&points);
        assert!((slope + 0.5).abs() < 0.06, "slope {slope} from {points:?}");
    }
    assert!(errors[5][0] <= 0.030, "RMSE of the mean at K = 2048 is {}", errors[5][0]);
}

#[test]
fn bootstrap() {
    assert_converges(&Bootstrap);
}

#[test]
fn minimum_degeneracy() {
    assert_converges(&MinDegeneracy::new(&reference().model).unwrap());
}
