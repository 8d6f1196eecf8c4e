//! Which series are simulated.

use crate::data::Data;

/// How many rows a series has, and where their times and inputs come from.
#[derive(Clone, Copy)]
pub(crate) enum Plan<'a> {
    /// So many rows, one unit of time apart, with inputs as the model simulates them.
    Rows(usize),
    /// The times and inputs of a series of data.
    Along(&'a Data, usize),
    /// The same, where inputs that nothing was measured by have the value of the row before: a simulation has all measurements.
    Like(&'a Data, usize),
}

impl Plan<'_> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Plan::Rows(count) => *count,
            Plan::Along(data, series) | Plan::Like(data, series) => data.of_series(*series).count(),
        }
    }
}

/// So many series along each series of data.
pub(crate) fn plans_along(data: &Data, series: usize) -> Vec<Plan<'_>> {
    let plans = (0..data.series.len()).flat_map(|of| std::iter::repeat_n(Plan::Along(data, of), series));
    plans.collect()
}

/// What the series of plans are called. Inputs of files go by the names of series, which one copy of each keeps.
pub(crate) fn names(plans: &[Plan<'_>]) -> Vec<String> {
    let name = |(number, plan): (usize, &Plan<'_>)| match plan {
        Plan::Along(data, series) if data.columns.has_series() => {
            let copies = plans.len() / data.series.len().max(1);
            match copies {
                0 | 1 => data.series[*series].clone(),
                _ => format!("{}.{}", data.series[*series], number % copies),
            }
        }
        _ => number.to_string(),
    };
    plans.iter().enumerate().map(name).collect()
}
