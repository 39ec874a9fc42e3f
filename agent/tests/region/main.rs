//! What `csat_agent::region` promises, against independent formulations, on random sets.
//!
//! Every test runs seeded cases; a failing one prints the command that replays it alone.

mod boolean;
mod dilate;
mod disc;
mod erode;
mod grown;
mod growth;
mod limit;
mod limits;
mod oracle;
mod reach;
mod shapes;
mod simplify;
