//! Potentials that are learned over the prior of a model's parameters: one folder for all of them.

use crate::common::{Workplace, stderr};
use serde_json::Value;

const VOLATILITY: &str = r#"
[parameters]
sigma = "log_normal(log(0.3), 0.4)"
[initial]
h = "normal(0, 3*sigma)"
[transition]
h = "normal(0.95*h, sigma)"
[measurement]
y = "normal(0, exp(h/2))"
"#;

/// What is said while a folder is learned.
fn learn(place: &Workplace, folder: &str, more: &[&str]) -> String {
    let output = place.run(&[&["learn", "volatility.toml", "-o", folder, "--sequences", "0"], more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    stderr(&output)
}

fn place() -> Workplace {
    let place = Workplace::new();
    place.write("volatility.toml", VOLATILITY);
    let found = learn(&place, "p", &["--updates", "1000"]);
    assert!(found.contains("motes: chosen: potentials alone, over the prior of sigma"), "{found}");
    let simulate = ["simulate", "volatility.toml", "--steps", "80", "--set", "sigma=0.6", "--seed", "4"];
    place.write("data.csv", place.printed(&simulate));
    place
}

/// `log ẑ` and its standard error.
fn evidence(place: &Workplace, more: &[&str]) -> (f64, f64) {
    let all = [&["evidence", "volatility.toml", "data.csv", "--json", "--quiet"], more].concat();
    let found: Value = serde_json::from_str(&place.printed(&all)).unwrap();
    (found["log_evidence"].as_f64().unwrap(), found["standard_error"].as_f64().unwrap())
}

/// Catches a folder that is taken for one of another model as soon as a parameter is set, and units of another one.
#[test]
fn one_folder_serves_all_parameters() {
    let place = place();
    for sigma in ["sigma=0.2", "sigma=0.6"] {
        let of = |proposal: &str, particles: &str, runs: &str| {
            let more = ["--set", sigma, "--proposal", proposal, "--particles", particles, "--runs", runs];
            evidence(&place, &more)
        };
        let (learned, error) = of("p", "100", "20");
        let (reference, of_reference) = of("bootstrap", "20000", "4");
        let off = (learned - reference) / error.hypot(of_reference);
        assert!(off.abs() < 4.0, "{sigma}: {learned} ± {error} beside {reference} ± {of_reference}");
        assert!(error < 0.5 * of("bootstrap", "100", "20").1, "{sigma}: {error}");
        let filter = ["filter", "volatility.toml", "data.csv", "--proposal", "p", "--set", sigma, "--json"];
        let found: Value = serde_json::from_str(&place.printed(&filter)).unwrap();
        assert!((found["log_evidence"].as_f64().unwrap() - reference).abs() < 2.0, "{found}");
    }
    // Beyond the prior the evidence is as unbiased; that networks have never seen such models is said.
    let beyond =
        ["evidence", "volatility.toml", "data.csv", "--proposal", "p", "--set", "sigma=3", "-o", "x.csv"];
    let said = stderr(&place.run(&beyond));
    assert!(
        said.contains("--proposal p was learned over the prior, and sigma = 3 lies outside of"),
        "{said}"
    );
}

#[test]
fn parameters_are_fitted_with_it() {
    let place = place();
    let fit = |proposal: &str, folder: &str| -> Value {
        let command =
            ["fit", "volatility.toml", "data.csv", "-o", folder, "--proposal", proposal, "--draws", "300"];
        let found = place.printed(&[&command[..], &["--json", "--quiet"]].concat());
        serde_json::from_str(&found).unwrap()
    };
    let (learned, designed) = (fit("p", "learned"), fit("bootstrap", "designed"));
    let of = |found: &Value, key: &str| found["parameters"]["sigma"][key].as_f64().unwrap();
    let error = of(&learned, "mcse").hypot(of(&designed, "mcse"));
    assert!((of(&learned, "mean") - of(&designed, "mean")).abs() < 5.0 * error, "{learned} {designed}");
}

#[test]
fn another_prior_is_refused() {
    let place = place();
    place.write("other.toml", VOLATILITY.replace("0.4)", "0.5)"));
    let refused = |arguments: &[&str]| {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        stderr(&output)
    };
    let said = "motes: --proposal p: it was learned over sigma ~ log_normal(log(0.3), 0.4), and the model has sigma ~ log_normal(log(0.3), 0.5); learn it again";
    assert_eq!(refused(&["evidence", "other.toml", "data.csv", "--proposal", "p", "--quiet"]), said);
    // One that was learned for a value serves that value.
    learn(&place, "one", &["--updates", "20", "--set", "sigma=0.6"]);
    let at =
        |sigma| ["evidence", "volatility.toml", "data.csv", "--proposal", "one", "--set", sigma, "--quiet"];
    place.printed(&at("sigma=0.6"));
    let found = refused(&at("sigma=0.5"));
    assert!(found.contains("was trained for another system"), "{found}");
    let from = ["learn", "volatility.toml", "-o", "more", "--from", "p", "--quiet"];
    let said =
        "motes: --proposal p: it holds potentials alone, learned over a prior, which are not learned further";
    assert_eq!(refused(&from), said);
    // A network of some kind is one for the prior's median.
    learn(&place, "median", &["--updates", "20", "--widths", "8"]);
    let fit = ["fit", "volatility.toml", "data.csv", "-o", "fit", "--proposal", "median", "--quiet"];
    let said = "motes: --proposal median: it was learned for one value of sigma, which is to be fitted; motes learn MODEL -o FOLDER, without data, --set sigma and options of a network, learns over the prior";
    assert_eq!(refused(&fit), said);
    // One that another version saved.
    let file = place.path("median/proposal.toml");
    let saved = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, saved.replace("format = 3", "format = 2")).unwrap();
    let said = "motes: median: it was saved in format 2, and format 3 is read; learn it again, as by motes learn MODEL --output median";
    assert_eq!(refused(&fit), said);
}

/// Catches units of steps that the data do not have.
#[test]
fn with_times_or_data_it_is_learned_for_the_values_at_hand() {
    let place = Workplace::new();
    place.write("volatility.toml", format!("[time]\ncolumn = \"t\"\nstep = 0.5\n{VOLATILITY}"));
    let quick = ["--updates", "20", "--quiet"];
    learn(&place, "timed", &quick);
    assert!(place.path("timed/proposal.toml").exists());
    place.write("volatility.toml", VOLATILITY);
    place.write(
        "data.csv",
        place.printed(&["simulate", "volatility.toml", "--steps", "30", "--seed", "4", "--quiet"]),
    );
    let beside = ["learn", "volatility.toml", "data.csv", "-o", "beside", "--sequences", "0"];
    place.printed(&[&beside[..], &quick].concat());
    assert!(place.path("beside/proposal.toml").exists());
    learn(&place, "alone", &quick);
    assert!(!place.path("alone/proposal.toml").exists());
}
