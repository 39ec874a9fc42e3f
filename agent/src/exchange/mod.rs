//! What is said to the other agents, and what of theirs is believed (`spec/sets.md` §4,
//! `spec/links.md`, "Receiving" and "What to say, how often").

pub mod inbox;
pub mod outbox;
pub mod validate;
