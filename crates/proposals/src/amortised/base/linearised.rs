//! The linearised proposal as a base.

use motes_models::equations::Lanes;
use motes_models::equations::triangle::at;
use motes_smc::fisher_scoring;

use super::site::Site;

/// `L Lᵀ = I + Σ_j I_j J_j J_jᵀ` and `b = (L Lᵀ)⁻¹ Σ_j s_j J_j`: [`motes_smc::Linearised`] with the noise in the place of the state.
#[inline(always)]
pub(super) fn place(said: Site<'_>, shift: &mut [Lanes], lower: &mut [Lanes], scratch: &mut [Lanes]) {
    shift.fill(Lanes::from(0.0));
    lower.fill(Lanes::from(0.0));
    for i in 0..shift.len() {
        lower[at(i, i)] = Lanes::from(1.0);
    }
    fisher_scoring(shift, said.slopes, said.information, said.jacobian, lower, scratch);
}
