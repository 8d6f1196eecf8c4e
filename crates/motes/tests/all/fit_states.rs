//! The states that a fit leaves in its folder, and what a budget leaves of a search.

use crate::common::stderr;
use crate::fit_command::place;

/// Catches states at other parameters than those that were fitted, and forecasts of other rows.
#[test]
fn a_fit_leaves_the_states_that_filters_find() {
    let place = place();
    let with = |method: &str, folder: &str| {
        place.printed(&[
            "fit",
            "nile.toml",
            "nile.csv",
            "-o",
            folder,
            "--method",
            method,
            "--forecast",
            "3",
            "--quiet",
        ]);
        let filter = [
            "filter",
            "nile.toml",
            "nile.csv",
            "--parameters",
            folder,
            "--proposal",
            "exact",
            "--predictive",
            "--forecast",
            "3",
            "--quiet",
        ];
        assert_eq!(place.read(&format!("{folder}/states.csv")), place.printed(&filter));
        assert_eq!(place.read(&format!("{folder}/states.csv")).lines().count(), 14);
    };
    with("posterior", "draws");
    with("maximum", "maximum");
    // States of another method do not stay.
    place.printed(&["fit", "nile.toml", "nile.csv", "-o", "draws", "--method", "maximum", "--quiet"]);
    assert_eq!(place.read("draws/states.csv").lines().count(), 11);
}

#[test]
fn proposals_are_compared_at_a_point_of_a_fit() {
    let place = place();
    place.printed(&["fit", "nile.toml", "nile.csv", "-o", "draws", "--draws", "100", "--quiet"]);
    let compare = |more: &[&str]| {
        let short = ["compare", "nile.toml", "--sequences", "2", "--steps", "5", "--sweep", "10", "--quiet"];
        place.run(&[&short, more].concat())
    };
    for point in [&["--parameters", "draws"][..], &["--parameters", "draws", "--at", "mean"]] {
        assert!(compare(point).status.success());
    }
    for (arguments, line) in [
        (
            vec!["--parameters", "draws", "--at", "maximum"],
            "motes: --parameters draws: it has draws of the posterior; --at maximum needs a fit by --method maximum",
        ),
        (
            vec!["--parameters", "draws", "--at", "draws"],
            "motes: --parameters draws: proposals are compared at one point; take --at mean",
        ),
        (
            vec!["--parameters", "draws", "--set", "level_variance=1"],
            "motes: --set level_variance: draws has values of it; leave out --set, or --parameters",
        ),
    ] {
        let refused = compare(&arguments);
        assert_eq!((refused.status.code(), stderr(&refused).as_str()), (Some(2), line));
    }
}

/// Catches a search that a budget takes everything from, and one that is called whole.
#[test]
fn a_budget_ends_searches_with_what_they_found() {
    let place = place();
    let fit = |seconds: &str, more: &[&str]| {
        let arguments =
            ["fit", "nile.toml", "nile.csv", "-o", "fit", "--method", "maximum", "--budget", seconds];
        place.run(&[&arguments[..], more].concat())
    };
    let none = fit("1e-9", &["--passes", "10", "--particles", "100", "--proposal", "bootstrap"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(
        stderr(&none).contains("--budget: 0.000000001 seconds ended it before the first search had ended")
    );
    let some = fit("1.5", &["--chains", "900"]);
    let said = stderr(&some);
    assert!(some.status.success(), "{said}");
    assert!(!said.contains("of draws from the prior"), "{said}");
    assert!(said.contains("--budget ended it with") && said.contains("the same command goes on"), "{said}");
    assert!(place.path("fit/maximum.csv").exists() && place.path("fit/progress.cbor").exists());
    assert!(place.path("fit/states.csv").exists());
}
