//! What gets through: the fate of every message between agents (`spec/links.md`).
//!
//! | module | what it does |
//! |---|---|
//! | [`config`] | the scenario's `[netem]` |
//! | [`fate`] | a message's identity, and the random numbers that belong to it |
//! | [`rule`] | one rule, one verdict; the chain of rules of a channel |
//! | [`link`] | messages in flight, delivered in order, and counted |
//!
//! A fate is a *function* of the seed, the message's identity and the positions of its ends, never a
//! draw from a shared stream: one message more or less elsewhere changes no other fate, and one
//! process and many decide the same.
//!
//! The rules built so far are range, independent loss and constant delay.

pub mod config;
pub mod fate;
pub mod link;
pub mod rule;
