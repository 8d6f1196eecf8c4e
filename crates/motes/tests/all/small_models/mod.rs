//! Small models of all kinds with exact answers: counts, regimes, known starts, coordinates without noise, shared draws, lists, conditions, delays, inputs, irregular
//! times, sub-steps.

mod evidence;
mod predictive;
mod reports;
mod shipped;

use std::ops::ControlFlow;
use std::path::Path;

use motes::{
    Data, EvidenceOptions, FilterOptions, Filtered, Model, ProposalName, designed, evidence, filter, smooth,
};

/// A model with its data, the exact log-evidence, and the exact mean of a state at the last row.
struct SmallModel {
    folder: &'static str,
    log_evidence: f64,
    state: usize,
    last_mean: f64,
}

/// By sums over all counts, the forward algorithm, Kalman filters and quadrature.
const MODELS: [SmallModel; 16] = [
    SmallModel { folder: "chain-binomial", log_evidence: -13.400815, state: 0, last_mean: 3.529766 },
    SmallModel { folder: "two-regimes", log_evidence: -10.305918, state: 0, last_mean: 0.07405 },
    SmallModel { folder: "known-start", log_evidence: -15.125251, state: 0, last_mean: 0.113320 },
    SmallModel { folder: "constant-velocity", log_evidence: -3.897144, state: 1, last_mean: 0.576686 },
    SmallModel { folder: "shared-noise", log_evidence: -8.191824, state: 0, last_mean: 6.231467 },
    SmallModel { folder: "leverage", log_evidence: -12.356181, state: 0, last_mean: 0.051608 },
    SmallModel { folder: "gains", log_evidence: -30.249213, state: 0, last_mean: -0.017995 },
    SmallModel { folder: "leak", log_evidence: 6.312460, state: 0, last_mean: 1.514037 },
    SmallModel { folder: "regressor", log_evidence: -1.713740, state: 0, last_mean: 0.252081 },
    SmallModel { folder: "cart", log_evidence: 2.571567, state: 0, last_mean: 0.308993 },
    SmallModel { folder: "sub-steps", log_evidence: -8.527974, state: 1, last_mean: 3.091025 },
    SmallModel { folder: "irregular", log_evidence: 1.511210, state: 0, last_mean: 2.959446 },
    SmallModel { folder: "surveys", log_evidence: -9.361729, state: 0, last_mean: 1.888761 },
    SmallModel { folder: "days", log_evidence: -4.739309, state: 0, last_mean: 2.210098 },
    SmallModel { folder: "animals", log_evidence: -3.795256, state: 0, last_mean: -1.167161 },
    SmallModel { folder: "delay-line", log_evidence: -12.861669, state: 0, last_mean: 9.170960 },
];

impl SmallModel {
    fn open(&self) -> (Model, Data) {
        let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models").join(self.folder);
        let model = Model::read(&home.join("model.toml"), &[]).unwrap();
        let data = Data::open(&home.join("data.csv"), &model).unwrap();
        (model, data)
    }

    fn check(&self, proposal: &ProposalName, found: &Filtered) {
        let error = found.log_evidence() - self.log_evidence;
        let standard_error = found.standard_error().unwrap();
        let last = found.estimates.last().unwrap();
        let state = &last.state[self.state];
        let mean = state.mean - self.last_mean;
        println!(
            "{}, {proposal}: off by {error:.3} ± {standard_error:.3}, last mean by {mean:.4}",
            self.folder
        );
        assert!(error.abs() < 4.0 * standard_error + 0.005, "{}, {proposal}", self.folder);
        assert!(mean.abs() < 0.1 * state.sd, "{}, {proposal}: {mean}", self.folder);
    }
}

/// By every proposal that a model has: bootstrap and linearised, optimal where there is a closed form.
#[test]
fn particles_find_the_exact_answers() {
    for of in &MODELS {
        let (model, data) = of.open();
        for proposal in designed(&model, &FilterOptions::default()) {
            let options =
                FilterOptions { proposal: proposal.clone(), particles: 20_000, ..Default::default() };
            let found = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap();
            of.check(&proposal, &found);
        }
    }
}

