//! Texts of all kinds: catches a panic, a stack that overflows, and work without end.

use motes_formulas::{FileError, Problem, parse};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::helpers::measuring;

const FILES: [&str; 4] = [
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
];

/// Words that files are made of.
const WORDS: [&str; 46] = [
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
];

fn words() -> impl Strategy<Value = String> {
    prop::collection::vec(prop::sample::select(&WORDS[..]), 0..40).prop_map(|words| words.concat())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let text = String::from_utf8_lossy(&bytes);
        let _ = parse(&text, "m.toml", &[]).map_err(|error| error.to_string());
    }

    #[test]
    fn any_words(text in words()) {
        let _ = parse(&text, "m.toml", &[]).map_err(|error| error.to_string());
    }

    #[test]
    fn any_formula(text in words()) {
        for quote in ["\"", "'", "\"\"\"", "'''"] {
            let file = format!("[initial]\nx = {quote}{text}{quote}\n[transition]\nx = 'normal(x, 1)'\n[measurement]\ny = 'normal(x, 1)'\n");
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
            let _ = parse(&format!("{before}{word}{after}"), "m.toml", &[]).map_err(|error| error.to_string());
        }
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
