//! How many random numbers draws are made of.

/// How many numbers of the standard distributions draws take.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(in crate::equations) struct Needs {
    pub(in crate::equations) normals: usize,
    pub(in crate::equations) exponentials: usize,
    pub(in crate::equations) uniforms: usize,
}

impl Needs {
    pub(in crate::equations) const NOTHING: Needs = Needs { normals: 0, exponentials: 0, uniforms: 0 };
    pub(in crate::equations) const NORMAL: Needs = Needs { normals: 1, ..Needs::NOTHING };
    pub(in crate::equations) const EXPONENTIAL: Needs = Needs { exponentials: 1, ..Needs::NOTHING };
    pub(in crate::equations) const UNIFORM: Needs = Needs { uniforms: 1, ..Needs::NOTHING };

    pub(in crate::equations) const fn plus(self, other: Needs) -> Needs {
        Needs {
            normals: self.normals + other.normals,
            exponentials: self.exponentials + other.exponentials,
            uniforms: self.uniforms + other.uniforms,
        }
    }

    /// How many numbers in all.
    pub(in crate::equations) fn count(self) -> usize {
        self.normals + self.exponentials + self.uniforms
    }
}
