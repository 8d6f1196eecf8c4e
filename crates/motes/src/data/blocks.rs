//! Labels that stand in blocks: they may tell sequences apart.

/// A label, and the rows from its first to its last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block<'a> {
    pub(super) label: &'a str,
    pub(super) first: usize,
    pub(super) last: usize,
}

/// The blocks of labels, if there are several, each label has one of its own, and they have a row and a half at least on average.
pub(super) fn blocks<'a>(labels: &[&'a str]) -> Option<Vec<Block<'a>>> {
    let mut found: Vec<Block<'a>> = Vec::new();
    for (row, label) in labels.iter().map(|label| label.trim()).enumerate() {
        match found.last_mut() {
            _ if label.is_empty() => return None,
            Some(block) if block.label == label => block.last = row,
            _ => found.push(Block { label, first: row, last: row }),
        }
    }
    let mut names: Vec<&str> = found.iter().map(|block| block.label).collect();
    names.sort_unstable();
    let is_once = names.windows(2).all(|pair| pair[0] != pair[1]);
    (found.len() >= 2 && is_once && 2 * labels.len() >= 3 * found.len()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn firsts(labels: &str) -> Option<Vec<usize>> {
        let labels: Vec<&str> = labels.split(',').collect();
        blocks(&labels).map(|blocks| blocks.iter().map(|block| block.first).collect())
    }

    #[test]
    fn each_label_has_one_block() {
        assert_eq!(firsts("a,a,b,b,b"), Some(vec![0, 2]));
        assert_eq!(firsts("7,7,9"), Some(vec![0, 2]));
        for none in ["a,b,c", "a,a,a", "a,a,b,b,a,a", "a,b,a,b", "a,a,,", "a,b,c,c", ""] {
            assert_eq!(firsts(none), None, "{none}");
        }
    }
}
