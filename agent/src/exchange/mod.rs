//! Messages to the other agents, and which of their messages are believed (docs/links.md, "What agents
//! say").
//!
//! | module | what it does |
//! |---|---|
//! | [`transmitter`] | what to send, and how often |
//! | `budget` | simplifies messages until they fit a budget of bytes |
//! | [`repair`] | anti-entropy: which agent is missing facts, and which agent resends them |
//! | [`version_vector`] | which facts the agent's own knowledge contains |
//! | [`receiver`] | which messages are believed, and facts that wait to be applied |
//! | [`validate`] | the checks of a message before it is believed |
//! | `worth` | what a fact is worth, and which one pays |
//! | `crossing` | the check whether received rings cross |

mod budget;
mod crossing;
pub mod receiver;
pub mod repair;
pub mod transmitter;
pub mod validate;
pub mod version_vector;
mod worth;
