//! Unbiased evidence against the Kalman filter, whenever one resamples and on any number of threads.

use faer::mat;
use motes_models::{Gaussian, LinearGaussian, Measurements, Seed, kalman, simulate};
use motes_smc::{Bootstrap, FilterBank, FilterSettings, MinDegeneracy, Proposal, ResampleWhen, Resampling};

const RUNS: usize = 20_000;

fn reference() -> (LinearGaussian, Measurements, f64) {
    let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap();
    let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]]).unwrap();
    let measurements = simulate(&model, 5, &mut Seed::from_u64(70).stream()).unwrap().measurements;
    let exact = kalman::filter(&model, &measurements).unwrap().log_evidence();
    (model, measurements, exact)
}

/// How far the mean of `Ẑ/Z` over the runs is from 1, in standard errors.
fn z(
    proposal: impl Proposal<LinearGaussian> + Send,
    settings: FilterSettings,
    runs: usize,
    threads: usize,
) -> f64 {
    let (model, measurements, exact) = reference();
    let mut bank = FilterBank::new(&model, proposal, settings, runs, &Seed::from_u64(71)).unwrap();
    let pool = rayon_core::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| measurements.rows().for_each(|measurement| bank.step(measurement).unwrap()));
    let ratios: Vec<f64> = (0..runs).map(|run| (bank.log_evidence(run) - exact).exp()).collect();
    let n = runs as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - 1.0) / (variance / n).sqrt()
}

fn settings(when: ResampleWhen) -> FilterSettings {
    FilterSettings { resample_when: when, ..FilterSettings::new(64) }
}

#[test]
fn evidence_is_unbiased_whenever_one_resamples() {
    let (model, ..) = reference();
    for when in [ResampleWhen::Never, ResampleWhen::EssBelow(0.5), ResampleWhen::Always] {
        for threads in [1, 3] {
            let found = z(Bootstrap, settings(when), RUNS, threads);
            assert!(found.abs() < 4.0, "bootstrap, {when:?}, {threads} threads: z = {found}");
            let proposal = MinDegeneracy::new(&model).unwrap();
            let found = z(proposal, settings(when), RUNS, threads);
            assert!(found.abs() < 4.0, "minimum degeneracy, {when:?}, {threads} threads: z = {found}");
        }
    }
}

#[test]
fn evidence_is_unbiased_for_every_scheme() {
    for resampling in [Resampling::Systematic, Resampling::Stratified, Resampling::Residual] {
        let settings = FilterSettings { resampling, ..settings(ResampleWhen::Always) };
        let found = z(Bootstrap, settings, RUNS, 1);
        assert!(found.abs() < 4.0, "{resampling:?}: z = {found}");
    }
}

#[test]
fn evidence_of_filters_of_many_blocks_is_unbiased() {
    // Ten blocks of up to 1024 particles, the last of them short.
    let settings = FilterSettings { particles: 10_000, ..settings(ResampleWhen::Always) };
    let found = z(Bootstrap, settings, 200, 2);
    assert!(found.abs() < 4.0, "z = {found}");
}
