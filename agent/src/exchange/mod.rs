//! What is said to the other agents, and what of theirs is believed (docs/links.md,
//! "What agents say").
//!
//! | module | what it does |
//! |---|---|
//! | [`transmitter`] | what to say, and how often |
//! | [`budget`] | making it fit a budget of bytes |
//! | [`repair`] | who lacks what, and whose turn it is to help |
//! | [`version_vector`] | which facts the own knowledge contains |
//! | [`receiver`] | which messages are believed, and facts that wait to be applied |
//! | [`validate`] | what is checked before anything is believed |
//! | [`crossing`] | whether received rings cross |

pub mod budget;
pub mod crossing;
pub mod receiver;
pub mod repair;
pub mod transmitter;
pub mod validate;
pub mod version_vector;
