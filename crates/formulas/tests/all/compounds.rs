//! Draws of several parts, categories and sums, against their definitions and against exact sums.

use std::collections::BTreeMap;

use faer::mat;
use motes_formulas::FormulaModel;
use motes_models::equations::{Distribution, Draws, Equations};
use motes_models::{Gaussian, Seed, Step};
use motes_smc::{Bootstrap, FilterSettings, Linearised, ParticleFilter, Proposal};

use super::helpers::{Kept, measurement, model, transition};

/// The log-evidence by many particles, which are drawn from the model, and by a proposal of noise.
fn by_particles(model: &FormulaModel, rows: &[f64]) -> [f64; 2] {
    fn run(
        model: &FormulaModel,
        proposal: impl Proposal<FormulaModel>,
        particles: usize,
        rows: &[f64],
    ) -> f64 {
        let settings = FilterSettings::new(particles);
        let mut filter = ParticleFilter::new(model, proposal, settings, Seed::from_u64(1).stream()).unwrap();
        rows.iter().for_each(|row| filter.step(&[*row]).unwrap());
        filter.log_evidence()
    }
    [run(model, Bootstrap, 300_000, rows), run(model, Linearised::new(model).unwrap(), 50_000, rows)]
}

/// `log p(y)` of a chain with few states, whose start is known.
fn by_sums<State: Ord + Copy>(
    start: &[(State, f64)],
    moves: impl Fn(State) -> Vec<(State, f64)>,
    likelihood: impl Fn(State, f64) -> f64,
    rows: &[f64],
) -> f64 {
    let mut weights: BTreeMap<State, f64> = start.iter().copied().collect();
    for (t, row) in rows.iter().enumerate() {
        if t > 0 {
            let mut moved = BTreeMap::new();
            for (state, weight) in weights {
                for (next, p) in moves(state) {
                    *moved.entry(next).or_insert(0.0) += weight * p;
                }
            }
            weights = moved;
        }
        weights.iter_mut().for_each(|(state, weight)| *weight *= likelihood(*state, *row));
    }
    weights.values().sum::<f64>().ln()
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|k| k as f64).product()
}

/// The multinomial probability that of `n` so many leave by each way.
fn multinomial(n: usize, gone: &[usize], rates: &[f64], dt: f64) -> f64 {
    let (total, stay) = (rates.iter().sum::<f64>(), n - gone.iter().sum::<usize>());
    let mut p = factorial(n) / factorial(stay) * (-total * dt).exp().powi(stay as i32);
    for (count, rate) in gone.iter().zip(rates) {
        let leaves = if total > 0.0 { (1.0 - (-total * dt).exp()) * rate / total } else { 0.0 };
        p *= leaves.powi(*count as i32) / factorial(*count);
    }
    p
}

/// What is stated for a step from `previous` where draws have given values.
fn given(model: &FormulaModel, dt: f64, previous: &mut [f64], values: &[f64]) -> Vec<Distribution<f64>> {
    struct Given<'a>(Kept<f64>, &'a [f64]);
    impl Draws<f64> for Given<'_> {
        fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
            let value = self.1.get(self.0.0.len()).copied();
            self.0.draw(distribution);
            value.unwrap_or(f64::NAN)
        }
    }
    let step = Step { length: dt, ..Step::of_index(1) };
    let (mut kept, before) = (Given(Kept(Vec::new()), values), previous.to_vec());
    step.lift(|step| model.equations().transition(step, &before, &mut kept, previous));
    kept.0.0
}

/// A step in which so many of `S` leave, at rates that are states.
fn leaving(rates: [f64; 3], s: f64, dt: f64, gone: &[f64]) -> Vec<Distribution<f64>> {
    let leaving = model(
        r#"
[initial]
S = 5
a[3] = 1
[draws]
out = "euler_multinomial(S, a[0], a[1], a[2])"
[transition]
S = "S - sum(k, out[k])"
a[3] = "a[i]"
[measurement]
y = "normal(S, 1)"
"#,
    );
    let mut state = [s, rates[0], rates[1], rates[2]];
    let parts = given(&leaving, dt, &mut state, gone);
    assert!(state[0] == s - gone.iter().sum::<f64>() || !state[0].is_finite());
    parts
}

