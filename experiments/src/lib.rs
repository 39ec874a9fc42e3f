//! What a user runs and what they get (`spec/experiments.md`): the `csat` command around a mission.
//!
//! | module | what it does |
//! |---|---|
//! | [`scenario`] | reads scenarios and reports every mistake at once |
//! | [`cli`] | the command line |
//! | [`plug`] | what a mission is |
//! | [`set_membership`] | the set-membership mission |
//! | [`engine`] | one process, virtual time: world, agents and links, step by step |
//! | [`seat`] | one agent and what surrounds it, its lives and deaths |
//! | [`mission`] | flies, measures and records a mission |
//! | [`passages`] | what the links did, written down |
//! | [`metrics`] | one agent at one step: thesis (5.36)-(5.45) |
//! | [`series`] | those over time, averaged over agents and over the second half |
//! | [`summary`] | a mission in numbers |
//! | [`sweep`] | every combination with every seed, and the report |
//! | [`record`] | writes a run down while it flies |
//! | [`run_folder`] | a folder that is whole or not there |
//! | [`provenance`] | where a run comes from |
//! | [`view`] | the end of a mission, to be drawn |
//! | [`plot`] | `map.svg` and `metrics.svg` |
//! | [`progress`], [`logs`] | what shows while it flies |
//! | [`verdict`] | exit codes |
//! | [`timing`], [`stages`] | the only clock |

pub mod cli;
pub mod engine;
pub mod logs;
pub mod metrics;
pub mod mission;
pub mod passages;
pub mod plot;
pub mod plug;
pub mod progress;
pub mod provenance;
pub mod record;
pub mod run_folder;
pub mod scenario;
pub mod seat;
pub mod series;
pub mod set_membership;
pub mod stages;
pub mod summary;
pub mod sweep;
#[cfg(test)]
mod testing;
pub mod timing;
pub mod verdict;
pub mod view;
