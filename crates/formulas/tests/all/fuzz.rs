//! Texts of all kinds: catches a panic, a stack that overflows, and work without end.

use motes_formulas::{FileError, FileModel, FormulaModel, Problem, parse};
use motes_models::batch::Rows;
use motes_models::equations::NoiseSpace;
use motes_models::{Seed, Simulator, StateGradients, StateSpaceModel, Step};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::helpers::{cases, measuring};

const FILES: [&str; 7] = [
    r#"
name = "growth"
[parameters]
q = 10.0
[initial]
x = "normal(0, sqrt(5))"
v[4] = "laplace(i, 1)"
[definitions]
drift = "x/2 + 25*x/(1 + x^2) + 8*cos(1.2*t)"
d[4] = "v[i+1] - v[i-2]"
[transition]
x = "normal(drift, sqrt(q))"
v[4] = "d[i] + 3*exponential(1) - 3"
[measurement]
y = "normal(x^2/20, 1)"
n[2] = "poisson(exp(v[2*i]))"
"#,
    r#"
kind = "linear-gaussian"
states = ["p", "v"]
measurements = ["y"]
m0 = [0, 0]
P0 = [[1, 0], [0, 1]]
A = [[1, 0.1], [0, 1]]
Q = [[0.1, 0], [0, 0.1]]
C = [[1, 0]]
R = [[0.5]]
"#,
    r#"
[parameters]
w = [[1, 2], [3, 4]]
r = "truncated(log_normal(log(3), 0.5), 1, inf)"
p = { prior = "dirichlet(1, 2, 3)", start = [0.2, 0.3, 0.5] }
[initial]
S = 5
k = "categorical(p[0], p[1], p[2])"
[definitions]
f(u, v) = "u*w[0, v] + sum(j, w[j, v])"
[draws]
out = "euler_multinomial(S, f(r, 1)*dt, 0.5)"
[transition]
S = "S - sum(j, out[j])"
k = "categorical(0.5, if(k > 1, 0.5, 0.25), if(k > 1, 0, 0.25))"
[measurement]
y = "normal(S, 1)"
"#,
    "[initial]\nx = '''\nnormal(0,\n 1)'''\n[transition]\nx.y = 3\n",
    r#"
[time]
column = "year"
step = "1/7"
start = "1950 - 2/365.25"
[series]
by = "animal"
[inputs]
u = "hold"
v = { between = "linear", simulate = "normal(0, 1)" }
before = { column = "y", rows = 1, first = 0 }
[initial]
k = "bernoulli(0.3)"
x[4] = "exponential(1 + k)"
[draws]
dw = "gamma(dt/0.1^2, 0.1^2)"
e = "mvnormal([0, u], [[1, 0.2], [0.2, 2]])"
s = "dirichlet(1, 2, 3)"
b = "beta(2, 1 + dt) - 1"
[transition]
k = "if(mod(t, 7) < 2 and not (v > 3), 1 - k, k)"
x[0] = "x[3] + dw + e[0]*s[1] - b"
x[1..4] = "x[i-1] + before*0"
[measurement]
y = "floored(rounded(censored(normal(total(dw), 1 + k), 0, inf)), 1e-18)"
z[2] = "mixture(0.9, student_t(3, x[i], 1), von_mises(e[1], 2))"
w = "zero_inflated(0.2, negative_binomial(1 + total_since_measured(k), 2))"
q = "truncated(laplace(x[0], 1), -1, 5)"
l = "log_density(-abs(l - x[1]) - log(2))"
c = "categorical(0.2, 0.3, 0.5)"
"#,
    r#"
kind = "linear-gaussian"
states = ["mean", "shock"]
measurements = ["sales"]
A = [["phi", 1], [0, 0]]
b = ["mu*(1 - phi)", 0]
B = [[0.3, 0], [0, 0]]
Q = [[1, "theta"], ["theta", "theta^2"]]
C = [[1, 0]]
d = [1]
D = [[0, -0.5]]
R = [[0.25]]
S = [[0.1], [0.04]]
m0 = ["mu", 0]
P0 = [[2, 0], [0, 1]]
[parameters]
phi = 0.8
theta = 0.4
mu = 10
[inputs]
advertised = "hold"
holiday = "next"
"#,
    r#"
[initial]
S = 13
I = "15 - S"
[draws]
infected = "binomial(S, 1 - exp(-0.9*I/15))"
recovered = "euler_multinomial(I, 0.4, 0.01)"
[transition]
S = "S - infected"
I = "max(I + infected - sum(j, recovered[j]), 0)"
[measurement]
y = "poisson(I + 0.01)"
"#,
];

