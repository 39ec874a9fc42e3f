//! What one aircraft of the Bayesian search knows and does (Tisdale et al. 2008).
pub mod config;
pub mod exchange;
pub mod factor;
pub mod likelihood;
pub mod mutant;
pub mod search_map;
pub mod tiles;
