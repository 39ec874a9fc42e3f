//! Messages to the other agents, and which of their messages are believed.
//!
//! | module | what it does |
//! |---|---|
//! | [`protocol`] | [`Exchange`](protocol::Exchange): what an agent states, says and hears |
//! | [`message`] | what is said |
//! | [`factor_set`] | the factors that an agent holds |
//! | [`held`] | what messages tell of them: a version vector with gaps |
//! | [`intervals`] | sets of numbers |
//! | [`validate`] | the checks of a message before it is believed |
//! | `repair` | anti-entropy: which factors others are missing, and who sends them again |
//! | `ratings` | which of many factors are worth most |
//! | `budget` | how many bytes may be sent |
//! | `answer` | what an agent tells one that joins late |
//! | `outbox` | numbers messages and queues them |

mod answer;
mod budget;
pub mod factor_set;
#[cfg(test)]
mod fixture;
pub mod held;
pub mod intervals;
pub mod message;
mod outbox;
pub mod protocol;
mod ratings;
mod repair;
pub mod validate;
