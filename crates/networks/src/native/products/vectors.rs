//! Pairs of vectors at the edge of a matrix, where there may be too few numbers for them.

use pulp::Simd;

/// Two vectors from the beginning of a slice, with zeros where it is too short.
#[inline(always)]
pub(super) fn load_two<S: Simd>(simd: S, values: &[f32]) -> [S::f32s; 2] {
    let lanes = S::F32_LANES;
    if values.len() == 2 * lanes {
        let (vectors, _) = S::as_simd_f32s(values);
        [vectors[0], vectors[1]]
    } else {
        let (first, second) = values.split_at(values.len().min(lanes));
        [simd.partial_load_f32s(first), simd.partial_load_f32s(second)]
    }
}

/// Writes two vectors to a slice, or as much of them as it takes.
#[inline(always)]
pub(super) fn store_two<S: Simd>(simd: S, values: &mut [f32], vectors: [S::f32s; 2]) {
    let lanes = S::F32_LANES;
    if values.len() == 2 * lanes {
        let (places, _) = S::as_mut_simd_f32s(values);
        (places[0], places[1]) = (vectors[0], vectors[1]);
    } else {
        let (first, second) = values.split_at_mut(values.len().min(lanes));
        simd.partial_store_f32s(first, vectors[0]);
        simd.partial_store_f32s(second, vectors[1]);
    }
}