/// Catches a probability that is not conditional, and a step that is taken for one of length 1.
#[test]
fn those_who_leave_are_multinomial() {
    for (rates, dt) in [([0.3, 1.1, 0.0], 1.0), ([0.02, 0.5, 4.0], 0.25), ([1e-9, 2e-9, 1e-12], 0.1)] {
        let mut sum = 0.0;
        for all in 0..216_usize {
            let gone = [all % 6, all / 6 % 6, all / 36];
            if gone.iter().sum::<usize>() > 5 {
                continue;
            }
            let values = gone.map(|count| count as f64);
            let parts = leaving(rates, 5.0, dt, &values);
            let found: f64 = parts.iter().zip(values).map(|(part, gone)| part.log_density(gone)).sum();
            let expected = multinomial(5, &gone, &rates, dt);
            let off = (found.exp() - expected).abs();
            assert!(off <= 1e-6 * expected, "{rates:?}, {gone:?}: {} for {expected}", found.exp());
            sum += found.exp();
        }
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }
}

/// Catches 0/0, and a probability above 1.
#[test]
fn rates_may_be_nothing_or_huge() {
    let p = |rates| {
        leaving(rates, 5.0, 1.0, &[0.0; 3]).iter().map(|part| part.moments()[0] / 5.0).collect::<Vec<_>>()
    };
    assert_eq!(p([0.0, 0.0, 0.0]), [0.0, 0.0, 0.0]);
    assert_eq!(p([2000.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
    assert_eq!(p([0.0, 2000.0, 1.0])[0], 0.0);
    for scale in 0..300 {
        let rate = 1.07_f64.powi(scale - 100);
        for rates in [[rate, 0.0, 0.0], [rate / 3.0, rate, rate / 7.0], [0.0, rate * 1e-3, rate]] {
            assert!(p(rates).iter().all(|p| (0.0..=1.0).contains(p)), "{rates:?}: {:?}", p(rates));
        }
    }
    let is_refused =
        |rates, s| leaving(rates, s, 1.0, &[0.0; 3]).iter().any(|part| part.log_density(0.0).is_nan());
    for rates in
        [[-1.0, 2.0, 1.0], [3.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, -1.0, 0.0], [f64::NAN, 1.0, 1.0]]
    {
        assert!(is_refused(rates, 5.0), "{rates:?}");
    }
    assert!(is_refused([1.0; 3], 4.5), "half a person");
    assert!(!is_refused([1.0; 3], 4.0));
}

const EPIDEMIC: &str = r#"
[parameters]
beta = 0.9
N = 8
[initial]
S = 6
I = 2
[draws]
out_S = "euler_multinomial(S, beta*I/N, 0.1)"
out_I = "euler_multinomial(I, 0.4, 0.1)"
[transition]
S = "S - out_S[0] - out_S[1]"
I = "I + out_S[0] - sum(way, out_I[way])"
[measurement]
seen = "poisson(0.6*I + 0.1)"
"#;

#[test]
fn the_evidence_of_an_epidemic_is_that_of_a_sum() {
    let rows = [1.0, 2.0, 0.0, 3.0, 1.0, 0.0];
    let moves = |(s, i): (usize, usize)| {
        let mut all = Vec::new();
        let both = |n: usize| (0..=n).flat_map(move |a| (0..=n - a).map(move |b| [a, b]));
        for of_s in both(s) {
            for of_i in both(i) {
                let p = multinomial(s, &of_s, &[0.9 * i as f64 / 8.0, 0.1], 1.0)
                    * multinomial(i, &of_i, &[0.4, 0.1], 1.0);
                all.push(((s - of_s[0] - of_s[1], i + of_s[0] - of_i[0] - of_i[1]), p));
            }
        }
        all
    };
    let likelihood = |(_, i): (usize, usize), y: f64| {
        let mean = 0.6 * i as f64 + 0.1;
        (-mean).exp() * mean.powf(y) / factorial(y as usize)
    };
    let expected = by_sums(&[((6, 2), 1.0)], moves, likelihood, &rows);
    let found = by_particles(&model(EPIDEMIC), &rows);
    assert!(found.iter().all(|found| (found - expected).abs() < 0.03), "{found:?} for {expected}");
}

/// Catches a factor that is transposed, and an entry that is not the same on both sides of the diagonal.
#[test]
fn correlated_normals_have_the_density_of_all() {
    let normals = model(
        r#"
[initial]
x = 0
r = 0
[draws]
v = "mvnormal([x, 1, 2*x], [[2, r, 0.3], [r, 1, 0.2], [0.3, 0.4*r, 3]])"
[transition]
x = "sum(j, v[j])"
r = "r"
[measurement]
y = "normal(x, 1)"
"#,
    );
    let (values, mut state) = ([0.3, -1.2, 4.0], [1.5, 0.5]);
    let parts = given(&normals, 1.0, &mut state, &values);
    let found: f64 = parts.iter().zip(values).map(|(part, value)| part.log_density(value)).sum();
    let covariance = mat![[2.0, 0.5, 0.3], [0.5, 1.0, 0.2], [0.3, 0.2, 3.0]];
    let all = Gaussian::new("v", vec![1.5, 1.0, 3.0], covariance).unwrap();
    assert!((found - all.log_density(&values)).abs() < 1e-13);
    assert!((state[0] - 3.1).abs() < 1e-15);
    let wrong = |r: f64| {
        let parts = given(&normals, 1.0, &mut [1.5, r], &values);
        let explained =
            normals.explain(&Step::of_index(1), Some(&[1.5, r]), None).map(|error| error.to_string());
        (parts.iter().any(|part| part.log_density(0.0).is_nan()), explained)
    };
    assert_eq!(wrong(0.5), (false, None));
    let (is_nan, explained) = wrong(0.6);
    assert!(is_nan);
    insta::assert_snapshot!(explained.unwrap(), @"m.toml, line 6, [draws] v[0]: the covariance, `mvnormal([x, 1, 2*x], [[2, r, 0.3], [r, 1, 0.2], [0.3, 0.4*r, 3]])`, is NaN where x = 1.5, r = 0.6; it must be symmetric and positive definite");
}

const REGIMES: &str = r#"
[parameters]
g = [[0.8, 0.15, 0.05], [0.1, 0.9, 0], [0.3, 0.3, 0.4]]
mean = [-1, 0.5, 3]
[initial]
k = "categorical(0.5, 0.25, 0.25)"
[draws]
next = "categorical(g[k, 0], g[k, 1], g[k, 2])"
[transition]
k = "next"
[measurement]
y = "normal(mean[k], 1)"
"#;

#[test]
fn the_evidence_of_regimes_is_that_of_a_sum() {
    let (g, means) = ([[0.8, 0.15, 0.05], [0.1, 0.9, 0.0], [0.3, 0.3, 0.4]], [-1.0, 0.5, 3.0]);
    let rows = [0.2, -1.4, 2.8, 3.3, 0.1, 0.6, -0.9, 1.1];
    let normal =
        |k: usize, y: f64| (-0.5_f64 * (y - means[k]).powi(2)).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let moves = |k: usize| (0..3).map(|next| (next, g[k][next])).collect();
    let expected = by_sums(&[(0, 0.5), (1, 0.25), (2, 0.25)], moves, normal, &rows);
    let as_draw = by_particles(&model(REGIMES), &rows);
    assert!(as_draw.iter().all(|found| (found - expected).abs() < 0.04), "{as_draw:?} for {expected}");
    let start = REGIMES.find("[draws]").unwrap();
    let end = REGIMES.find("[measurement]").unwrap();
    let moves = "[transition]\nk = \"categorical(g[k, 0], g[k, 1], g[k, 2])\"\n";
    let as_state = by_particles(&model(&format!("{}{moves}{}", &REGIMES[..start], &REGIMES[end..])), &rows);
    assert_eq!(as_state, as_draw, "a draw that a state keeps is that state");
}

/// The state that a uniform number makes of `p`, `q` and what they leave.
fn category(p: f64, q: f64, uniform: f64) -> f64 {
    struct Uniform(f64);
    impl Draws<f64> for Uniform {
        fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
            assert_eq!(distribution, motes_models::equations::uniform(0.0, 1.0));
            self.0
        }
    }
    let categories = model(
        r#"
[initial]
p = 0.5
q = 0.5
k = 0
[transition]
k = "categorical(p, q, 0.5)"
p = "p"
q = "k"
[measurement]
y = "normal(k, 1)"
"#,
    );
    let mut state = [p, q, 0.0];
    Step::of_index(1).lift(|step| {
        categories.equations().transition(step, &[p, q, 0.0], &mut Uniform(uniform), &mut state);
    });
    state[2]
}

/// Catches a category that has no probability, and probabilities that are none.
#[test]
fn a_uniform_number_chooses_a_category() {
    for (uniform, expected) in [(0.0, 0.0), (0.199, 0.0), (0.2, 1.0), (0.499, 1.0), (0.5, 2.0), (0.999, 2.0)]
    {
        assert_eq!(category(0.2, 0.3, uniform), expected, "{uniform}");
    }
    assert_eq!(category(0.0, 0.5, 0.0), 1.0);
    assert_eq!(category(0.5, 0.0, 0.5), 2.0);
    for [p, q] in [[0.6, -0.1], [0.2, 0.300_01], [f64::NAN, 0.5]] {
        assert!(category(p, q, 0.3).is_nan());
    }
    assert!(!category(0.2, 0.300_000_1, 0.3).is_nan(), "rounded");
}

#[test]
fn sums_go_along_vectors_lists_and_draws() {
    let sums = model(
        r#"
[parameters]
w = [[1, 10, 100], [2, 20, 200]]
[initial]
x[3] = 1
u[2] = 1
[definitions]
whole = "sum(i, x[i])"
square(z) = "z^2"
[draws]
e[2] = "normal(u[i], 1)"
[transition]
x[3] = "sum(j, w[j, i]*u[j])"
u[2] = "sum(k, w[i, k]*x[k]) + sum(j, e[j])"
[measurement]
y = "normal(whole + sum(i, sum(j, w[i, j]*square(u[i])*j)), 1)"
"#,
    );
    let state = [1.0, 2.0, 4.0, 3.0, 5.0];
    let mean = 7.0 + 9.0 * (10.0 + 200.0) + 25.0 * (20.0 + 400.0);
    assert_eq!(measurement(&sums, 0, &state)[0].moments()[0], mean);
    let mut kept = Kept(Vec::new());
    let mut next = state;
    Step::of_index(1).lift(|step| sums.equations().transition(step, &state, &mut kept, &mut next));
    assert_eq!(next, [13.0, 130.0, 1300.0, 421.0 + 8.0, 842.0 + 8.0]);
}

#[test]
fn a_step_has_a_length() {
    let walk = model(
        "[initial]\nx = \"normal(dt, 1)\"\n[transition]\nx = \"normal(x, 0.1*sqrt(dt))\"\n[measurement]\ny = \"normal(x, 1)\"\n",
    );
    assert!((transition(&walk, 1, &[0.0])[0].moments()[1] - 0.01).abs() < 1e-15);
    let mut kept = Kept(Vec::new());
    let step = Step { length: 0.25, ..Step::of_index(1) };
    step.lift(|step| walk.equations().transition(step, &[0.0], &mut kept, &mut [0.0]));
    assert!((kept.0[0].moments()[1] - 0.0025).abs() < 1e-15);
}

#[test]
fn an_error_names_the_parameter() {
    let rates = model(
        r#"
[initial]
S = 5
r = 1
[draws]
out = "euler_multinomial(S, r, 2*r)"
k = "categorical(r, 0.25)"
[transition]
S = "S - out[1]"
r = "r + 0*k"
[measurement]
y = "normal(S, 1)"
"#,
    );
    let text = |state: [f64; 2]| {
        rates.explain(&Step::of_index(1), Some(&state), None).map(|error| error.to_string())
    };
    insta::assert_snapshot!(text([4.5, 0.5]).unwrap(), @"m.toml, line 6, [draws] out[0]: n, `S`, is 4.5; it must be an integer of at least 0");
    insta::assert_snapshot!(text([4.0, -1.0]).unwrap(), @"m.toml, line 6, [draws] out[0]: rate, `r`, is -1; it must be at least 0");
    insta::assert_snapshot!(text([4.0, 0.5]).unwrap(), @"m.toml, line 7, [draws] k: the sum of the probabilities, `categorical(r, 0.25)`, is 0.75 where r = 0.5; it must be 1");
    assert_eq!(text([4.0, 0.75]), None);
}

/// Starts of several parts, against integrals in closed form: catches parts that are drawn without those before them, and states that are taken for another vector's.
#[test]
fn starts_have_parts() {
    let correlated = model(
        r#"
[initial]
w = "normal(3, 0.1)"
v = "mvnormal([1, w], [[4, -1.5], [-1.5, 1]])"
[transition]
w = "w"
v[2] = "normal(v[i], 0.5)"
[measurement]
y = "normal(v[0] + v[1], 0.5)"
"#,
    );
    let variance = 4.0 - 3.0 + 1.0 + 0.01 + 0.25;
    let expected = -0.5 * (f64::ln(2.0 * std::f64::consts::PI * variance) + 2.5 * 2.5 / variance);
    for found in by_particles(&correlated, &[6.5]) {
        assert!((found - expected).abs() < 0.01, "{found}, {expected}");
    }

    let shares = model(
        r#"
[initial]
s = "dirichlet(1, 2, 3)"
[transition]
s[3] = "s[i]"
[measurement]
k = "binomial(4, s[1])"
"#,
    );
    // s[1] is a beta(2, 4), and k = 3 of 4 a beta-binomial: 4·B(5, 5)/B(2, 4).
    let expected = (4.0 * (24.0 * 24.0 / 362_880.0) * 20.0_f64).ln();
    let found = by_particles(&shares, &[3.0])[0];
    assert!((found - expected).abs() < 0.01, "{found}, {expected}");
    let states = motes_models::StateSpaceModel::state_dim(&shares);
    assert_eq!(states, 3);
}
