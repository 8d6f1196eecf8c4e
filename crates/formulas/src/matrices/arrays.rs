//! The matrices of a file, beside the names of their rows and columns.

use faer::Mat;

/// `x_0 ~ N(m0, P0)`, `x_t = A x_{t−1} + b + B u_t + v_t`, `y_t = C x_t + d + D u_t + w_t`, where `v_t` and `w_t` have the covariances `Q` and `R`, and `S` between them.
#[derive(Debug)]
pub(super) struct Arrays {
    pub(super) states: Vec<String>,
    pub(super) measurements: Vec<String>,
    pub(super) inputs: Vec<String>,
    /// `m0`.
    pub(super) mean: Vec<f64>,
    /// `P0`.
    pub(super) initial: Mat<f64>,
    /// `A`, `b` and `B`.
    pub(super) transition: Affine,
    /// `C`, `d` and `D`.
    pub(super) measurement: Affine,
    /// `Q`.
    pub(super) state_noise: Mat<f64>,
    /// `R`.
    pub(super) measurement_noise: Mat<f64>,
    /// `S`, if there is one.
    pub(super) shared_noise: Option<Mat<f64>>,
}

/// A map of states and inputs.
#[derive(Debug)]
pub(super) struct Affine {
    pub(super) of_states: Mat<f64>,
    pub(super) offset: Vec<f64>,
    pub(super) of_inputs: Mat<f64>,
}
