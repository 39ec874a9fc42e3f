//! What a user runs and what they get: the `csat` command around a mission.
//!
//! | module | what it does |
//! |---|---|
//! | [`scenario`] | reads scenarios and reports every mistake at once |
//! | [`cli`] | the command line |
//! | [`set_membership`] | the set-membership mission |
//! | [`node`] | one agent and what surrounds it |
//! | [`mission`] | flies, measures and records a mission |
//! | [`passages`] | what the links did, written down |
//! | [`metrics`] | one agent at one step: thesis (5.36)-(5.45) |
//! | [`series`] | those over time, averaged over agents and over the second half |
//! | [`summary`] | a mission in numbers |
//! | [`station`] | what a ground station knew, in numbers |
//! | [`sweep`] | every combination with every seed, and the report |
//! | [`compare`] | two runs, sweeps or reproductions side by side |
//! | [`reproduce`] | the published tables and figures, ours beside theirs |
//! | [`published`] | the published numbers |
//! | [`report`] | pages with plots that need nothing but themselves |
//! | [`record`] | writes a run down while it flies |
//! | [`show`] | what people get to see: documents, recordings, replays |
//! | [`run_folder`] | a folder that is whole or not there |
//! | [`outputs`] | what the columns and fields of its files mean |
//! | [`provenance`] | where a run comes from |
//! | [`view`] | the end of a mission, to be drawn |
//! | [`rounding`] | sets and outlines to the millimetre, and valid polygons still |
//! | [`plot`] | `map.svg` and `metrics.svg` |
//! | [`progress`], [`logs`] | what shows while it flies |
//! | [`watch`] | a live map in the browser |
//! | [`process`] | a fleet of processes: world, agents, and what spawns them |
//! | [`tools`] | looking at a fleet from a terminal: `csat echo`, `csat doctor` |
//! | [`verdict`] | exit codes |
//! | [`timing`] | what stages took |

#![warn(clippy::print_stdout, clippy::print_stderr)] // They panic: see `terminal`.

pub mod cli;
pub mod compare;
pub mod logs;
pub mod metrics;
pub mod mission;
pub mod outputs;
pub mod passages;
pub mod plot;
pub mod process;
pub mod progress;
pub mod provenance;
pub mod published;
pub mod record;
pub mod report;
pub mod reproduce;
pub mod rounding;
pub mod run_folder;
pub mod scenario;
pub mod series;
pub mod set_membership;
pub mod show;
pub mod station;
pub mod summary;
pub mod sweep;
#[cfg(test)]
mod testing;
pub mod timing;
pub mod tools;
pub mod verdict;
pub mod view;
pub mod watch;

#[cfg(test)]
mod documents_tests;
#[cfg(test)]
mod engine_tests;
