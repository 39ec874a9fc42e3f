//! What one aircraft of the Bayesian search knows and does: a sans-I/O agent after Tisdale, Ryan, Kim, Törnqvist
//! and Hedrick, *A multiple UAV system for vision-based search and localization*, ACC 2008 (equations (n)).
//!
//! Each frame becomes a [`factor`]: from which reported pose, and what was detected. Agents share factors, not
//! beliefs. The belief is a function of the *set* of factors that an agent holds.
//!
//! | module | what it holds |
//! |---|---|
//! | [`agent`] | the state machine: frames and messages in, messages and commands out |
//! | [`config`] | the configuration of an agent |
//! | [`factor`] | what one frame says, as it is kept and sent |
//! | [`likelihood`] | (3)-(7): the likelihood of a factor |
//! | [`belief`] | p(x \| z) on a grid, in particles, and in cells that split |
//! | [`filter`] | from factors to a belief; late factors |
//! | [`survival`] | (8): the cumulative probability of detection |
//! | [`exchange`] | messages to the other agents, and which of their messages are believed |
//! | [`guidance`] | where to fly next |
//! | [`search_map`], [`tiles`] | a belief for guidance and in messages |
//! | [`worth`] | how much a factor tells |
//! | [`mutant`] | known mistakes, to test the tests |

pub mod agent;
pub mod belief;
pub mod config;
pub mod exchange;
pub mod factor;
pub mod filter;
pub mod guidance;
pub mod likelihood;
pub mod mutant;
pub mod search_map;
pub mod survival;
pub mod tiles;
pub mod worth;
