//! Parameters with priors in commands: their starts are used and said, values from outside are not, and simulations can draw them.

use crate::common::{Workplace, stderr};

const MODEL: &str = r#"
[parameters]
noise = "log_normal(log(2), 0.5)"
share = "dirichlet(2, 6)"
a = { prior = "uniform(-1, 1)", start = 0.9 }
[initial]
x = "normal(0, 1)"
[transition]
x = "normal(a*x, share[1])"
[measurement]
y = "normal(x, noise)"
"#;

fn place() -> Workplace {
    let place = Workplace::new();
    place.write("m.toml", MODEL);
    place
}

#[test]
fn starts_are_used_and_said() {
    let place = place();
    let said = "motes: warning: noise, share and a have priors; their starts are used: noise = 2 (its median); share = 0.25, 0.75 (its mean); \
                a = 0.9; give others by --set noise=…";
    for command in [
        &["filter", "m.toml", "d.csv"][..],
        &["smooth", "m.toml", "d.csv", "--paths", "5"],
        &["simulate", "m.toml", "--steps", "3"],
    ] {
        let output = place.run(command);
        assert!(stderr(&output).lines().any(|line| line == said), "{command:?}: {}", stderr(&output));
    }
    let checked = place.printed(&["check", "m.toml", "d.csv"]);
    assert_eq!(checked.lines().filter(|line| line.contains("have priors")).count(), 1, "{checked}");
    assert!(checked.contains("noise    = 2, with the prior log_normal(log(2), 0.5)"), "{checked}");
    let one = ["filter", "m.toml", "d.csv", "--set", "share[0]=0.2", "--set", "noise=1"];
    let said = "motes: warning: a has a prior; its start 0.9 is used; give another by --set a=…";
    assert!(stderr(&place.run(&one)).contains(said), "{}", stderr(&place.run(&one)));
}

/// Catches a start that is used instead of what was set, and the other way round.
#[test]
fn a_model_at_its_starts_is_the_one_with_these_numbers() {
    let place = place();
    let numbers = MODEL
        .replace("\"log_normal(log(2), 0.5)\"", "2")
        .replace("\"dirichlet(2, 6)\"", "[0.25, 0.75]")
        .replace("{ prior = \"uniform(-1, 1)\", start = 0.9 }", "0.9");
    place.write("n.toml", numbers);
    let set = ["--set", "a=0.5"];
    let table = |model: &str, set: &[&str]| place.printed(&[&["filter", model, "d.csv"], set].concat());
    assert_eq!(table("m.toml", &[]), table("n.toml", &[]));
    assert_eq!(table("m.toml", &set), table("n.toml", &set));
    assert_ne!(table("m.toml", &set), table("n.toml", &[]));
}

#[test]
fn simulations_draw_parameters() {
    let place = place();
    let drawn =
        place.run(&["simulate", "m.toml", "--steps", "2", "--series", "300", "--prior", "--set", "a=0.5"]);
    assert_eq!(stderr(&drawn), "");
    let table = String::from_utf8(drawn.stdout).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("series,t,x,y,noise,share[0],share[1]"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 600);
    for of_series in rows.chunks(2) {
        assert_eq!(of_series[0][4..], of_series[1][4..]);
        assert!((of_series[0][5] + of_series[0][6] - 1.0).abs() < 1e-9);
    }
    let below = rows.iter().filter(|row| row[4] < 2.0).count();
    assert!((220..=380).contains(&below), "{below} of 600 below the median");
    // A series is the same whatever others there are, and the model is the one that its parameters say.
    let first = place.printed(&["simulate", "m.toml", "--steps", "2", "--prior", "--set", "a=0.5"]);
    assert_eq!(first.lines().collect::<Vec<_>>(), table.lines().take(3).collect::<Vec<_>>());
    let cells: Vec<&str> = table.lines().nth(1).unwrap().split(',').collect();
    let set: Vec<String> = [("noise", 4), ("share[0]", 5), ("share[1]", 6)]
        .map(|(name, at)| format!("{name}={}", cells[at]))
        .into();
    let mut again = vec!["simulate", "m.toml", "--steps", "2", "--set", "a=0.5"];
    set.iter().for_each(|set| again.extend(["--set", set]));
    let again = place.printed(&again);
    for (found, expected) in again.lines().zip(table.lines()).skip(1) {
        assert!(expected.starts_with(&format!("{found},")), "{found}: {expected}");
    }
    let none = place.run(&["simulate", "walk.toml", "--steps", "2", "--prior"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(stderr(&none).contains("no parameter of the model has a prior"), "{}", stderr(&none));
}
