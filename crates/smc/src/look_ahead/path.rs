//! A path through a sequence: its states and the noise that they are made of, and how it is to be moved.

use motes_models::equations::triangle;

/// States and noise of each step.
#[derive(Debug, Clone)]
pub(super) struct Path {
    /// `N`.
    pub(super) width: usize,
    /// `T×N`.
    pub(super) states: Vec<f64>,
    /// Of all steps, one after another.
    pub(super) noise: Vec<f64>,
    /// Where the noise of each step begins, and where all ends.
    pub(super) starts: Vec<usize>,
}

impl Path {
    /// A path without noise through so many draws of each step, whose states are not known yet.
    pub(super) fn without_noise(width: usize, draws: impl Iterator<Item = usize>) -> Self {
        let mut starts = vec![0];
        let mut end = 0;
        starts.extend(draws.map(|count| {
            end += count;
            end
        }));
        let steps = starts.len() - 1;
        Path { width, states: vec![0.0; steps * width], noise: vec![0.0; end], starts }
    }

    /// `T`.
    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// `x_t`.
    pub(super) fn state(&self, index: usize) -> &[f64] {
        &self.states[index * self.width..][..self.width]
    }

    /// `x_{t−1}`, if there is one.
    pub(super) fn previous(&self, index: usize) -> Option<&[f64]> {
        index.checked_sub(1).map(|before| self.state(before))
    }

    /// The numbers of the largest triangle of `Q×Q`.
    pub(super) fn factor_place(&self) -> usize {
        let draws = self.starts.windows(2).map(|pair| pair[1] - pair[0]);
        draws.max().map_or(0, |most| triangle::at(most, 0))
    }

    /// `v_t`.
    pub(super) fn noise(&self, index: usize) -> &[f64] {
        &self.noise[self.starts[index]..self.starts[index + 1]]
    }
}

/// How noise is to be moved: `v_t ← v̂_t + α w_t − C_t (x_{t−1} − x̂_{t−1})`.
#[derive(Debug, Clone, Default)]
pub(super) struct Policy {
    /// `w_t` of all steps, as the noise of a path.
    pub(super) moves: Vec<f64>,
    /// `C_t` (`Q×N`) of all steps.
    pub(super) feedback: Vec<f64>,
    /// The factors of `Λ_t = L Lᵀ` of all steps, each in a place of `Q(Q+1)/2` for the largest `Q`.
    pub(super) factors: Vec<f64>,
}