/// Potentials of all data, in noise space: of counts, regimes, shared draws, sub-steps and gaps alike.
#[test]
fn looking_ahead_finds_the_exact_evidence() {
    for of in &MODELS {
        let (model, data) = of.open();
        let proposal = Some(ProposalName::LookAhead);
        let options = EvidenceOptions { proposal, particles: 5000, ..EvidenceOptions::default() };
        let found = evidence(&model, &data, &options, || ControlFlow::Continue(())).unwrap();
        let (off, error) = (found.log_evidence() - of.log_evidence, found.standard_error().unwrap());
        println!("{}: off by {off:.4} ± {error:.4}", of.folder);
        // Where all is linear and Gaussian each particle weighs the same.
        assert!(off.abs() < 4.0 * error + 1e-5, "{}: {off} ± {error}", of.folder);
        assert!(error < 0.05, "{}: ± {error}", of.folder);
    }
}

/// Models that are linear with Gaussian noise have exact answers, whatever their times, inputs and shared draws are.
#[test]
fn linear_models_are_filtered_exactly() {
    let folders = [
        "constant-velocity",
        "shared-noise",
        "leak",
        "regressor",
        "cart",
        "irregular",
        "days",
        "animals",
        "delay-line",
    ];
    for folder in folders {
        let of = MODELS.iter().find(|of| of.folder == folder).unwrap();
        let (model, data) = of.open();
        let options = FilterOptions { proposal: ProposalName::Exact, ..Default::default() };
        let found = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap();
        assert!((found.log_evidence() - of.log_evidence).abs() < 2e-6, "{folder}: {}", found.log_evidence());
        let last = found.estimates.last().unwrap().state[of.state].mean;
        assert!((last - of.last_mean).abs() < 2e-6, "{folder}: {last}");
        let smoothed = smooth(&model, &data, &options, 20, |_| ControlFlow::Continue(())).unwrap();
        let last = smoothed.estimates.last().unwrap().state[of.state].mean;
        assert!((last - of.last_mean).abs() < 2e-6, "{folder}, smoothed: {last}");
    }
}

/// Matrices with intercepts and correlated noise of measurements, as formulas: the same answers exactly, by particles, and by smoothing.
#[test]
fn matrices_with_intercepts_are_filtered() {
    let of = SmallModel { folder: "intercept", log_evidence: -1.001385, state: 0, last_mean: 2.729888 };
    let (model, data) = of.open();
    assert_eq!(model.states(), ["x", "noise(y1)", "noise(y2)"]);
    for proposal in
        [ProposalName::Exact, ProposalName::Bootstrap, ProposalName::Linearised, ProposalName::Optimal]
    {
        let options = FilterOptions { proposal: proposal.clone(), particles: 20_000, ..Default::default() };
        let found = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap();
        of.check(&proposal, &found);
        if proposal == ProposalName::Exact {
            assert!((found.log_evidence() - of.log_evidence).abs() < 2e-6, "{}", found.log_evidence());
            let last = &found.estimates.last().unwrap().state[0];
            assert!((last.mean - of.last_mean).abs() < 2e-6 && (last.sd - 0.176563).abs() < 2e-6, "{last:?}");
        }
        let smoothed = smooth(&model, &data, &options, 50, |_| ControlFlow::Continue(())).unwrap();
        let last = &smoothed.estimates.last().unwrap().state[0];
        assert!((last.mean - of.last_mean).abs() < 0.12, "{proposal}: {last:?}");
    }
}

/// Noise without a density, and measurements without error, which no particle meets.
#[test]
fn singular_matrices_are_filtered_exactly() {
    let of = SmallModel { folder: "singular", log_evidence: -7.977668, state: 1, last_mean: 0.276084 };
    let (model, data) = of.open();
    let options = FilterOptions { proposal: ProposalName::Exact, ..Default::default() };
    let found = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap();
    assert!((found.log_evidence() - of.log_evidence).abs() < 2e-6, "{}", found.log_evidence());
    let last = &found.estimates.last().unwrap().state;
    assert!((last[0].mean - 0.27).abs() < 1e-9 && (last[1].mean - of.last_mean).abs() < 2e-6, "{last:?}");
    let smoothed = smooth(&model, &data, &options, 20, |_| ControlFlow::Continue(())).unwrap();
    // What is measured without error is what it was on each path.
    for (row, estimate) in data.rows.iter().zip(&smoothed.estimates) {
        if let Some(y) = row.measurement[0] {
            assert!((estimate.state[0].mean - y).abs() < 1e-9, "{estimate:?}");
        }
    }
    let error = filter(&model, &data, &FilterOptions::default(), |_| ControlFlow::Continue(())).unwrap_err();
    assert_eq!(
        error.to_string(),
        "--proposal bootstrap: y is measured without error, as R says, and no particle is where it was measured; take --proposal exact"
    );
}

