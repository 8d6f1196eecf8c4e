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

/// Two modes on either side of the prior's centre have its mean and its standard deviation, and say much.
#[test]
fn a_posterior_of_two_modes_is_not_its_prior() {
    let place = crate::common::Workplace::new();
    place.write(
        "m.toml",
        "[parameters]\na = \"normal(0, 2)\"\n[initial]\nx = \"normal(0, 0.1)\"\n[transition]\nx = \"normal(0.5*x, 0.1)\"\n[measurement]\ny = \"normal(x + abs(a), 0.5)\"\n",
    );
    place.write("d.csv", "y\n2.1\n1.8\n2.3\n2.0\n1.9\n2.2\n2.1\n1.7\n2.0\n2.1\n");
    let output = place.run(&["fit", "m.toml", "d.csv", "-o", "fit", "--draws", "1000"]);
    let said = crate::common::stderr(&output);
    assert!(!said.contains("the data say nothing"), "{said}");
    // Nor is it said of paths that follow two particles of each draw.
    let smooth = place.run(&["smooth", "m.toml", "d.csv", "--parameters", "fit", "--proposal", "bootstrap"]);
    assert!(
        !crate::common::stderr(&smooth).contains("paths pass through"),
        "{}",
        crate::common::stderr(&smooth)
    );
}

#[test]
fn counts_have_a_likelihood_at_their_mean_and_no_maximum_uphill() {
    let place = crate::common::Workplace::new();
    place.write(
        "m.toml",
        "[parameters]\nn = \"poisson(6)\"\n[initial]\nx = \"normal(0, 0.1)\"\n[transition]\nx = \"normal(0.5*x, 0.1)\"\n[measurement]\ny = \"binomial(n + 20, 0.5)\"\n",
    );
    place.write("d.csv", "y\n13\n12\n15\n13\n");
    let json = place.printed(&["fit", "m.toml", "d.csv", "-o", "fit", "--draws", "200", "--json", "--quiet"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(json["log_likelihood"].is_number(), "{json}");
    let refused = place.run(&["fit", "m.toml", "d.csv", "-o", "maximum", "--method", "maximum"]);
    let line = "motes: --method maximum: n is a count, and searches go uphill between numbers; fix it by --set n=…, or take draws of the posterior";
    assert_eq!(crate::common::stderr(&refused), line);
}

/// Values that a prior allows make the data impossible at its median.
#[test]
fn data_need_not_be_possible_at_the_median_of_a_prior() {
    let place = crate::common::Workplace::new();
    place.write(
        "m.toml",
        "[parameters]\nm = \"uniform(0, 7)\"\n[initial]\nx = \"normal(0, 0.1)\"\n[transition]\nx = \"normal(0.5*x, 0.1)\"\n[measurement]\ny = \"uniform(-m, m)\"\n",
    );
    place.write("d.csv", "y\n3.61\n1\n-2\n");
    let output = place.run(&["fit", "m.toml", "d.csv", "-o", "fit", "--draws", "200"]);
    assert!(output.status.success(), "{}", crate::common::stderr(&output));
    assert!(crate::common::stderr(&output).contains("of draws from the prior the likelihood is 0"));
    place.write("none.csv", "y\n9\n1\n-2\n");
    let output = place.run(&["fit", "m.toml", "none.csv", "-o", "other", "--draws", "200"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(crate::common::stderr(&output).contains("9 is no value of uniform(-m, m)"));
}
