//! A quadratic log-function of a state, and what it says of the noise that makes the state.

use motes_models::equations::triangle::{at, factor, solve_lower, solve_upper};
use smallvec::SmallVec;

use super::dense::{
    add_product_of_transposed, add_transposed_times, product, product_of_transposed, subtract_times,
    subtract_transposed_times,
};

/// Few numbers of a step, kept where they are: there are many steps.
pub(super) type Numbers = SmallVec<[f64; 4]>;

/// `log ψ(x) = −½ (x − r)ᵀ A (x − r) + bᵀ (x − r)`, with a positive semidefinite `A`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Potential {
    /// `r`, `N`.
    pub(super) reference: Numbers,
    /// `A`, `N×N`.
    pub(super) curvature: Numbers,
    /// `b`, `N`.
    pub(super) slope: Numbers,
}

impl Potential {
    /// `log ψ(x)`.
    pub(super) fn log(&self, state: &[f64]) -> f64 {
        let d: Vec<f64> = state.iter().zip(&self.reference).map(|(x, r)| x - r).collect();
        let mut pull = self.slope.clone();
        for (row, pull) in self.curvature.chunks_exact(d.len()).zip(&mut pull) {
            *pull -= 0.5 * row.iter().zip(&d).map(|(entry, d)| entry * d).sum::<f64>();
        }
        pull.iter().zip(&d).map(|(pull, d)| pull * d).sum()
    }

    /// Whether all of it is finite.
    pub(super) fn is_finite(&self) -> bool {
        self.reference.iter().chain(&self.curvature).chain(&self.slope).all(|number| number.is_finite())
    }
}

/// What a potential says of noise `v ~ N(0, I)` and of `d`, where `x − r = d + G v`.
#[derive(Debug, Clone, Default)]
pub(super) struct Guidance {
    /// `K`, `Q×N`: the mean of `v` is `κ − K d`.
    pub(super) gain: Vec<f64>,
    /// `κ = Λ⁻¹ Gᵀ b`, `Q`.
    pub(super) offset: Vec<f64>,
    /// `M`, `N×N`: `log ∫ N(v; 0, I) ψ dv = −½ dᵀ M d + uᵀ d` but for a constant.
    pub(super) curvature: Vec<f64>,
    /// `u`, `N`.
    pub(super) slope: Vec<f64>,
    /// `A G` (`N×Q`), then `I − G K` (`N×N`), and the products of these with others.
    products: [Vec<f64>; 2],
    /// A column of `K`.
    column: Vec<f64>,
    /// The factor of `Λ = I + Gᵀ A G`.
    pub(super) lower: Vec<f64>,
}

impl Guidance {
    /// That of a potential through `G` (`N×Q`).
    pub(super) fn find(&mut self, potential: &Potential, along_noise: &[f64]) {
        let Potential { curvature, slope, .. } = potential;
        let n = slope.len();
        let q = along_noise.len() / n;
        let [first, second] = &mut self.products;
        for products in [&mut *first, &mut *second] {
            products.clear();
            products.resize(n * q.max(n), 0.0);
        }
        product(curvature, along_noise, [n, n, q], first);
        self.lower.clear();
        for i in 0..q {
            for j in 0..=i {
                let sum: f64 = (0..n).map(|l| along_noise[l * q + i] * first[l * q + j]).sum();
                self.lower.push(if i == j { 1.0 + sum } else { sum });
            }
        }
        debug_assert_eq!(self.lower.len(), at(q, 0));
        factor(q, &mut self.lower);
        // K, column by column.
        self.gain.clear();
        self.gain.resize(q * n, 0.0);
        let column = &mut self.column;
        column.clear();
        column.resize(q, 0.0);
        for i in 0..n {
            column.copy_from_slice(&first[i * q..][..q]);
            solve_lower(q, &self.lower, column);
            solve_upper(q, &self.lower, column);
            column.iter().enumerate().for_each(|(j, entry)| self.gain[j * n + i] = *entry);
        }
        self.offset.clear();
        self.offset.resize(q, 0.0);
        add_transposed_times(along_noise, slope, &mut self.offset);
        // u = b − Kᵀ Gᵀ b.
        self.slope.clear();
        self.slope.extend_from_slice(slope);
        subtract_transposed_times(&self.gain, &self.offset, &mut self.slope);
        solve_lower(q, &self.lower, &mut self.offset);
        solve_upper(q, &self.lower, &mut self.offset);
        // M as a sum of squares, which no rounding makes negative.
        let rest = first;
        product(along_noise, &self.gain, [n, q, n], rest);
        for (place, entry) in rest[..n * n].iter_mut().enumerate() {
            *entry = if place / n == place % n { 1.0 - *entry } else { -*entry };
        }
        product(curvature, &rest[..n * n], [n, n, n], second);
        self.curvature.clear();
        self.curvature.resize(n * n, 0.0);
        product_of_transposed(rest, second, [n, n, n], &mut self.curvature);
        add_product_of_transposed(&self.gain, &self.gain, [n, q, n], &mut self.curvature);
    }

    /// Adds what it says of `δ` where `d = d₀ + F δ` to a potential's curvature and slope.
    pub(super) fn add_through(&mut self, map: &[f64], at_zero: &[f64], potential: &mut Potential) {
        let n = at_zero.len();
        let mut pull = self.slope.clone();
        subtract_times(&self.curvature, at_zero, &mut pull);
        add_transposed_times(map, &pull, &mut potential.slope);
        let [first, _] = &mut self.products;
        first.resize(first.len().max(n * n), 0.0);
        product(&self.curvature, map, [n, n, n], first);
        add_product_of_transposed(map, &first[..n * n], [n, n, n], &mut potential.curvature);
    }
}
