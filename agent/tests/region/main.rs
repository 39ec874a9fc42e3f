//! The guarantees of `csat_agent::region`, against independent formulations, on random sets.
//!
//! Every test runs seeded cases; a failing case prints the command that replays it alone.

mod boolean;
mod cells;
mod dilate;
mod disc;
mod erode;
mod grown;
mod growth;
mod limit;
mod limits;
mod oracle;
mod reach;
mod relaxed;
mod shapes;
mod simplify;
