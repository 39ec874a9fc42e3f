//! Looking at a running fleet from a terminal.
//!
//! | module | what it does |
//! |---|---|
//! | [`echo`] | `csat echo`: what is said on which keys |
//! | [`doctor`] | `csat doctor`: who is there, and why a subscriber hears nothing |
//! | [`keys`] | the key expression that a user means, and the keys that there are |
//! | [`ear`] | a subscriber whose queue is bounded |
//! | [`line`](mod@line) | a sample as a line of text or of JSON |
//! | [`rates`] | how much is said on which keys |
//!
//! Both only listen, with queues that drop rather than make a fleet wait.

pub mod doctor;
pub mod ear;
pub mod echo;
pub mod keys;
pub mod line;
pub mod rates;
