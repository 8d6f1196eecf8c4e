//! Evidence is unbiased, whatever the weights are: every head and base, with gaps, against Kalman and quadrature.

use faer::mat;
use motes_models::equations::Equations;
use motes_models::{
    Gaussian, LinearGaussian, PartialMeasurements, Seed, StateSpaceModel, Step, kalman, simulate,
};
use motes_proposals::{Amortised, AmortisedConfig, Base, HeadConfig, Sees};
use motes_smc::{FilterBank, FilterSettings, ResampleWhen};

use crate::conditional::{BASES, HEADS, random, random_of};
use crate::learning::learned;
use crate::models::{Awkward, Linear, Noise};

/// How far the mean of `Ẑ/Z` is from 1, in standard errors, with a defensive share of 0.1.
fn score<M: Equations>(
    model: &M,
    proposal: &Amortised,
    when: ResampleWhen,
    rows: &[Vec<Option<f64>>],
    exact: f64,
) -> f64 {
    let runs = 1000;
    let settings =
        FilterSettings { resample_when: when, defensive_weight: Some(0.1), ..FilterSettings::new(32) };
    let mut bank = FilterBank::new(model, proposal.clone(), settings, runs, &Seed::from_u64(12)).unwrap();
    rows.iter().enumerate().for_each(|(at, row)| bank.step_at(&Step::of_index(at), row).unwrap());
    let ratios: Vec<f64> = (0..runs).map(|run| (bank.log_evidence(run) - exact).exp()).collect();
    let n = runs as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - 1.0) / (variance / n).sqrt()
}

/// Each base and head with random weights, and one that was learned, under all rules of resampling in turn.
fn unbiased<M: Equations>(model: &M, rows: &[Vec<Option<f64>>], exact: f64) {
    let rules = [ResampleWhen::Never, ResampleWhen::EssBelow(0.5), ResampleWhen::Always];
    let pairs: Vec<(Base, HeadConfig)> =
        BASES.into_iter().flat_map(|base| HEADS.map(|head| (base, head))).collect();
    let mut proposals: Vec<(String, Amortised)> = Vec::new();
    for (base, head) in pairs {
        proposals.push((format!("{base:?}, {head:?}"), random(model, base, head, 0.15)));
    }
    for (base, head) in BASES.into_iter().zip(HEADS) {
        let config = AmortisedConfig {
            widths: vec![4, 4],
            sees: Sees::Graph { order: 1 },
            base,
            head,
            ..AmortisedConfig::gaussian()
        };
        proposals.push((format!("{base:?}, {head:?}, graph"), random_of(model, config, 0.15)));
    }
    proposals.push(("learned".into(), learned(model, Base::Linearised, HEADS[1], 100).0));
    for (number, (name, proposal)) in proposals.iter().enumerate() {
        let when = rules[number % 3];
        let z = score(model, proposal, when, rows, exact);
        assert!(z.abs() < 4.0, "{name}, {when:?}: z = {z}");
    }
}

#[test]
fn of_a_linear_model_it_is_the_kalman_filters() {
    let matrices = LinearGaussian::new(
        Gaussian::new("P_0", vec![0.0; 2], mat![[1.0, 0.0], [0.0, 1.0]]).unwrap(),
        mat![[0.9, 0.2], [0.0, 0.7]],
        mat![[0.49, 0.0], [0.0, 1.21]],
        mat![[1.0, 0.5]],
        mat![[0.25]],
    )
    .unwrap();
    let data = simulate(&Linear, 5, &mut Seed::from_u64(13).stream()).unwrap().measurements;
    let mut rows: Vec<Vec<Option<f64>>> = data.rows().map(|row| vec![Some(row[0])]).collect();
    rows[3][0] = None;
    let partial = PartialMeasurements::new(1, rows.concat()).unwrap();
    let exact = kalman::filter_partial(&matrices, &partial).unwrap().log_evidence();
    unbiased(&Linear, &rows, exact);
}

/// The exact log-evidence by quadrature; cells of the grid weigh what they overlap of a bounded transition.
fn by_quadrature(model: &Awkward, rows: &[Vec<Option<f64>>]) -> f64 {
    const POINTS: usize = 3001;
    let (low, step) = (-9.0, 0.006);
    let grid: Vec<f64> = (0..POINTS).map(|i| low + step * i as f64).collect();
    let mut density: Vec<f64> = grid
        .iter()
        .map(|x| model.density().unwrap().log_density(&Step::of_index(0), None, &[*x]).exp())
        .collect();
    for (time, row) in rows.iter().enumerate() {
        if time > 0 {
            density = grid
                .iter()
                .map(|x| {
                    let into = |(from, before): (&f64, &f64)| match *before > 1e-14 {
                        true => {
                            before
                                * model
                                    .density()
                                    .unwrap()
                                    .log_density(&Step::of_index(1), Some(&[*from]), &[*x])
                                    .exp()
                        }
                        false => 0.0,
                    };
                    grid.iter().zip(&density).map(into).sum::<f64>() * step
                })
                .collect();
        }
        for (density, x) in density.iter_mut().zip(&grid) {
            let mut out = [0.0];
            model.log_likelihoods(&Step::of_index(time), &[*x], row, &mut out).unwrap();
            *density *= out[0].exp();
        }
    }
    (density.iter().sum::<f64>() * step).ln()
}

#[test]
fn of_bounded_noise_and_heavy_tails_it_is_that_of_quadrature() {
    let rows = [[Some(3.0), None], [Some(0.0), Some(1.4)], [Some(4.0), Some(-1.0)], [None, Some(0.3)]];
    let rows = rows.map(Vec::from);
    for noise in [Noise::HalfLine, Noise::Interval, Noise::HeavyTails] {
        let model = Awkward(noise);
        unbiased(&model, &rows, by_quadrature(&model, &rows));
    }
}
