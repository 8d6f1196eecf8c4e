//! Experiments that reproduce the paper: configuration, runner, metrics, tables and figures.
