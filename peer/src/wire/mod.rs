//! Zenoh: the session of a process, what it publishes and what it receives.
//!
//! | module | what it holds |
//! |---|---|
//! | [`config`] | the configuration of a session: defaults, a file, the user's endpoints |
//! | [`session`] | command-line arguments, roles, opening and closing a session |

pub mod config;
mod error;
pub(crate) mod notice;
pub(crate) mod publish;
pub(crate) mod receive;
pub(crate) mod refusals;
pub mod session;
