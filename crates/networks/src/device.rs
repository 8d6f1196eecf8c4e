//! Whether what computes the networks is there.

use crate::backend::Backend;
use crate::error::NetworkError;

/// Opens the device that a backend computes on, so that a run need not begin where there is none.
///
/// # Errors
/// As [`Backend::check`]; [`NetworkError::Backend`] where there is no graphics processor that answers.
pub fn open_device(backend: Backend) -> Result<(), NetworkError> {
    backend.check()?;
    #[cfg(feature = "burn")]
    if backend != Backend::Native {
        crate::by_burn::Library::of(backend.into())?;
    }
    Ok(())
}
