//! Unsupervised training of particle-filter proposals from measurements alone.
