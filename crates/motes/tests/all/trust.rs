//! A log-evidence comes with its standard error, and a wrong one with a warning; linear Gaussian models have exact answers.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use motes::output::filter_json;
use motes::{Data, FilterOptions, Filtered, Model, MotesError, ProposalName, Running, filter, smooth};

/// The exact log-evidence of the jump, and of the seasonal cycle.
const OF_JUMP: f64 = -94.481854;
const OF_CYCLE: f64 = 151.279481;

fn open(folder: &str) -> (Model, Data) {
    let home: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(folder);
    let model = Model::read(&home.join("model.toml"), &[]).unwrap();
    let data = Data::open(&home.join("data.csv"), &model).unwrap();
    (model, data)
}

fn filtered(model: &Model, data: &Data, options: &FilterOptions) -> Filtered {
    filter(model, data, options, |_| ControlFlow::Continue(())).unwrap()
}

fn texts(filtered: &Filtered) -> Vec<String> {
    filtered.warnings.iter().map(ToString::to_string).collect()
}

#[test]
fn a_jump_that_the_model_does_not_know_is_warned_of_by_the_particles_alone() {
    let (model, data) = open("jump");
    for proposal in [ProposalName::Bootstrap, ProposalName::Optimal] {
        for particles in [100, 1000, 10_000] {
            for seed in 1..=3 {
                let options =
                    FilterOptions { proposal: proposal.clone(), particles, seed, ..Default::default() };
                let found = filtered(&model, &data, &options);
                assert!(found.log_evidence() < OF_JUMP - 5.0, "{}", found.log_evidence());
                let texts = texts(&found);
                let named =
                    texts.iter().any(|text| text.contains("(y = ") && text.contains("beyond all particles"));
                assert!(named, "{proposal}, {particles}, {seed}: {texts:?}");
                // The Kalman filter says so, too.
                assert!(texts.iter().any(|text| text.contains("is off by")), "{texts:?}");
                let exact = found.exact_log_evidence_per_series[0].unwrap();
                assert!((exact - OF_JUMP).abs() < 1e-5, "{exact}");
            }
        }
    }
}

#[test]
fn constants_that_ran_out_of_values_are_named() {
    let (model, data) = open("cycle");
    for seed in 1..=3 {
        let options = FilterOptions { seed, ..FilterOptions::default() };
        let texts = texts(&filtered(&model, &data, &options));
        for state in ["state a hardly moves", "state b hardly moves"] {
            assert!(texts.iter().any(|text| text.starts_with(state)), "{texts:?}");
        }
        assert!(!texts.iter().any(|text| text.starts_with("state level")), "{texts:?}");
    }
}

#[test]
fn the_exact_proposal_answers_by_the_kalman_filter_and_smoother() {
    let options = FilterOptions { proposal: ProposalName::Exact, ..FilterOptions::default() };
    let (model, data) = open("jump");
    let found = filtered(&model, &data, &options);
    assert!((found.log_evidence() - OF_JUMP).abs() < 1e-5 && found.standard_error() == Some(0.0));
    let (model, data) = open("cycle");
    let found = filtered(&model, &data, &options);
    assert!((found.log_evidence() - OF_CYCLE).abs() < 1e-5, "{}", found.log_evidence());
    let last = &found.estimates.last().unwrap().state;
    let expected = [(0.215976, 0.045051), (0.127881, 0.010414), (0.196805, 0.010509)];
    for (coordinate, (mean, sd)) in last.iter().zip(expected) {
        assert!((coordinate.mean - mean).abs() < 1e-5 && (coordinate.sd - sd).abs() < 1e-5, "{coordinate:?}");
        let [low, middle, high] = coordinate.quantiles[..] else { panic!("three quantiles") };
        assert!((middle - mean).abs() < 1e-5 && (high - low - 2.0 * 1.644854 * sd).abs() < 1e-4);
    }
    assert!(found.warnings.is_empty() && found.estimates[0].ess.is_none());

    let paths = 2000;
    let smoothed = smooth(&model, &data, &options, paths, |_| ControlFlow::Continue(())).unwrap();
    let expected = [(-0.026976, 0.045006), (0.209151, 0.010414), (0.106498, 0.010509)];
    for (at, (mean, sd)) in expected.into_iter().enumerate() {
        let coordinate = &smoothed.estimates[0].state[at];
        assert!((coordinate.mean - mean).abs() < 2e-5 && (coordinate.sd - sd).abs() < 2e-5, "{coordinate:?}");
        // Trajectories have these moments within four of their standard errors.
        let of_paths = &smoothed.paths[0];
        let error = sd / (paths as f64).sqrt();
        assert!((of_paths.mean(0, at) - coordinate.mean).abs() < 4.0 * error);
        let deviation = of_paths.standard_deviation(0, at);
        assert!((deviation - coordinate.sd).abs() < 4.0 * error / 2.0_f64.sqrt(), "{deviation}");
    }
}

