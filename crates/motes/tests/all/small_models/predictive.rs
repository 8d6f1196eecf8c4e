//! Measurements predicted from those before them: one step ahead, and after the last.

use std::ops::ControlFlow;
use std::sync::Arc;

use motes::smc::Predictive;
use motes::{Data, FilterOptions, Filtered, Model, ProposalName, filter, simulate};

fn filtered(model: &Model, data: &Data, options: &FilterOptions) -> Filtered {
    filter(model, data, options, |_| ControlFlow::Continue(())).unwrap()
}

fn of_proposal(proposal: ProposalName, particles: usize) -> FilterOptions {
    FilterOptions { proposal, particles, predictive: true, ..Default::default() }
}

const DESIGNED: [ProposalName; 3] = ProposalName::DESIGNED;

/// What is expected of one measurement in each row.
fn rows(found: &Filtered) -> Vec<Predictive> {
    found.estimates.iter().map(|estimate| estimate.predictive[0].clone()).collect()
}

const WALK: &str = r#"
[initial]
x = "normal(0.3, 1)"
[transition]
x = "normal(0.9*x, 0.5)"
[measurement]
y = "normal(2*x + 1, 0.7)"
"#;

/// Φ by its error function.
fn normal_cdf(z: f64) -> f64 {
    special::Error::compl_error(-z / std::f64::consts::SQRT_2) / 2.0
}

/// The Kalman filter of the walk by hand: mean, standard deviation and place of each measurement.
fn by_hand(values: &[Option<f64>]) -> Vec<[f64; 3]> {
    let (mut mean, mut variance) = (0.3_f64, 1.0_f64);
    let of_row = |(row, value): (usize, &Option<f64>)| {
        if row > 0 {
            (mean, variance) = (0.9 * mean, 0.81 * variance + 0.25);
        }
        let (expected, spread) = (2.0 * mean + 1.0, 4.0 * variance + 0.49);
        let place = value.map_or(f64::NAN, |value| normal_cdf((value - expected) / spread.sqrt()));
        if let Some(value) = value {
            let gain = 2.0 * variance / spread;
            (mean, variance) = (mean + gain * (value - expected), variance - gain * 2.0 * variance);
        }
        [expected, spread.sqrt(), place]
    };
    values.iter().enumerate().map(of_row).collect()
}

/// Catches weights that have seen the measurement that they are to predict: the proposals' own weights have.
#[test]
fn measurements_are_predicted_by_those_before_them() {
    let model = Model::parse(WALK, "walk", &[]).unwrap();
    let values = [Some(0.4), Some(4.1), None, Some(-1.0), Some(2.2), Some(0.1)];
    let cells: Vec<String> = values.iter().map(|v| v.map_or("NA".into(), |v: f64| v.to_string())).collect();
    let data = Data::read(format!("y\n{}\n", cells.join("\n")).as_bytes(), "d.csv", &model).unwrap();
    let expected = by_hand(&values);
    let exact = filtered(&model, &data, &of_proposal(ProposalName::Exact, 1));
    for (row, [mean, sd, place]) in rows(&exact).iter().zip(&expected) {
        assert!((row.mean - mean).abs() < 1e-12 && (row.sd - sd).abs() < 1e-12, "{row:?}");
        assert!(row.pit.is_none_or(|pit| (pit - place).abs() < 1e-12), "{row:?}: {place}");
        assert_eq!(row.pit.is_none(), place.is_nan());
    }
    for proposal in DESIGNED {
        let found = filtered(&model, &data, &of_proposal(proposal.clone(), 20_000));
        for (row, [mean, sd, place]) in rows(&found).iter().zip(&expected) {
            // Effective sizes are thousands, and only the state's part of the spread is drawn.
            assert!((row.mean - mean).abs() < 0.05 * sd, "{proposal}: {row:?} for {mean}");
            assert!((row.sd / sd - 1.0).abs() < 0.03, "{proposal}: {row:?} for {sd}");
            assert!((row.quantiles[0] - (mean - 1.6449 * sd)).abs() < 0.1 * sd, "{proposal}: {row:?}");
            assert_eq!(row.pit.is_none(), place.is_nan());
            assert!(row.pit.is_none_or(|pit| (pit - place).abs() < 0.015), "{proposal}: {row:?} for {place}");
        }
        // It is beside the filter: nothing else changes.
        let without = FilterOptions { predictive: false, ..of_proposal(proposal, 20_000) };
        let without = filtered(&model, &data, &without);
        assert_eq!(found.log_evidence().to_bits(), without.log_evidence().to_bits());
        assert!(found.estimates.iter().zip(&without.estimates).all(|(a, b)| a.state == b.state));
    }
}

