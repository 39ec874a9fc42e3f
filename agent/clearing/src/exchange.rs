//! Messages to the other agents, and which of their messages are believed.

pub mod message;
pub mod outbox;
pub mod validate;
