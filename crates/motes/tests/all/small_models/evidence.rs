//! Log-evidences of recorded data: as packages, papers, Kalman filters and quadrature have them.

use std::ops::ControlFlow;

use motes::{Data, FilterOptions, Filtered, Model, ProposalName, designed, filter};

use super::shipped::{data_of, home};

/// A model with data, and what is right.
struct Known {
    folder: &'static str,
    set: &'static [(&'static str, f64)],
    log_evidence: f64,
    /// The standard error of what is right.
    error: f64,
    particles: usize,
}

const fn of(folder: &'static str, log_evidence: f64, error: f64, particles: usize) -> Known {
    Known { folder, set: &[], log_evidence, error, particles }
}

/// Linear models, and one of two regimes.
const EXACT: [Known; 6] = [
    of("arma", -135.35131, 1e-5, 0),
    of("co2", -177.11742, 1e-5, 0),
    of("seatbelts", 202.10439, 1e-5, 0),
    of("nelson-siegel", 908.05672, 1e-5, 0),
    of("quasar", 186.78112, 1e-5, 0),
    of("federal-funds", -508.63592, 1e-5, 0),
];

const BY_PARTICLES: [Known; 8] = [
    of("ricker", -139.05027, 0.0, 5000),
    Known {
        set: &[("log_r", 3.802), ("sigma", 0.192), ("phi", 10.20)],
        ..of("ricker", -137.17901, 0.0, 5000)
    },
    of("parus", -157.23408, 0.0, 5000),
    of("fishery", -68.26981, 0.0, 5000),
    of("leverage", -2149.09344, 0.0, 5000),
    of("sir-incidence", -244.36, 0.04, 2000),
    of("federal-funds", -508.63592, 0.0, 5000),
    of("blowflies", -1465.7, 0.2, 20_000),
];

/// Those whose data `fetch.py` gets.
const FETCHED: [Known; 2] =
    [of("london-measles", -3801.9, 0.3, 20_000), of("dacca-cholera", -3748.15, 0.3, 10_000)];

impl Known {
    /// The model and its data, where they are there.
    fn open(&self) -> Option<(Model, Data)> {
        let set: Vec<(String, f64)> = self.set.iter().map(|(name, value)| ((*name).into(), *value)).collect();
        let file = data_of(self.folder);
        if !file.exists() {
            return None;
        }
        let model = Model::read(&home().join(self.folder).join("model.toml"), &set).unwrap();
        let data = Data::open(&file, &model).unwrap();
        Some((model, data))
    }

    fn check(&self, proposal: &ProposalName, found: &Filtered) {
        let off = found.log_evidence() - self.log_evidence;
        let error = found.standard_error().unwrap().hypot(self.error);
        println!("{}, {proposal}: {:.3}, off by {off:.3} ± {error:.3}", self.folder, found.log_evidence());
        assert!(off.abs() < 4.0 * error, "{}, {proposal}: off by {off} ± {error}", self.folder);
        // What allows anything shows nothing.
        assert!(error < 2.0, "{}, {proposal}: ± {error}", self.folder);
    }
}

fn filtered(model: &Model, data: &Data, options: &FilterOptions) -> Filtered {
    filter(model, data, options, |_| ControlFlow::Continue(())).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn exact_filters_have_the_published_evidence() {
    for known in &EXACT {
        let (model, data) = known.open().unwrap();
        let options = FilterOptions { proposal: ProposalName::Exact, ..FilterOptions::default() };
        let found = filtered(&model, &data, &options).log_evidence();
        assert!((found - known.log_evidence).abs() < 2.0 * known.error, "{}: {found}", known.folder);
    }
}

/// By the filter that draws from the transition, and by the linearised one where it sees the measurement.
#[test]
fn particles_have_the_published_evidence() {
    for known in &BY_PARTICLES {
        let (model, data) = known.open().unwrap();
        let proposals = designed(&model, &FilterOptions::default());
        for proposal in proposals.into_iter().filter(|proposal| *proposal != ProposalName::Exact) {
            // With noise of 13 gammas a Gaussian of the noise has an error of 6 nats, which shows nothing.
            if known.folder == "blowflies" && proposal == ProposalName::Linearised {
                continue;
            }
            let options = FilterOptions {
                proposal: proposal.clone(),
                particles: known.particles,
                ..FilterOptions::default()
            };
            known.check(&proposal, &filtered(&model, &data, &options));
        }
    }
}

#[test]
#[ignore = "data that fetch.py gets, and minutes"]
fn dacca_and_london_have_the_published_evidence() {
    for known in &FETCHED {
        let Some((model, data)) = known.open() else {
            println!("{}: there are no data; run python3 fetch.py", known.folder);
            continue;
        };
        let options = FilterOptions { particles: known.particles, ..FilterOptions::default() };
        known.check(&ProposalName::Bootstrap, &filtered(&model, &data, &options));
    }
}
