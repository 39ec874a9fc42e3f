//! What one aircraft of the Bayesian search knows and does (Tisdale et al. 2008).
pub mod belief;
pub mod config;
pub mod factor;
pub mod filter;
pub mod likelihood;
pub mod mutant;
pub mod search_map;
pub mod survival;
pub mod tiles;
