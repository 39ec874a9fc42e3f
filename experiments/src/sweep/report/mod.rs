//! `report.html`: a page that needs nothing but itself.

mod figures;
mod page;
mod pairs;
mod seeds;
#[cfg(test)]
mod tests;

pub use page::{alarms, head, html, scenario};