#[test]
fn a_model_without_exact_answers_says_what_to_take() {
    let text = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(sin(x), 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    let model = Model::parse(text, "waves", &[]).unwrap();
    let options = FilterOptions { proposal: ProposalName::Exact, ..FilterOptions::default() };
    let refused = Running::new(&model, &options, 0).err().unwrap();
    let expected = "--proposal exact: waves is neither linear with Gaussian noise nor a model of discrete states; take --proposal linearised or bootstrap";
    assert_eq!(refused.to_string(), expected);
    assert!(matches!(refused, MotesError::Proposal { .. }));
}

#[test]
fn a_sound_filter_has_an_honest_error_and_no_warning() {
    let text = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(0.9*x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    let model = Model::parse(text, "walk", &[]).unwrap();
    let drawn = motes::simulate(&model, 100, 1, 3, |_| ControlFlow::Continue(())).unwrap();
    let rows: String = drawn.series[0].measurements.values().iter().map(|y| format!("{y}\n")).collect();
    let data = Data::read(format!("y\n{rows}").as_bytes(), "y.csv", &model).unwrap();
    let (mut within, mut square, runs) = (0, 0.0, 40);
    for seed in 0..runs {
        let found = filtered(&model, &data, &FilterOptions { seed, ..FilterOptions::default() });
        let error = found.standard_error().unwrap();
        let off = found.log_evidence() - found.exact_log_evidence_per_series[0].unwrap();
        within += u32::from(off.abs() < 2.0 * error);
        square += off * off / (error * error);
        // The Kalman filter may notice one that is off by more than usual.
        let of_particles = texts(&found).into_iter().find(|text| !text.contains("Kalman"));
        assert_eq!(of_particles, None);
    }
    // Two standard errors hold 95 % of 40, four standard deviations of that count away at the least; their mean square is 1 ± 4√(2/40).
    assert!(within >= 33, "{within}");
    assert!((0.1..1.9).contains(&(square / runs as f64)), "{}", square / runs as f64);
}

#[test]
fn what_cannot_be_estimated_is_null_and_said() {
    let text = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    let model = Model::parse(text, "walk", &[]).unwrap();
    let read = |text: &str| Data::read(text.as_bytes(), "y.csv", &model).unwrap();
    for particles in [1, 2, 3] {
        let options = FilterOptions { particles, ..FilterOptions::default() };
        let found = filtered(&model, &read("y\n0.3\n0.5\n"), &options);
        assert_eq!((found.standard_error(), found.standard_error_per_series.len()), (None, 1));
        assert!(filter_json(&found, &options, 0.0).contains("\"standard_error\":null"));
        if particles == 1 {
            assert!(found.estimates[0].state[0].sd.is_nan(), "one particle has no spread");
        }
    }
    let options = FilterOptions::default();
    let one = filtered(&model, &read("y\n0.3\n"), &options);
    assert!(one.standard_error().is_some_and(|error| error > 0.0 && error < 0.2));
    let missing = filtered(&model, &read("y\nNA\nNA\n"), &options);
    assert_eq!((missing.log_evidence(), missing.standard_error()), (0.0, Some(0.0)));
    let unchecked = filtered(&model, &read("y\n0.3\n"), &FilterOptions { check: false, ..options.clone() });
    assert_eq!(unchecked.standard_error(), None);
    assert_eq!(unchecked.estimates, one.estimates, "a check changes no estimate");
}

/// The measurement weighs each particle well; what it does not see would be an estimate that is no number.
#[test]
fn an_index_beyond_a_list_is_named_where_no_measurement_sees_it() {
    let text = "[parameters]\ng = [0.1, 0.2]\n[initial]\nx = \"normal(0, 1)\"\nk = 0\nz = 0\n[transition]\nx = \"normal(x, 1)\"\nk = \"k + 1\"\nz = \"z + g[k]\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    let model = Model::parse(text, "lists.toml", &[]).unwrap();
    let data = Data::read("y\n0.1\n0.2\n0.3\n0.4\n".as_bytes(), "y.csv", &model).unwrap();
    let error = filter(&model, &data, &FilterOptions::default(), |_| ControlFlow::Continue(())).unwrap_err();
    let reason =
        "lists.toml, line 10, [transition] z: an index of g[k], `k`, is 2; it must be an integer from 0 to 1";
    assert!(error.to_string().ends_with(reason), "{error}");
}
