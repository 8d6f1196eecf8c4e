//! Simulation-based calibration: parameters drawn from their priors lie anywhere among the draws of posteriors of data that they simulate (Talts, Betancourt, Simpson, Vehtari and
//! Gelman, 2018), and intervals of the maximum have the truth in them as often as they say.
//!
//! These take hours; `CALIBRATION_FITS` says how many fits of each model there are, 200 where it says nothing, and five times as many maxima.

use std::ops::ControlFlow;

use motes::inference::map_on_threads;
use motes::output::simulated_table;
use motes::{
    Data, FitOptions, Model, ProposalName, fit, maximise, on_threads, simulate, simulate_from_priors,
};
use special::Gamma;

/// Draws of a posterior that a parameter's rank is counted among.
const DRAWS: usize = 99;

/// Intervals of ranks that are counted.
const BINS: usize = 20;

fn never() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Fits of each model.
fn fits() -> usize {
    std::env::var("CALIBRATION_FITS").ok().and_then(|count| count.parse().ok()).unwrap_or(200)
}

/// How many of so many draws, evenly spread over all chains, lie below a value.
fn rank(chains: &[Vec<f64>], truth: f64) -> usize {
    let all: Vec<f64> = chains.concat();
    (0..DRAWS).filter(|at| all[(2 * at + 1) * all.len() / (2 * DRAWS)] < truth).count()
}

/// The probability that counts of even ranks differ as much from each other, or more.
fn p_value(ranks: &[usize]) -> f64 {
    let mut counts = [0.0; BINS];
    ranks.iter().for_each(|rank| counts[rank * BINS / (DRAWS + 1)] += 1.0);
    let even = ranks.len() as f64 / BINS as f64;
    let square: f64 = counts.iter().map(|count| (count - even).powi(2) / even).sum();
    1.0 - (0.5 * square).inc_gamma(0.5 * (BINS as f64 - 1.0))
}

/// Ranks of each parameter in its posterior, over many draws from the priors.
fn is_calibrated(name: &str, text: &str, rows: usize, times: Option<&str>, proposal: Option<ProposalName>) {
    let model = Model::parse(text, name, &[]).unwrap();
    let file = tempfile::NamedTempFile::new().unwrap();
    let inputs = times.map(|times| {
        std::fs::write(file.path(), times).unwrap();
        Data::open_inputs(file.path(), &model).unwrap()
    });
    let numbers: Vec<u64> = (0..fits() as u64).collect();
    let of_fit = |_: usize, number: &u64| {
        let drawn =
            simulate_from_priors(&model, inputs.as_ref(), rows, 1, 1000 + number, |_| never()).unwrap();
        let table = simulated_table(&model, &drawn);
        let data = Data::read(table.as_bytes(), "simulated.csv", &model).unwrap();
        let options = FitOptions {
            draws: Some(600),
            seed: *number,
            proposal: proposal.clone(),
            ..FitOptions::default()
        };
        let fitted = fit(&model, &data, &options, &never, &mut |_| Ok(())).unwrap();
        let truth = |name: &String| drawn.parameters[0].iter().find(|(other, _)| other == name).unwrap().1;
        let names = fitted.names.iter().enumerate();
        names.map(|(at, name)| rank(&fitted.of_parameter(at), truth(name))).collect::<Vec<usize>>()
    };
    let ranks = on_threads(None, || map_on_threads(&numbers, of_fit)).unwrap();
    let names: Vec<String> = motes::FreeParameters::of(&model).unwrap().names();
    let p_values: Vec<f64> = (0..names.len())
        .map(|at| p_value(&ranks.iter().map(|of_fit| of_fit[at]).collect::<Vec<usize>>()))
        .collect();
    for (name_of, p) in names.iter().zip(&p_values) {
        println!("{name}: {name_of}: p = {p:.4} of {} fits", numbers.len());
    }
    let least = 0.001 / names.len() as f64;
    assert!(p_values.iter().all(|p| *p > least), "{name}: {names:?}: {p_values:?}");
}

const LEVEL: &str = r#"
[parameters]
noise = "log_normal(0, 0.7)"
drift = "log_normal(-0.5, 0.7)"
[initial]
level = "normal(0, 3)"
[transition]
level = "normal(level, drift)"
[measurement]
y = "normal(level, noise)"
"#;

const VOLATILITY: &str = r#"
[parameters]
mu = "normal(-1, 1)"
phi = "uniform(-0.95, 0.95)"
sigma = "half_normal(1)"
[initial]
h = "normal(mu, sigma/sqrt(1 - phi^2))"
[transition]
h = "normal(mu + phi*(h - mu), sigma)"
[measurement]
r = "normal(0, exp(h/2))"
"#;

