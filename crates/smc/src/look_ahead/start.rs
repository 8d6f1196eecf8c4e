//! Where a smoother begins: the means of an extended Kalman filter.

use motes_models::equations::triangle::{factor, solve_lower, solve_upper};
use motes_models::{ModelError, StateSpaceModel};

use super::dense::{
    add_product_of_transposed, add_times, add_transposed_times, dot, product, product_of_transposed,
};
use super::local::{Local, LocalMap, LocalSite};
use super::path::Path;
use super::recorded::RecordedStep;
use super::rollout::SHARES;

/// A Gaussian belief.
struct Belief {
    mean: Vec<f64>,
    /// `P`, `N×N`.
    covariance: Vec<f64>,
}

impl Belief {
    /// `P ← F P Fᵀ + G Gᵀ`.
    fn predict(&mut self, map: &LocalMap) {
        let n = map.value.len();
        let q = map.along_noise.len() / n;
        let transposed = |matrix: &[f64], columns: usize| -> Vec<f64> {
            (0..columns * n).map(|place| matrix[place % n * columns + place / n]).collect()
        };
        let of_noise = transposed(&map.along_noise, q);
        let mut next = vec![0.0; n * n];
        if !map.along_previous.is_empty() {
            let mut half = vec![0.0; n * n];
            product(&map.along_previous, &self.covariance, [n, n, n], &mut half);
            product(&half, &transposed(&map.along_previous, n), [n, n, n], &mut next);
        }
        add_product_of_transposed(&of_noise, &of_noise, [n, q, n], &mut next);
        self.covariance = next;
        self.mean.clone_from(&map.value);
    }

    /// The move `δ = P⁺ s` of the mean by a site, `δᵀP⁻¹δ`, and `P⁺ = (P⁻¹ + RᵀR)⁻¹` in the place of `P`, which need not be invertible.
    fn correct(&mut self, site: &LocalSite) -> (Vec<f64>, f64) {
        let (n, p) = (self.mean.len(), &mut self.covariance);
        let k = site.roots.len() / n;
        let mut of_roots = vec![0.0; k * n];
        product(&site.roots, p, [k, n, n], &mut of_roots);
        let mut lower = Vec::with_capacity(k * (k + 1) / 2);
        for i in 0..k {
            for j in 0..=i {
                let sum = dot(&of_roots[i * n..][..n], &site.roots[j * n..][..n]);
                lower.push(if i == j { 1.0 + sum } else { sum });
            }
        }
        factor(k, &mut lower);
        let mut pulled = vec![0.0; k];
        add_times(&of_roots, &site.slope, &mut pulled);
        solve_lower(k, &lower, &mut pulled);
        solve_upper(k, &lower, &mut pulled);
        pulled.iter_mut().for_each(|entry| *entry = -*entry);
        let mut rest = site.slope.clone();
        add_transposed_times(&site.roots, &pulled, &mut rest);
        let mut moved = vec![0.0; n];
        add_times(p, &rest, &mut moved);
        let size = dot(&moved, &rest);
        // P − (R P)ᵀ S⁻¹ R P by the half of it.
        let mut half = vec![0.0; k * n];
        let mut column = vec![0.0; k];
        for i in 0..n {
            column.iter_mut().enumerate().for_each(|(row, entry)| *entry = of_roots[row * n + i]);
            solve_lower(k, &lower, &mut column);
            column.iter().enumerate().for_each(|(row, entry)| half[row * n + i] = *entry);
        }
        let mut less = vec![0.0; n * n];
        product_of_transposed(&half, &half, [n, k, n], &mut less);
        p.iter_mut().zip(less).for_each(|(entry, less)| *entry -= less);
        (moved, size)
    }
}

/// The filtered means of an extended Kalman filter through a sequence, to which measurements say a share `tempered` of what they do; where it leaves the numbers, the predicted means.
///
/// # Errors
/// [`ModelError`] if the density of a measurement cannot be had.
pub(super) fn filtered_means<M: StateSpaceModel + ?Sized>(
    model: &M,
    local: &mut Local<'_>,
    recorded: &[RecordedStep],
    mut path: Path,
    tempered: f64,
) -> Result<Path, ModelError> {
    const COUNT: usize = SHARES.len();
    let n = path.width;
    let mut belief = Belief { mean: vec![0.0; n], covariance: vec![0.0; n * n] };
    let (mut map, mut site) = (LocalMap::default(), LocalSite::default());
    let (mut rows, mut likelihoods) = (vec![0.0; COUNT * n], [0.0; COUNT]);
    for (index, RecordedStep { step, measurement }) in recorded.iter().enumerate() {
        let (step, previous) = (step.step(), (index > 0).then(|| belief.mean.clone()));
        local.maps(&step, previous.as_deref(), path.noise(index), std::slice::from_mut(&mut map));
        belief.predict(&map);
        if measurement.iter().any(Option::is_some) {
            local.sites(&step, &belief.mean, |_| measurement, std::slice::from_mut(&mut site));
            site.slope.iter_mut().for_each(|slope| *slope *= tempered);
            site.roots.iter_mut().for_each(|root| *root *= tempered.sqrt());
            let (moved, size) = belief.correct(&site);
            for (row, share) in rows.chunks_exact_mut(n).zip(SHARES) {
                for ((x, mean), moved) in row.iter_mut().zip(&belief.mean).zip(&moved) {
                    *x = mean + share * moved;
                }
            }
            model.log_likelihoods(&step, &rows, measurement, &mut likelihoods)?;
            let value = |at: usize| {
                let value = tempered * likelihoods[at] - 0.5 * SHARES[at] * SHARES[at] * size;
                if value.is_nan() { f64::NEG_INFINITY } else { value }
            };
            let best = (0..COUNT).fold(0, |best, at| if value(at) > value(best) { at } else { best });
            let found = &rows[best * n..][..n];
            if found.iter().all(|x| x.is_finite()) {
                belief.mean.copy_from_slice(found);
            }
        }
        path.states[index * n..][..n].copy_from_slice(&belief.mean);
    }
    Ok(path)
}
