//! Zenoh: how a process reaches the others.

pub mod config;
pub mod hearing;
pub mod pace;
pub mod rarely;
pub mod refusals;
pub mod session;
pub mod waiting;
