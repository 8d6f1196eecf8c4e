//! Parameters that each particle has of its own.

use motes_formulas::{FileModel, parse};
use motes_models::batch::Rows;
use motes_models::{Seed, StateSpaceModel, Step};

/// Parameters in each section, in a list, in a definition, in a function, in a draw that is summed up, and in `x_0` alone.
const TEXT: &str = r#"
[time]
step = 0.25
[parameters]
a = "normal(0.3, 0.1)"
b = [0.5, "half_normal(1)", 2]
start = "normal(1, 1)"
sd = "half_normal(1)"
fixed = 0.1
[definitions]
pull = "a*b[1] + fixed"
"f(x)" = "x/(1 + a*x^2)"
[initial]
n = 2
x = "start*b[1] + normal(0, 0.1)"
[draws]
w = "normal(0, sd*sqrt(dt))"
c = "poisson(2 + b[n - 1])"
[transition]
n = "n"
x = "f(x) + pull*dt + w + 0.01*c"
[measurement]
y = "normal(x + b[0]*total(c), 0.5 + sd)"
"#;

const FREE: [&str; 4] = ["a", "b[1]", "start", "sd"];

fn names(of: &[&str]) -> Vec<String> {
    of.iter().map(|name| name.to_string()).collect()
}

#[test]
fn a_model_with_parameters_of_particles_is_the_model_with_each_particles_values() {
    let file = parse(TEXT, "all.toml", &[]).expect("a model");
    let particles = file.with_parameters_of_particles(&names(&FREE)).expect("parameters of particles");
    let values = [[0.3, 0.4, 1.0, 0.2], [-0.2, 1.3, 2.0, 0.7], [0.05, 0.9, -1.0, 0.4]];
    for values in values {
        let set: Vec<(String, f64)> = names(&FREE).into_iter().zip(values).collect();
        let FileModel::Formulas(plain) = parse(TEXT, "all.toml", &set).expect("a model").model else {
            panic!("a file of formulas")
        };
        let (n, count) = (plain.state_dim(), 40);
        let width = n + FREE.len();
        assert_eq!(particles.state_dim(), width);
        let stream = |label: &str| [Seed::from_u64(7).child(label).stream()];
        let mut own: Vec<f64> = (0..count * width)
            .map(|at| if at % width < n { f64::NAN } else { values[at % width - n] })
            .collect();
        let (mut next, mut before, mut expected) = (own.clone(), vec![0.0; count * n], vec![0.0; count * n]);
        for index in 0..4 {
            let step = Step { sub_steps: if index == 0 { 1 } else { 4 }, ..Step::of_index(index) };
            let label = index.to_string();
            let previous = (index > 0).then(|| Rows::all(&before, n));
            plain.sample_states(&step, previous, &mut stream(&label), &mut expected);
            particles.sample_states(&step, Some(Rows::all(&own, width)), &mut stream(&label), &mut next);
            for (own, expected) in next.chunks_exact(width).zip(expected.chunks_exact(n)) {
                for (own, expected) in own.iter().zip(expected.iter().chain(&values)) {
                    assert!(
                        (own - expected).abs() < 1e-12 * (1.0 + expected.abs()),
                        "{own} for {expected} at step {index}"
                    );
                }
            }
            let (mut found, mut right) = (vec![0.0; count], vec![0.0; count]);
            particles.log_likelihoods(&step, &next, &[Some(0.7)], &mut found).expect("a measurement");
            plain.log_likelihoods(&step, &expected, &[Some(0.7)], &mut right).expect("a measurement");
            for (found, right) in found.iter().zip(&right) {
                assert!((found - right).abs() < 1e-12 * (1.0 + right.abs()), "{found} for {right}");
            }
            before.copy_from_slice(&expected);
            own.copy_from_slice(&next);
        }
    }
}

#[test]
fn what_the_start_alone_depends_on_is_known() {
    let file = parse(TEXT, "all.toml", &[]).expect("a model");
    let particles = file.with_parameters_of_particles(&names(&FREE)).expect("parameters of particles");
    assert_eq!(particles.only_initial(), [false, false, true, false]);
    let FileModel::Formulas(plain) = &file.model else { panic!("a file of formulas") };
    assert!(plain.only_initial().is_empty());
}

#[test]
fn what_must_be_known_before_there_are_particles_is_no_parameter_of_theirs() {
    let with = |parameters: &str, time: &str, key: &str| {
        format!(
            "[parameters]\n{parameters}\n[time]\n{time}\n[initial]\n{key} = 0\n[transition]\n{key} = 1\n[measurement]\ny = \"normal(x[0], 1)\"\n"
        )
    };
    let cases = [
        (with("k = \"poisson(3)\"", "step = 1", "x[k]"), "k"),
        (with("h = \"uniform(0.1, 0.5)\"", "step = \"h\"", "x[2]"), "h"),
        (with("q = 1", "step = 1", "x[2]"), "p"),
    ];
    for (text, name) in cases {
        let file = parse(&text, "case.toml", &[]).expect("a model");
        let refused = file.with_parameters_of_particles(&names(&[name])).expect_err(name).to_string();
        assert!(refused.contains(name), "{refused}");
    }
}
