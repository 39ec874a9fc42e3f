//! One mission, from its scenario to its run folder.
//!
//! | module | what it does |
//! |---|---|
//! | [`scenario`] | reads scenarios and reports every mistake at once |
//! | [`missions`] | the list of missions that a program flies |
//! | [`set_membership`], [`bayes`], [`clearing`] | the missions that ship with csat |
//! | [`flight`] | flies, measures and records a mission |
//! | [`world`], [`truth`] | the process of the world in a fleet of processes, and what it publishes |
//! | [`record`], [`run_folder`] | writes a run down while it flies; a folder that is whole or not there |
//! | [`metrics_file`], [`passages`], [`outputs`] | `metrics.csv`, `links.csv`, and what all columns and fields mean |
//! | [`series`], [`station`], [`summary`], [`values`] | metrics over time and a mission in numbers |
//! | [`view`], [`rounding`], [`plot`], [`ticks`] | the end of a mission, `map.svg` and `metrics.svg` |
//! | [`show`] | documents, recordings and replays |
//! | [`published`] | the published numbers |
//! | [`provenance`] | where a run comes from |
//! | [`progress`], [`timing`] | the progress bar, and what the stages took |

#![warn(clippy::print_stdout, clippy::print_stderr)] // They panic: see `csat_peer::terminal`.

pub mod bayes;
pub mod clearing;
pub mod flight;
pub mod metrics_file;
pub mod missions;
pub mod outputs;
pub mod passages;
pub mod plot;
pub mod progress;
pub mod provenance;
pub mod published;
pub mod record;
pub mod rounding;
pub mod run_folder;
pub mod scenario;
pub mod series;
pub mod set_membership;
pub mod show;
pub mod station;
pub mod summary;
pub mod ticks;
pub mod timing;
pub mod truth;
pub mod values;
pub mod view;
pub mod world;

#[cfg(test)]
mod documents_tests;
#[cfg(test)]
mod engine_tests;
#[cfg(test)]
mod testing;
