//! State-space models read from files of formulas.
//!
//! A file says how a model's coordinates are distributed; [`read`] makes a model of it that can be drawn from, weighed and differentiated.
//!
//! ```
//! use motes_formulas::{FileModel, parse};
//! use motes_models::{Seed, simulate};
//!
//! let text = r#"
//!     name = "walk"
//!     [initial]
//!     x = "normal(0, 1)"
//!     [transition]
//!     x = "normal(x, 0.1)"
//!     [measurement]
//!     y = "student_t(4, x, 0.5)"
//! "#;
//! let file = parse(text, "walk.toml", &[])?;
//! assert_eq!((file.states, file.measurements), (vec!["x".to_string()], vec!["y".to_string()]));
//! let FileModel::Formulas(model) = file.model else { unreachable!("there are no matrices") };
//! let data = simulate(&model, 50, &mut Seed::from_u64(1).stream())?;
//! assert_eq!(data.measurements.len(), 50);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod closed_form;
mod coordinates;
mod describe;
mod document;
mod equations;
mod error;
mod exact;
mod explain;
mod file;
mod finite;
mod frame;
mod graph;
mod impossible;
mod matrices;
mod model;
mod names;
mod operations;
mod priors;
mod program;
mod schedule;
mod simulation;
mod state_space;
mod statement;
mod support;
mod syntax;
mod tables;
mod text;

pub use closed_form::NoClosedForm;
pub use coordinates::Coordinates;
pub use describe::Description;
pub use equations::FormulaEquations;
pub use error::{ComposedProblem, FileError, Place, Problem};
pub use explain::DomainError;
pub use file::{FileModel, ModelFile, parse, parse_generated, read};
pub use frame::{Frame, InputUse};
pub use impossible::Impossible;
pub use model::FormulaModel;
pub use priors::{Origin, Prior};
pub use schedule::{MOST_SUB_STEPS, Schedule};
pub use simulation::NoSimulation;
pub use statement::{Between, InputRule, InputSource, TimeLabel, TimeRule, TimeUnit};
pub use support::{End, Support};
pub use tables::{Family, Range, family, reference};

/// The README's code, compiled and run as a documentation test.
#[doc = include_str!("../README.md")]
#[cfg(doctest)]
pub struct Readme;
