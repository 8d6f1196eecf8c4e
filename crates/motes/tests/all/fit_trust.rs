//! What a fit says against itself.

use crate::common::{Workplace, stderr};

const LEVEL: &str = r#"
[parameters]
phi = "uniform(0, 0.5)"
[initial]
x = "normal(0, 3)"
[transition]
x = "normal(phi*x, 1)"
[measurement]
y = "normal(x, 0.3)"
"#;

fn simulated(place: &Workplace, model: &str, more: &[&str]) {
    let simulate = [&["simulate", model, "--seed", "4", "-o", "data.csv"], more].concat();
    assert!(place.run(&simulate).status.success());
}

#[test]
fn draws_that_are_piled_up_at_the_end_of_a_prior_are_said() {
    let place = Workplace::new();
    place.write("level.toml", LEVEL);
    simulated(&place, "level.toml", &["--set", "phi=0.95", "--steps", "200"]);
    let fit = ["fit", "level.toml", "data.csv", "-o", "fit", "--draws", "300", "--strict"];
    let output = place.run(&fit);
    let said = "draws of phi are piled up at the upper end of its prior uniform(0, 0.5)";
    assert!(output.status.code() == Some(1) && stderr(&output).contains(said), "{}", stderr(&output));
    // Not where the prior has room, and not where the data say nothing.
    simulated(&place, "level.toml", &["--set", "phi=0.3", "--steps", "200"]);
    for steps in ["200", "1"] {
        simulated(&place, "level.toml", &["--set", "phi=0.3", "--steps", steps]);
        let output = place.run(&["fit", "level.toml", "data.csv", "-o", steps, "--draws", "300"]);
        assert!(!stderr(&output).contains("piled up"), "{}", stderr(&output));
    }
}

#[test]
fn shares_have_no_profiles_and_are_one_number_fewer() {
    let place = Workplace::new();
    let shares = r#"
[parameters]
w = "dirichlet(2, 2, 2)"
[initial]
x = "normal(0, 0.2)"
[transition]
x = "normal(0.5*x, 0.2)"
[measurement]
y = "normal(x + w[0], 0.1)"
z = "normal(x + w[1], 0.1)"
"#;
    place.write("shares.toml", shares);
    simulated(&place, "shares.toml", &["--steps", "60"]);
    let fit = ["fit", "shares.toml", "data.csv", "-o", "fit", "--method", "maximum", "--json"];
    let found: serde_json::Value = serde_json::from_str(&place.printed(&fit)).unwrap();
    assert_eq!(found["warnings"], serde_json::json!([]), "{found}");
    assert!(found["parameters"]["w[0]"]["low"].is_null(), "{found}");
    let aic = 4.0 - 2.0 * found["log_likelihood"].as_f64().unwrap();
    assert!((found["aic"].as_f64().unwrap() - aic).abs() < 1e-9, "{found}");
    let output = place.run(&[&fit[..4], &["other", "--method", "maximum", "--profile", "w[0]"]].concat());
    let said = "--profile w[0]: a share of a dirichlet has no profile";
    assert!(output.status.code() == Some(2) && stderr(&output).contains(said), "{}", stderr(&output));
}

#[test]
fn several_maxima_are_said() {
    let place = Workplace::new();
    let squared = LEVEL
        .replace("phi = \"uniform(0, 0.5)\"", "a = \"normal(0, 2)\"")
        .replace("phi*x, 1", "0.5*x, 0.5")
        .replace("normal(x, 0.3)", "normal(x + a^2, 0.3)");
    place.write("squared.toml", squared);
    simulated(&place, "squared.toml", &["--set", "a=2", "--steps", "60"]);
    let fit = ["fit", "squared.toml", "data.csv", "-o", "fit", "--method", "maximum", "--chains", "8"];
    let output = place.run(&fit);
    let said = "there are several maxima: searches came as high where a is";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
}

#[test]
fn draws_that_were_cut_off_and_filters_in_doubt_are_said() {
    let place = Workplace::new();
    place.write("level.toml", LEVEL);
    simulated(&place, "level.toml", &["--set", "phi=0.3", "--steps", "50"]);
    let fit = ["fit", "level.toml", "data.csv", "-o", "fit", "--draws", "100"];
    assert!(place.run(&fit).status.success());
    let filter = ["filter", "level.toml", "data.csv", "--parameters", "fit", "--strict"];
    let few = [&filter[..], &["--proposal", "bootstrap", "--particles", "3"]].concat();
    let output = place.run(&few);
    let said = "draws of the parameters the filter is not to be trusted; the first: ";
    assert!(output.status.code() == Some(1) && stderr(&output).contains(said), "{}", stderr(&output));
    assert!(place.run(&filter).status.success());
    let whole = place.read("fit/draws.csv");
    let lines: Vec<&str> = whole.lines().collect();
    for cut in [whole[..whole.len() - 4].to_string(), lines[..lines.len() - 30].join("\n") + "\n"] {
        place.write("fit/draws.csv", cut);
        let output = place.run(&filter);
        let said = stderr(&output);
        assert!(said.contains("draws.csv") && said.contains("the file was cut off; fit it again"), "{said}");
        assert!(!output.status.success() && said.lines().count() == 1, "{said}");
    }
}
