//! Models whose states are made of draws by a map: counts, draws that coordinates share, coordinates without noise, sub-steps. Their evidence by each proposal, against
//! exact values.

mod designed;
mod learned;
mod models;
mod planted;
mod score;