/// A count has a probability of its own, of which one half counts.
#[test]
fn the_place_of_a_count_is_in_the_middle_of_its_probability() {
    let text = "[initial]\nx = 0.5\n[transition]\nx = \"normal(x, 0.1)\"\n[measurement]\ny = \"poisson(20*exp(x))\"\n";
    let model = Model::parse(text, "counts", &[]).unwrap();
    let data = Data::read("y\n35\n31\n".as_bytes(), "d.csv", &model).unwrap();
    let mean = 20.0 * 0.5_f64.exp();
    let (mut probability, mut below) = ((-mean).exp(), 0.0);
    for count in 1..=35 {
        below += probability;
        probability *= mean / f64::from(count);
    }
    for proposal in [ProposalName::Bootstrap, ProposalName::Linearised] {
        let row = rows(&filtered(&model, &data, &of_proposal(proposal, 100)))[0].clone();
        assert!((row.mean - mean).abs() < 1e-9 && (row.sd - mean.sqrt()).abs() < 1e-9, "{row:?}");
        assert!((row.pit.unwrap() - below - probability / 2.0).abs() < 1e-9, "{row:?}");
    }
}

/// Kolmogorov and Smirnov: of data of the model itself places are uniform, at any proposal.
#[test]
fn places_are_uniform_where_the_model_is_right() {
    let text = r#"
[initial]
h = "normal(-1, 0.7)"
[transition]
h = "normal(-1 + 0.95*(h + 1), 0.25)"
[measurement]
r = "normal(0, exp(h/2))"
"#;
    let model = Model::parse(text, "volatility", &[]).unwrap();
    let drawn = simulate(&model, 800, 1, 5, |_| ControlFlow::Continue(())).unwrap();
    let table = motes::output::simulated_table(&model, &drawn);
    let data = Data::read(table.as_bytes(), "d.csv", &model).unwrap();
    for proposal in [ProposalName::Bootstrap, ProposalName::Linearised] {
        let found = filtered(&model, &data, &of_proposal(proposal.clone(), 1000));
        let mut places: Vec<f64> = rows(&found).iter().filter_map(|row| row.pit).collect();
        places.sort_by(f64::total_cmp);
        let n = places.len() as f64;
        let off = |(at, place): (usize, &f64)| (place - (at as f64 + 0.5) / n).abs() + 0.5 / n;
        let largest = places.iter().enumerate().map(off).fold(0.0, f64::max);
        // Larger ones come once in a thousand times.
        assert!(largest * n.sqrt() < 1.95, "{proposal}: {largest}");
        let spread = places.iter().map(|place| (place - 0.5) * (place - 0.5)).sum::<f64>() / n;
        assert!((spread * 12.0 - 1.0).abs() < 0.15, "{proposal}: {spread}");
    }
}

/// An angle has no mean where numbers a turn apart are the same: what is given is a direction.
#[test]
fn angles_are_turned_to_their_mean_direction() {
    let text =
        "[initial]\nx = \"pi - 0.05\"\n[transition]\nx = \"x\"\n[measurement]\nb = \"von_mises(x, 50)\"\n";
    let model = Model::parse(text, "bearing", &[]).unwrap();
    // The last two are the same angle, below the mean direction.
    let data = Data::read("b\n3.0915926\n-3.0415927\n3.0\n9.2831853\n".as_bytes(), "d.csv", &model).unwrap();
    let found = rows(&filtered(&model, &data, &of_proposal(ProposalName::Bootstrap, 20_000)));
    // κ = 50 is nearly normal with a variance of 1/50.
    let sd = (1.0 / 49.5_f64).sqrt();
    for (row, off) in found.iter().zip([0.0, 0.15, -0.0916, -0.0916]) {
        assert!((row.mean - (std::f64::consts::PI - 0.05)).abs() < 0.01, "{row:?}");
        assert!((row.sd / sd - 1.0).abs() < 0.03, "{row:?}");
        assert!((row.pit.unwrap() - normal_cdf(off / sd)).abs() < 0.02, "{row:?} at {off}");
    }
}