/// Words that files are made of.
const WORDS: [&str; 70] = [
    "x",
    "[40]",
    "[i]",
    "[",
    "]",
    "(",
    ")",
    "normal(",
    "poisson(",
    "exp(",
    "^",
    "-",
    "+",
    "*",
    "/",
    ",",
    "1e400",
    "0.5",
    "t",
    "i",
    "pi",
    "\"",
    "'''",
    "\n",
    "=",
    "[initial]\n",
    "[transition]\n",
    "[measurement]\n",
    "[definitions]\n",
    "#",
    "drift",
    "sum(j, ",
    "euler_multinomial(",
    "categorical(",
    "truncated(",
    "[draws]\n",
    "[parameters]\n",
    "²",
    "é",
    "\u{feff}",
    "\0",
    "9999999999999999999",
    "kind",
    "1",
    " ",
    "\\u0041",
    "[time]\n",
    "[inputs]\n",
    "[series]\n",
    "step",
    "start",
    "dt",
    "inf",
    "\"hold\"",
    "{ prior = ",
    "simulate = ",
    "first = ",
    "if(",
    "mod(",
    " and ",
    " or ",
    " not ",
    " < ",
    " == ",
    "total(",
    "rounded(",
    "censored(",
    "mixture(",
    "log_density(",
    "[1..4]",
];

fn words() -> impl Strategy<Value = String> {
    prop::collection::vec(prop::sample::select(&WORDS[..]), 0..40).prop_map(|words| words.concat())
}

/// All that filters ask a model for, over a few steps: of particles as they come, and of measurements of all kinds.
fn run(model: &FormulaModel) {
    const PARTICLES: usize = 40;
    let (n, m) = (model.state_dim(), model.measurement_dim());
    if n * m > 400 {
        return;
    }
    let mut streams = [Seed::from_u64(1).stream()];
    let (mut states, mut before) = (vec![0.0; PARTICLES * n], vec![0.0; PARTICLES * n]);
    for index in 0..3 {
        let own = model.step_of_index(index);
        // Inputs and what shows whether something was measured: any number.
        let inputs = vec![0.5; own.inputs.len()];
        let step = Step { inputs: &inputs, ..own };
        let previous = (index > 0).then_some(Rows::all(&before, n));
        model.sample_states(&step, previous, &mut streams, &mut states);
        let mut drawn = vec![0.0; PARTICLES * m];
        model.sample_measurements(&step, &states, &mut streams, &mut drawn);
        let mut slopes = [vec![0.0; PARTICLES * n], vec![0.0; PARTICLES * n]];
        let mut logs = vec![0.0; PARTICLES];
        for shift in [0.0, 0.5, -1e9] {
            let row: Vec<f64> = drawn[..m].iter().map(|y| y + shift).collect();
            let gaps: Vec<Option<f64>> =
                row.iter().enumerate().map(|(at, y)| (at % 2 == 0).then_some(*y)).collect();
            let _ = model.log_likelihoods(&step, &states, &gaps, &mut logs);
            let _ = model.log_likelihood(&step, &states[..n], &row);
            model.likelihood_gradients(&step, &states, &row, &mut slopes[0]);
            let _ = model.explain(&step, Some(&before[..n]), Some(&states[..n]));
        }
        if model.density().is_some() && index > 0 {
            let [a, b] = &mut slopes;
            model.transition_gradients(&step, &before, &states, a, b);
        }
        let _ = (model.draws(&step), model.supports(&step));
        before.copy_from_slice(&states);
    }
    let _ = model.closed_form();
}

