//! Different numbers among many.

/// Counts them; what it allocates it keeps.
#[derive(Debug, Default)]
pub(super) struct Distinct {
    /// The round in which each number was last seen.
    seen: Vec<usize>,
    round: usize,
}

impl Distinct {
    /// How many of the numbers below `below` are among `numbers`.
    pub(super) fn count(&mut self, numbers: &[usize], below: usize) -> usize {
        self.round += 1;
        self.seen.resize(self.seen.len().max(below), 0);
        let is_new = |number: &&usize| std::mem::replace(&mut self.seen[**number], self.round) != self.round;
        numbers.iter().filter(is_new).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_counts_once_in_a_round() {
        let mut distinct = Distinct::default();
        assert_eq!(distinct.count(&[3, 1, 3, 3, 0], 4), 3);
        assert_eq!(distinct.count(&[3, 3], 4), 1);
        assert_eq!(distinct.count(&[9, 1, 9], 10), 2);
        assert_eq!(distinct.count(&[], 10), 0);
    }
}
