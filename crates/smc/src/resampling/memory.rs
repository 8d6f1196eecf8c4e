//! What particles carry beside their state, and how it follows them through resampling.

/// Per-particle values that are resampled together with the particle that owns them.
pub trait ParticleMemory {
    /// Replaces the memory of particle `k` by that of particle `ancestors[k]`, for every `k` at once.
    fn resample(&mut self, ancestors: &[usize]);
}

/// No memory at all.
impl ParticleMemory for () {
    fn resample(&mut self, _ancestors: &[usize]) {}
}

/// One value for each particle.
impl<T: Clone> ParticleMemory for Vec<T> {
    fn resample(&mut self, ancestors: &[usize]) {
        *self = ancestors.iter().map(|&ancestor| self[ancestor].clone()).collect();
    }
}