/// What reads a text, and runs what comes of it.
fn read_and_run(text: &str, set: &[(String, f64)]) {
    match parse(text, "m.toml", set) {
        Ok(file) => match file.model {
            FileModel::Formulas(model) => run(&model),
            FileModel::LinearGaussian(_) => {}
        },
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: cases(2000),
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let text = String::from_utf8_lossy(&bytes);
        read_and_run(&text, &[]);
    }

    #[test]
    fn any_words(text in words()) {
        read_and_run(&text, &[]);
    }

    #[test]
    fn any_formula(text in words()) {
        for quote in ["\"", "'", "\"\"\"", "'''"] {
            let file = format!("[initial]\nx = {quote}{text}{quote}\n[transition]\nx = 'normal(x, 1)'\n[measurement]\ny = 'normal(x, 1)'\n");
            read_and_run(&file, &[]);
            let _ = parse(&file, "m.toml", &[("x".into(), 1.0)]).map_err(|error| error.to_string());
        }
    }

    /// Files with a piece cut out and words put in.
    #[test]
    fn files_with_a_mistake(which in 0..FILES.len(), at in any::<prop::sample::Index>(), cut in 0_usize..12, word in words()) {
        let text = FILES[which];
        let start = at.index(text.len());
        let end = (start + cut).min(text.len());
        let (Some(before), Some(after)) = (text.get(..start), text.get(end..)) else { return Ok(()) };
        for word in [&word[..], ""] {
            read_and_run(&format!("{before}{word}{after}"), &[]);
        }
    }
}

/// Catches files above that are not what they seem: each is a model, but for the one that never is.
#[test]
fn files_without_a_mistake_are_run() {
    for (number, text) in FILES.iter().enumerate() {
        assert_eq!(
            parse(text, "m.toml", &[]).is_ok(),
            number != 3,
            "{number}: {:?}",
            parse(text, "m.toml", &[]).err()
        );
        read_and_run(text, &[]);
    }
}

/// The problem of a measurement with this mean.
fn problem(mean: &str) -> Problem {
    let text = format!(
        "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal({mean}, 1)\"\n"
    );
    match parse(&text, "m.toml", &[]) {
        Err(FileError::Refused { problem, .. }) => *problem,
        other => panic!("{other:?}"),
    }
}

/// Catches recursion that nothing bounds.
#[test]
fn nesting_has_an_end() {
    for (open, close) in [("(", ")"), ("-", ""), ("+", ""), ("x^", ""), ("sqrt(", ")"), ("max(1, ", ")")] {
        let nested = |depth: usize| format!("{}x{}", open.repeat(depth), close.repeat(depth));
        for depth in [101, 20_000, 100_000 / open.len() - 10] {
            let found = problem(&nested(depth));
            assert!(
                matches!(found, Problem::TooDeep(_) | Problem::TooLong { .. }),
                "{open} {depth} deep: {found}"
            );
        }
        measuring(&format!("normal({}, 1)", nested(90)), "");
    }
    assert!(matches!(problem(&"(".repeat(99_000)), Problem::TooDeep(_)));
    assert!(matches!(problem(&"(".repeat(1_000_000)), Problem::TooLong { .. }));
    // A long sum is not deep.
    measuring(&format!("normal(x{}, 1)", " + x".repeat(20_000)), "");
}

/// Catches definitions whose text is short, and whose graph is not: each of these doubles.
#[test]
fn what_stands_twice_is_computed_once() {
    let mut lines = String::from("[definitions]\nd0 = \"sin(x)\"\n");
    for level in 1..60 {
        lines += &format!("d{level} = \"d{0}*d{0} + cos(d{0})\"\n", level - 1);
    }
    measuring("normal(d59, 1)", &lines);
}

/// Catches vectors that would take all memory.
#[test]
fn work_has_an_end() {
    let sum = vec!["x[i]"; 400].join(" + ");
    let text = format!(
        "[initial]\nx[10000] = \"normal(0, 1)\"\n[transition]\nx[10000] = \"normal({sum}, 1)\"\n[measurement]\ny = \"normal(x[0], 1)\"\n"
    );
    let error = parse(&text, "m.toml", &[]).unwrap_err().to_string();
    insta::assert_snapshot!(error, @"m.toml, line 4, column 13, [transition] x[10000]: up to here the formulas come to more than 2000000 operations; shorter vectors would do");
}
