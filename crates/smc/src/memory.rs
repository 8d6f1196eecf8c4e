//! What particles carry beside their state, how it follows them through resampling, and how blocks of it are lent.

/// Per-particle values that are resampled together with the particle that owns them.
pub trait ParticleMemory: Send + Sync {
    /// The memory of consecutive particles, to be advanced.
    type Rows<'a>: MemoryRows
    where
        Self: 'a;

    /// The memory of all particles.
    fn rows(&mut self) -> Self::Rows<'_>;

    /// Replaces the memory of particle `k` by that of particle `ancestors[k]`, for every `k` at once.
    fn resample(&mut self, ancestors: &[usize]);

    /// Whether it is the memory of as many particles as `other` is and in the same layout, whatever the values are. A filter that is restored asks it
    /// of the memory that was written down, beside what its proposal begins with.
    fn is_laid_out_as(&self, other: &Self) -> bool;
}

/// The memory of consecutive particles.
pub trait MemoryRows: Send + Sized {
    /// That of the first `particles` of them, and of the others.
    fn split(self, particles: usize) -> (Self, Self);
}

/// No memory at all.
impl ParticleMemory for () {
    type Rows<'a> = ();

    fn rows(&mut self) {}

    fn resample(&mut self, _ancestors: &[usize]) {}

    fn is_laid_out_as(&self, _other: &()) -> bool {
        true
    }
}

impl MemoryRows for () {
    fn split(self, _particles: usize) -> ((), ()) {
        ((), ())
    }
}

/// One value for each particle.
impl<T: Clone + Send + Sync> ParticleMemory for Vec<T> {
    type Rows<'a>
        = &'a mut [T]
    where
        T: 'a;

    fn rows(&mut self) -> &mut [T] {
        self
    }

    fn resample(&mut self, ancestors: &[usize]) {
        *self = ancestors.iter().map(|&ancestor| self[ancestor].clone()).collect();
    }

    /// By their number alone.
    fn is_laid_out_as(&self, other: &Self) -> bool {
        self.len() == other.len()
    }
}

impl<T: Send> MemoryRows for &mut [T] {
    fn split(self, particles: usize) -> (Self, Self) {
        self.split_at_mut(particles)
    }
}
