//! Memory that is used again: a step needs the same sizes as the step before it.

use std::collections::HashMap;

/// Free pieces of memory by their length.
pub(crate) struct Buffers<T> {
    free: HashMap<usize, Vec<Vec<T>>>,
    /// Those of threads that help.
    others: Vec<Buffers<T>>,
}

impl<T> Default for Buffers<T> {
    fn default() -> Self {
        Buffers { free: HashMap::new(), others: Vec::new() }
    }
}

impl<T: Copy + Default> Buffers<T> {
    /// A piece of the given length that holds anything.
    pub(crate) fn take(&mut self, len: usize) -> Vec<T> {
        self.free.get_mut(&len).and_then(Vec::pop).unwrap_or_else(|| vec![T::default(); len])
    }

    /// Takes a piece back.
    pub(crate) fn put(&mut self, values: Vec<T>) {
        self.free.entry(values.len()).or_default().push(values);
    }

    /// The buffers of a thread that helps.
    pub(super) fn take_others(&mut self) -> Buffers<T> {
        self.others.pop().unwrap_or_default()
    }

    /// Takes them back.
    pub(super) fn put_others(&mut self, others: Buffers<T>) {
        self.others.push(others);
    }
}