const EPIDEMIC: &str = r#"
[time]
step = "1/3"
[parameters]
N = 200
beta = "log_normal(log(1.2), 0.4)"
gamma = "log_normal(log(0.5), 0.3)"
size = "log_normal(log(10), 0.7)"
[initial]
S = "N - 5"
I = 5
[draws]
infections = "binomial(S, 1 - exp(-beta*dt*I/N))"
recoveries = "binomial(I, 1 - exp(-gamma*dt))"
[transition]
S = "S - infections"
I = "I + infections - recoveries"
[measurement]
cases = "negative_binomial(total(infections) + 0.1, size)"
"#;

const REGIMES: &str = r#"
[parameters]
calm = "beta(8, 2)"
stormy = "beta(4, 2)"
shift = "normal(1, 0.7)"
[initial]
s = "bernoulli(0.3)"
[transition]
s = "bernoulli(if(s == 1, stormy, 1 - calm))"
[measurement]
y = "normal(if(s == 1, shift, 0), if(s == 1, 1.5, 0.5))"
"#;

const REVERSION: &str = r#"
[time]
column = "time"
[parameters]
rate = "log_normal(log(0.7), 0.6)"
sd = "half_normal(1)"
noise = "log_normal(log(0.3), 0.4)"
[initial]
x = "normal(0, sd)"
[transition]
x = "normal(x*exp(-rate*dt), sd*sqrt(1 - exp(-2*rate*dt)))"
[measurement]
y = "normal(x, noise)"
"#;

const RICKER: &str = r#"
[parameters]
log_r = "normal(2.5, 0.5)"
sigma = "half_normal(0.4)"
phi = "log_normal(log(5), 0.4)"
[initial]
log_N = "log(3)"
[transition]
log_N = "normal(log_r + log_N - exp(log_N), sigma)"
[measurement]
y = "poisson(phi*exp(log_N))"
"#;

#[test]
#[ignore = "the thorough run has it"]
fn a_local_level() {
    is_calibrated("level", LEVEL, 30, None, None);
}

#[test]
#[ignore = "the thorough run has it"]
fn a_local_level_by_particles() {
    is_calibrated("level by particles", LEVEL, 20, None, Some(ProposalName::Bootstrap));
}

#[test]
#[ignore = "the thorough run has it"]
fn stochastic_volatility() {
    is_calibrated("volatility", VOLATILITY, 50, None, None);
}

#[test]
#[ignore = "the thorough run has it"]
fn an_epidemic_of_counts_with_sub_steps() {
    is_calibrated("epidemic", EPIDEMIC, 15, None, None);
}

#[test]
#[ignore = "the thorough run has it"]
fn regimes() {
    is_calibrated("regimes", REGIMES, 40, None, None);
}

#[test]
#[ignore = "the thorough run has it"]
fn irregular_times() {
    let times: String =
        (0..25).map(|row| format!("{}\n", 0.37 * f64::from(row * row % 7 + 4 * row))).collect();
    is_calibrated("reversion", REVERSION, 25, Some(&format!("time\n{times}")), None);
}

#[test]
#[ignore = "the thorough run has it"]
fn a_population() {
    is_calibrated("ricker", RICKER, 30, None, None);
}

/// Catches intervals that are too narrow, or too wide, for what they say.
#[test]
#[ignore = "the thorough run has it"]
fn intervals_of_a_local_level_have_the_truth_in_them() {
    let truth = [("noise", 1.0), ("drift", 0.7)];
    let model = Model::parse(LEVEL, "level", &[]).unwrap();
    let at_truth = model.with_parameters(&truth.map(|(name, value)| (name.to_string(), value))).unwrap();
    let numbers: Vec<u64> = (0..5 * fits() as u64).collect();
    let of_set = |_: usize, number: &u64| {
        let drawn = simulate(&at_truth, 100, 1, 5000 + number, |_| never()).unwrap();
        let data =
            Data::read(simulated_table(&at_truth, &drawn).as_bytes(), "simulated.csv", &model).unwrap();
        let options = FitOptions { chains: 2, seed: *number, ..FitOptions::default() };
        let found = maximise(&model, &data, &options, None, &never, &mut |_| Ok(())).unwrap();
        let ends = found.parameters.iter().map(|of| [of.low.unwrap(), of.high.unwrap()]);
        ends.zip(truth).map(|([low, high], (_, value))| low <= value && value <= high).collect::<Vec<bool>>()
    };
    let covered = on_threads(None, || map_on_threads(&numbers, of_set)).unwrap();
    for (at, (name, _)) in truth.iter().enumerate() {
        let count = covered.iter().filter(|of_set| of_set[at]).count();
        let share = count as f64 / numbers.len() as f64;
        println!("intervals of {name} at 90 %: {:.1} % of {} sets", 100.0 * share, numbers.len());
        assert!((0.87..=0.93).contains(&share), "{name}: {share}");
    }
}
