//! Bases: the designed proposals in whose units a learned one speaks.
//!
//! A base is one file with one function, and one line in [`Base`].

mod linearised;
mod site;
mod transition;

use motes_models::equations::Lanes;
use serde::{Deserialize, Serialize};
pub(super) use site::Site;

/// The designed proposal around which a learned one is built: `x = T(x_{t−1}, v)`, `v = b + L⁻ᵀ u`.
///
/// `T` transports standard normal noise `v` to the transition; `b` and `L` are the base's, and `u` is what the head has a density of. A `u` that is
/// standard normal gives the base itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Base {
    /// The transition: `b = 0`, `L = I`.
    Transition,
    /// One Fisher-scoring step from the predicted state, in units of the noise.
    Linearised,
}

impl Base {
    /// Writes `b` (`N`) and the lower triangle of `L` (`N(N+1)/2`); `scratch` has `N` entries. What it says may be used up.
    #[inline(always)]
    pub(super) fn place(
        self,
        said: Site<'_>,
        shift: &mut [Lanes],
        lower: &mut [Lanes],
        scratch: &mut [Lanes],
    ) {
        match self {
            Base::Transition => transition::place(shift, lower),
            Base::Linearised => linearised::place(said, shift, lower, scratch),
        }
    }
}
