//! Zenoh: how a process reaches the others.

pub mod rarely;
pub mod session;