/// The Nile with the noises that make its data most likely: by Kalman's filter, and by particles.
#[test]
fn the_nile_is_filtered_at_its_maximum() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let text = std::fs::read_to_string(root.join("nile.toml")).unwrap();
    for (level, right) in [(500.0, -641.3951), (1000.0, -640.5231), (1469.1, -640.3805), (3000.0, -641.0196)]
    {
        let set = [("measurement_variance".to_string(), 15099.0), ("level_variance".to_string(), level)];
        let model = Model::parse(&text, "nile.toml", &set).unwrap();
        let data = Data::open(&root.join("nile.csv"), &model).unwrap();
        let options = FilterOptions { proposal: ProposalName::Exact, ..Default::default() };
        let exact = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap();
        assert!((exact.log_evidence() - right).abs() < 6e-5, "{level}: {}", exact.log_evidence());
        for proposal in designed(&model, &FilterOptions::default()) {
            let options =
                FilterOptions { proposal: proposal.clone(), particles: 5000, ..FilterOptions::default() };
            let found = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap();
            let off = found.log_evidence() - right;
            let error = found.standard_error().unwrap();
            assert!(off.abs() < 4.0 * error + 1e-4, "{level}, {proposal}: {off} ± {error}");
        }
    }
}

/// Sums over all states that can be reached, of regimes and of counts.
#[test]
fn models_of_discrete_states_are_filtered_exactly() {
    for folder in ["chain-binomial", "two-regimes"] {
        let of = MODELS.iter().find(|of| of.folder == folder).unwrap();
        let (model, data) = of.open();
        let options = FilterOptions { proposal: ProposalName::Exact, ..Default::default() };
        let found = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap();
        assert!((found.log_evidence() - of.log_evidence).abs() < 2e-6, "{folder}: {}", found.log_evidence());
        let last = found.estimates.last().unwrap().state[of.state].mean;
        assert!((last - of.last_mean).abs() < 2e-5, "{folder}: {last}");
        let smoothed = smooth(&model, &data, &options, 2000, |_| ControlFlow::Continue(())).unwrap();
        let last = smoothed.estimates.last().unwrap().state[of.state].mean;
        assert!((last - of.last_mean).abs() < 2e-5, "{folder}, smoothed: {last}");
        // Trajectories are drawn from these probabilities.
        for (time, estimate) in smoothed.estimates.iter().enumerate() {
            for (coordinate, of) in estimate.state.iter().enumerate() {
                let off = (smoothed.paths[0].mean(time, coordinate) - of.mean).abs();
                assert!(off <= 5.0 * of.sd / 2000_f64.sqrt() + 1e-9, "{folder}, {time}, {coordinate}: {off}");
            }
        }
        // A filter of particles is held against it unasked.
        let options = FilterOptions { particles: 40_000, ..Default::default() };
        let beside = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap();
        let [Some(exact)] = beside.exact_log_evidence_per_series[..] else { panic!("{folder}") };
        assert!((exact - found.log_evidence()).abs() < 1e-12, "{folder}: {exact}");
    }
}

/// What follows without noise does so along each path.
#[test]
fn smoothed_paths_keep_to_the_equations() {
    let (model, data) = MODELS[3].open();
    let options = FilterOptions::default();
    let found = smooth(&model, &data, &options, 50, |_| ControlFlow::Continue(())).unwrap();
    let [paths] = found.paths.as_slice() else { panic!("one series") };
    assert!(paths.follow_ancestors());
    for path in 0..paths.len() {
        let path = paths.path(path);
        assert!(path.windows(4).step_by(2).all(|pair| pair[2] == pair[0] + pair[1]), "{path:?}");
    }
}

/// A model that says what is drawn, and what follows.
#[test]
fn a_model_of_draws_is_described() {
    let (model, _) = MODELS[0].open();
    let text = model.describe().to_string();
    assert!(text.contains("draws of a step\n  infections ~ binomial(S, 1 - exp(-beta*I/N))"), "{text}");
    assert!(text.contains("S = S - infections"), "{text}");
}