/// What has no moments, and what cannot be drawn, is no number.
#[test]
fn what_nobody_can_say_is_empty() {
    let text = r#"
[initial]
x = "normal(0, 1)"
[transition]
x = "normal(x, 1)"
[measurement]
a = "student_t(1.5, x, 1)"
b = "log_density(-(b - x)^2/2)"
c = "floored(rounded(normal(x, 1)), 1e-9)"
"#;
    let model = Model::parse(text, "odd", &[]).unwrap();
    let data = Data::read("a,b,c\n0.5,0.5,1\n1,1,0\n".as_bytes(), "d.csv", &model).unwrap();
    let found = filtered(&model, &data, &of_proposal(ProposalName::Bootstrap, 5000));
    let [a, b, c] = &found.estimates[0].predictive[..] else { panic!("three entries") };
    assert!(a.mean.is_finite() && a.sd.is_nan() && a.quantiles[2].is_finite() && a.pit.is_some(), "{a:?}");
    assert!(b.mean.is_nan() && b.sd.is_nan() && b.quantiles[1].is_nan() && b.pit.is_none(), "{b:?}");
    // Two normal variances and that of rounding: P(Y < 1) + ½ P(Y = 1).
    let sd = 2.0_f64.sqrt();
    let place = 0.5 * (normal_cdf(0.5 / sd) + normal_cdf(1.5 / sd));
    assert!(c.mean.abs() < 0.1 && (c.sd - (2.0 + 1.0 / 12.0_f64).sqrt()).abs() < 0.06, "{c:?}");
    assert!((c.pit.unwrap() - place).abs() < 0.02, "{c:?} for {place}");
}

#[test]
fn forecasts_say_what_will_be_measured() {
    let model = Model::parse(WALK, "walk", &[]).unwrap();
    let data = Data::read("y\n0.4\n4.1\n".as_bytes(), "d.csv", &model).unwrap();
    let expected = by_hand(&[Some(0.4), Some(4.1), None, None]);
    for proposal in DESIGNED.into_iter().chain([ProposalName::Exact]) {
        let options = FilterOptions { forecast: 2, predictive: false, ..of_proposal(proposal, 20_000) };
        let found = filtered(&model, &data, &options);
        assert!(found.estimates.iter().all(|estimate| estimate.predictive.is_empty()));
        for (forecast, [mean, sd, _]) in found.forecasts[0].iter().zip(&expected[2..]) {
            let [row] = &forecast.estimate.predictive[..] else { panic!("one entry") };
            assert!((row.mean - mean).abs() < 0.05 * sd && (row.sd / sd - 1.0).abs() < 0.03, "{row:?}");
            for (found, z) in row.quantiles.iter().zip([-1.6449, 0.0, 1.6449]) {
                assert!((found - mean - z * sd).abs() < 0.08 * sd, "{row:?}");
            }
            assert_eq!(row.pit, None);
        }
    }
}

/// A measurement that needs an input of its row has a forecast where the input is given.
#[test]
fn a_forecast_without_an_input_of_its_measurement_is_empty_and_says_so() {
    let text = "[inputs]\nn = \"hold\"\n[initial]\nx = \"normal(0, 0.1)\"\n[transition]\nx = \"normal(x, 0.1)\"\n[measurement]\ny = \"binomial(n, logistic(x))\"\nz = \"normal(x, 1)\"\n";
    let model = Model::parse(text, "tested", &[]).unwrap();
    let data = Data::read("n,y,z\n10,4,0.1\n20,11,0.3\n".as_bytes(), "d.csv", &model).unwrap();
    let options = FilterOptions { forecast: 2, ..of_proposal(ProposalName::Bootstrap, 2000) };
    let found = filtered(&model, &data, &options);
    for forecast in &found.forecasts[0] {
        let [y, z] = &forecast.estimate.predictive[..] else { panic!("two entries") };
        assert!(y.mean.is_nan() && y.quantiles[1].is_nan() && z.mean.is_finite(), "{y:?} {z:?}");
        assert!(forecast.estimate.state[0].sd.is_finite());
    }
    let expected = "forecasts of measurements that need the input n are empty: it is not known ahead; give its values by --inputs";
    let said: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|warning| warning == expected), "{said:?}");
    let ahead = Data::read("n,y,z\n30,,\n50,,\n".as_bytes(), "ahead.csv", &model).unwrap();
    let options = FilterOptions { forecast: 0, ahead: Some(Arc::new(ahead)), ..options };
    let found = filtered(&model, &data, &options);
    assert!(found.warnings.iter().all(|warning| warning.to_string() != expected));
    for (forecast, n) in found.forecasts[0].iter().zip([30.0, 50.0]) {
        let y = &forecast.estimate.predictive[0];
        assert!((y.mean / n - 0.5).abs() < 0.1 && y.quantiles[0] < y.mean, "{y:?}");
    }
}
