//! What a user runs and what they get (`spec/experiments.md`): the `csat` command around a mission.
//!
//! | module | what it does |
//! |---|---|
//! | [`scenario`] | reads scenarios and reports every mistake at once |
//! | [`cli`] | the command line |
//! | [`mission`] | flies a mission in one process |
//! | [`metrics`] | one agent at one step: thesis (5.36)-(5.45) |
//! | [`series`] | those over time, averaged over agents and over the second half |
//! | [`summary`] | a mission in numbers |
//! | [`record`] | writes a run down while it flies |
//! | [`run_folder`] | a folder that is whole or not there |
//! | [`provenance`] | where a run comes from |
//! | [`view`] | the end of a mission, to be drawn |
//! | [`plot`] | `map.svg` and `metrics.svg` |
//! | [`progress`], [`logs`] | what shows while it flies |
//! | [`timing`] | the only clock |

pub mod cli;
pub mod logs;
pub mod metrics;
pub mod mission;
pub mod plot;
pub mod progress;
pub mod provenance;
pub mod record;
pub mod run_folder;
pub mod scenario;
pub mod series;
pub mod summary;
#[cfg(test)]
mod testing;
pub mod timing;
pub mod view;
