//! The compiled part of the Python package `motes`: models, filters and learning by the crate `motes`, on arrays.
//!
//! The package's own Python code makes tables of data frames and lists, and gives results their shape; see `python/motes`.

mod arguments;
mod call;
mod card;
mod comparison;
mod data;
mod errors;
mod estimates;
mod evidence;
mod file;
mod filtered;
mod filtering;
mod fit_arguments;
mod functions;
mod inputs;
mod learned;
mod maximum_fit;
mod model;
mod of_functions;
mod online;
mod options;
mod posterior_fit;
mod simulated;
mod work;

use pyo3::prelude::*;

/// The functions and classes that the Python code of the package is made on.
#[pymodule]
mod _motes {
    #[pymodule_export]
    use crate::card::Card;
    #[pymodule_export]
    use crate::data::Data;
    #[pymodule_export]
    use crate::evidence::evidence;
    #[pymodule_export]
    use crate::file::write;
    #[pymodule_export]
    use crate::filtered::Filtered;
    #[pymodule_export]
    use crate::filtering::filter;
    #[pymodule_export]
    use crate::inputs::{columns_of_inputs, inputs_of_table, open_inputs};
    #[pymodule_export]
    use crate::learned::Proposal;
    #[pymodule_export]
    use crate::maximum_fit::{MaximumFit, maximise};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::of_functions::of_functions;
    #[pymodule_export]
    use crate::online::Online;
    #[pymodule_export]
    use crate::options::FilterOptions;
    #[pymodule_export]
    use crate::posterior_fit::{
        PosteriorFit, filter_over, fit, free_parameters, log_evidence_at, prior_draws, with_parameters,
    };

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
