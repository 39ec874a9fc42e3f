//! What gets through: the fate of every message between agents (docs/links.md).
//!
//! A message meets the rules of its channel in a fixed order. The first rule that loses it names
//! the reason; what is left arrives, perhaps damaged, perhaps twice, at a time of its own.
//!
//! | rule | module | loses or changes a message |
//! |---|---|---|
//! | 1 | [`outage`] | when its sender is out as it is sent, or its receiver as it arrives |
//! | 2 | [`partition`] | between groups that are apart when it is sent |
//! | 3 | [`range`] | beyond the range |
//! | 4 | [`propagation`] | when path loss, shadowing and buildings leave too little of it |
//! | 5 | [`jam`] | when its receiver is jammed |
//! | 6 | [`loss`] | at random: i.i.d., Gilbert-Elliott, four states, a recording ([`trace`]) |
//! | 7 | [`repeat`] | damages one byte |
//! | 8 | [`repeat`] | makes a copy |
//! | 9 | [`rate`] | holds it in its sender's queue, or loses it when that is full |
//! | 10 | [`delay`] | delays it |
//!
//! | module | what it does |
//! |---|---|
//! | [`config`] | the scenario's `[netem]`, and what is impossible in it |
//! | [`fate`] | a message's identity, and what becomes of it |
//! | [`draw`] | the random numbers that belong to a message |
//! | [`chain`] | states that follow each other along the messages of a link |
//! | [`rule`] | one rule, one verdict; the rules of a channel in order |
//! | [`link`] | messages in flight, delivered in order |
//! | [`counters`] | what happened, counted |
//!
//! A fate is a *function* of the seed, the message's identity, the time and the positions of its
//! ends, never a draw from a shared stream: one message more or less elsewhere changes no other
//! fate, and one process and many decide the same. What happened before matters in two places, and
//! then it is the past of the same link or sender: chains of losses and delays, which advance by
//! sequence number, and queues.
//!
//! A message in flight survives the failure of its sender and partitions that begin later.

pub mod chain;
pub mod config;
pub mod counters;
pub mod delay;
pub mod draw;
pub mod fate;
pub mod jam;
pub mod link;
pub mod loss;
pub mod outage;
pub mod partition;
pub mod propagation;
pub mod range;
pub mod rate;
pub mod repeat;
pub mod rule;
pub mod trace;
