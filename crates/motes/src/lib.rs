//! State-space models from files or from Rust, and what a particle filter makes of data: hidden states, evidence, and a warning when neither can be
//! trusted.
//!
//! This crate is the command `motes`, the functions that it is made of, and a prelude for programs of one's own. The parts can be had one by one: they are
//! re-exported as [`models`], [`smc`] and [`formulas`].
//!
//! ```
//! use motes::{Data, FilterOptions, Model, filter};
//!
//! let text = r#"
//!     [initial]
//!     level = "normal(1000, 1000)"
//!     [transition]
//!     level = "normal(level, 38)"
//!     [measurement]
//!     flow = "normal(level, 123)"
//! "#;
//! let model = Model::parse(text, "nile", &[])?;
//! let data = Data::read("year,flow\n1871,1120\n1872,1160\n1873,\n1874,1210\n".as_bytes(), "nile.csv", &model)?;
//! let filtered = filter(&model, &data, &FilterOptions::default(), |_| std::ops::ControlFlow::Continue(()))?;
//! println!("log-evidence {:.2}", filtered.log_evidence());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod calendar;
mod checking;
mod checkpoint;
mod comparing;
mod contender;
mod continuations;
mod cost;
mod data;
mod engine;
mod error;
mod estimate;
mod evidence;
mod evidence_estimate;
mod exact;
mod exact_system;
mod few_ancestors;
mod filter_choice;
mod filter_source;
mod filtered;
mod filtering;
mod fit_comparison;
mod fit_folder;
mod fitting;
mod forecasting;
mod known_inputs;
mod learned;
mod learned_notes;
mod learned_steps;
mod learning;
mod long_step;
mod missed_mass;
mod mixture;
mod model;
mod model_steps;
mod names;
mod options;
pub mod output;
mod outside_prior;
mod own_model;
mod packed;
mod particles;
mod prediction;
mod priors;
mod quantiles;
mod recorded;
mod rows_ahead;
mod running_state;
mod scheduled_model;
mod sight;
mod simulating;
mod simulation_failure;
mod simulation_plan;
mod smoothing;
mod steps;
mod tally;
mod threads;
mod timeline;
mod training_prior;
mod warning;

pub use calendar::NoTime;
pub use checking::{CheckReport, check};
pub use comparing::{
    Card, CompareOptions, Comparison, ComparisonProgress, EqualTime, Figure, Gain, MOST_REFERENCE_FILTERS,
    Paired, Point, Sequence, TimeToError, compare, designed, designed_for_recorded,
};
pub use contender::Contender;
pub use data::{
    Columns, Data, DataError, InputTable, Place, Row, RowNumbering, RowOrder, RowSource, Rows, Table,
};
pub use engine::Running;
pub use error::MotesError;
pub use estimate::{Coordinate, Estimate, Forecast};
pub use evidence::{
    Evidence, EvidenceEstimator, EvidenceOptions, EvidenceWorth, LearnedWorth, LogEvidence, MissedMass,
    Pilot, evidence, log_evidence, log_evidence_at,
};
pub use filter_source::FilterSource;
pub use filtered::{Filtered, WeightedParticles};
pub use filtering::{filter, of_proposal};
pub use fit_comparison::{FitComparison, FittedModel, FittedScore, compare_fits};
pub use fit_folder::FitFolder;
pub use fitting::{
    FitOptions, FitParameters, FitProgress, FitRecord, FreeParameters, MaximumFit, MaximumParameter,
    MaximumProfilePoint, PosteriorChain, PosteriorFit, SearchProgress, fit, fit_from, maximise,
};
pub use learned::LearnedProposal;
pub use learned_notes::{Notes, PotentialNotes};
pub use learning::{
    LearnOptions, LearnOutcome, base_named, head_named, learn, learns_over_prior, network_named,
};
pub use mixture::{PosteriorEstimates, filter_draws, smooth_draws};
pub use model::Model;
pub use names::{FileInput, ModelNames};
pub use options::{DEFENSIVE_SHARE, FilterOptions, ProposalName};
pub use own_model::LearnableModel;
pub use packed::{pack, unpack};
pub use priors::{at_prior_draw, of_starts};
pub use quantiles::Quantiles;
pub use rows_ahead::{check_forecasts, rows_ahead};
pub use simulating::{
    Simulated, SimulatedRow, simulate, simulate_along, simulate_from_draws, simulate_from_priors,
};
pub use smoothing::{Smoothed, smooth};
pub use tally::{SeriesTally, Tally, TimeLabel};
pub use threads::{on_threads, thread_pool};
pub use timeline::{BeyondFile, Clock, RowTime, TimelineError};
pub use training_prior::{PriorParameter, TrainingPrior};
pub use warning::Warning;

pub use motes_formulas as formulas;
pub use motes_inference as inference;
pub use motes_models as models;
pub use motes_proposals as proposals;
pub use motes_smc as smc;
pub use motes_train as train;

/// The READMEs' code, compiled and run as documentation tests.
#[doc = include_str!("../README.md")]
#[doc = include_str!("../../../docs/guide.md")]
#[cfg(doctest)]
pub struct Readme;

/// What a program that filters with a model of its own needs.
pub mod prelude {
    pub use motes_models::equations::{
        Coordinates, Distribution, Draws, Equations, Scalar, distributions::*,
    };
    pub use motes_models::{Measurements, PartialMeasurements, Seed, StateSpaceModel, Step, simulate};
    pub use motes_smc::{
        Bootstrap, FilterBank, FilterSettings, Linearised, MinDegeneracy, ParticleFilter, ResampleWhen,
        Resampling,
    };
}
