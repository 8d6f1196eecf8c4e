//! Arguments that are out of range are refused with their names.

use pyo3::PyResult;

use crate::errors::refused;

/// An integer from `least` to `most`.
pub(crate) fn integer(argument: &str, value: i64, least: usize, most: usize) -> PyResult<usize> {
    let found = usize::try_from(value).ok().filter(|value| (least..=most).contains(value));
    found.ok_or_else(|| refused(argument, value, &format!("an integer from {least} to {most}")))
}

/// A number from 0 to below 1.
pub(crate) fn share_of(argument: &str, value: f64) -> PyResult<f64> {
    match (0.0..1.0).contains(&value) {
        true => Ok(value),
        false => Err(refused(argument, value, "from 0 to below 1")),
    }
}

/// A seed of 64 bits.
pub(crate) fn seed_of(seed: i128) -> PyResult<u64> {
    u64::try_from(seed).map_err(|_| refused("seed", seed, "an integer from 0 to 2^64 − 1"))
}

/// A number of threads; all that there are if `None`.
pub(crate) fn threads_of(threads: Option<i64>) -> PyResult<Option<usize>> {
    threads.map(|threads| integer("threads", threads, 1, 1024)).transpose()
}
