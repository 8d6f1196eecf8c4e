//! What is known where a formula stands.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::meaning::Meaning;
use super::total::Totals;
use crate::error::Section;

/// What is known to a formula.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scope<'a> {
    pub(crate) names: &'a BTreeMap<String, Meaning>,
    pub(crate) section: Section,
    /// Whose formula it is.
    pub(crate) own: &'a str,
    /// Whether it is the formula of a vector.
    pub(crate) is_vector: bool,
    /// Whether it is that of several coordinates.
    pub(crate) is_of_several: bool,
    /// Of a measurement, which one it is, and the totals over sub-steps so far: it may add others.
    pub(crate) totals: Option<(usize, &'a RefCell<Totals>)>,
    /// The arguments of the function whose formula it is; none elsewhere. They come before all other names.
    pub(crate) arguments: &'a [String],
}

/// A sum that is read.
pub(super) struct Along<'a> {
    /// The name of its index.
    pub(super) index: &'a str,
    /// The value of the index now.
    pub(super) value: usize,
    /// How long the vectors and lists are that the index goes along, once there is one.
    pub(super) length: Option<usize>,
}
