//! Graphics processors: found once, or said not to be there.

use std::panic::catch_unwind;
use std::sync::{Mutex, PoisonError};

use burn::tensor::{DType, Device, Tensor, TensorData};

use crate::error::NetworkError;

/// Devices that have answered, or why not.
static KNOWN: Mutex<Vec<(&str, Result<Device, String>)>> = Mutex::new(Vec::new());

/// The device that `open` opens, once it has added two numbers. Libraries panic where there is none, which is caught here, once.
///
/// # Errors
/// [`NetworkError::Backend`] with what they said.
pub(super) fn device(name: &'static str, open: fn() -> Device) -> Result<Device, NetworkError> {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let found = match known.iter().find(|(other, _)| *other == name) {
        Some((_, found)) => found.clone(),
        None => {
            let found = answering(open);
            known.push((name, found.clone()));
            found
        }
    };
    found.map_err(|said| NetworkError::Backend { reason: format!("{name} has no device here: {said}") })
}

fn answering(open: fn() -> Device) -> Result<Device, String> {
    let try_it = || {
        let device = open();
        let one = Tensor::<1>::from_data(TensorData::new(vec![1.0_f32], [1]), (&device, DType::F32));
        let two = (one.clone() + one).try_into_vec_as::<f64>().map_err(|error| error.to_string())?;
        if two == [2.0] { Ok(device) } else { Err(format!("1 + 1 is {two:?}")) }
    };
    let panicked = catch_unwind(try_it);
    panicked.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        Err(text.lines().next().unwrap_or_default().to_string())
    })
}
