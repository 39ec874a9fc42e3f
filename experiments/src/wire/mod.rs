//! Zenoh: how a process reaches the others.

pub mod session;
