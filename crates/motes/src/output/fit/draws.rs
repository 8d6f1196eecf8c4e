//! The draws of a fit as a table.

use crate::fitting::{OF_DRAW, PosteriorFit};
use crate::output::csv::line;
use crate::output::number::text;

/// A line for each draw: `chain`, `draw`, `log_evidence` and the parameters.
pub fn fit_draws(fitted: &PosteriorFit) -> String {
    let header: Vec<String> =
        OF_DRAW.map(String::from).into_iter().chain(fitted.names.iter().cloned()).collect();
    let mut table = line(&header);
    for (number, chain) in fitted.chains.iter().enumerate() {
        for (draw, log_evidence) in chain.log_evidence.iter().enumerate() {
            let cells = [number.to_string(), draw.to_string(), text(*log_evidence)];
            let values = fitted.values(number, draw).iter().map(|value| text(*value));
            table += &line(&cells.into_iter().chain(values).collect::<Vec<String>>());
        }
    }
    table
}
