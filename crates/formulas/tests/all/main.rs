//! Models of files, from outside.

mod growth;
