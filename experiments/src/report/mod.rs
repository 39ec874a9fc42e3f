//! Pages that need nothing but themselves: plots and tables of sweeps and reproductions.
//!
//! | module | what it does |
//! |---|---|
//! | [`page`] | the page around them |
//! | [`chart`] | a plot of runs at a few places: means with confidence, every run a dot |
//! | [`curves`] | a plot of many moments: a line and its band |
//! | [`sheet`] | what all plots have in common: title, legend, grid |
//! | [`axis`] | where values stand |
//! | [`shapes`] | small pieces of SVG |

pub mod axis;
pub mod chart;
pub mod curves;
pub mod page;
pub mod shapes;
pub mod sheet;
