//! Models of files, from outside.

mod growth;
mod refused;
