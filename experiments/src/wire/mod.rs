//! Zenoh: how a process reaches the others.

pub mod hearing;
pub mod pace;
pub mod rarely;
pub mod session;
