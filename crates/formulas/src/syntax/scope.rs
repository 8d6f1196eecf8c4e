//! What is known where a formula stands.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::meaning::Meaning;
use super::sum::Sums;
use crate::error::Section;

/// What is known to a formula.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scope<'a> {
    pub(crate) names: &'a BTreeMap<String, Meaning>,
    pub(crate) section: Section,
    /// Whether it is the formula of a vector.
    pub(crate) is_vector: bool,
    /// Of a measurement, which one it is, and the sums over sub-steps so far: it may add others.
    pub(crate) sums: Option<(usize, &'a RefCell<Sums>)>,
}
