//! A bootstrap filter's view of another filter: it sees a missing mode, and nothing in filters that are sound.

mod errors;
mod models;
mod planted;
mod sound;
mod without;
