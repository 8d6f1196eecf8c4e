//! Reports of models with times and inputs.

use std::ops::ControlFlow;
use std::path::Path;

use motes::output::{Report, report};
use motes::{Data, FilterOptions, Model, ModelNames, filter};

/// The report of a filter of a model in `tests/models`.
fn page(folder: &Path, options: &FilterOptions) -> String {
    let model = Model::read(&folder.join("model.toml"), &[]).unwrap();
    let data = Data::open(&folder.join("data.csv"), &model).unwrap();
    let found = filter(&model, &data, options, |_| ControlFlow::Continue(())).unwrap();
    report(&Report {
        title: "Filter",
        names: &ModelNames::from(&model),
        data: &data,
        estimates: &found.estimates,
        quantiles: &options.quantiles,
        forecasts: &found.forecasts,
        summary: &[],
        settings: &[],
        warnings: &[],
        command: "motes filter",
    })
    .unwrap()
}

fn models() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/models"))
}

#[test]
fn axes_and_tables_have_dates_where_rows_have_them() {
    let options = FilterOptions { forecast: 4, ..FilterOptions::default() };
    let page = page(&models().join("days"), &options);
    // A mark behind the data, the axis's own name, and the worst measurement.
    assert!(page.contains("\n2024-03-09\n") && page.contains("\ndate\n"), "{page}");
    assert!(page.contains("<th>t</th><th>date</th>") && page.contains("<td>2024-03-06</td>"));
    assert!(!page.contains("(input)") && !page.contains("(pit)"));
}

#[test]
fn inputs_and_places_of_measurements_are_drawn() {
    let options = FilterOptions { predictive: true, ..FilterOptions::default() };
    let of_column = page(&models().join("surveys"), &options);
    assert!(of_column.contains("tested (input)") && of_column.contains("positive (measured)"));
    assert!(of_column.contains("positive: place among what was expected (pit)"));
    // An input of a file that the model names.
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
    write("rain.csv", "t,rain\n0,1\n1,3\n2,2\n3,4\n");
    write("data.csv", "y\n0.1\n1.2\n3.9\n");
    write(
        "model.toml",
        "[inputs]\nrain = { file = \"rain.csv\", between = \"hold\" }\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x + rain, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n",
    );
    assert!(page(place.path(), &options).contains("rain (input)"));
}
