//! `csat reproduce`: the published tables and figures, ours beside theirs.
//!
//! Thesis chapter 5 and the paper's table I are [sweeps](crate::sweep) with a fixed plan and a report
//! of their own, and so is Gagliardi et al. Thesis chapters 4 and 6 are no missions: one camera, one frame, many depth
//! noises.
//! Tisdale et al. is one flight for many filters.
//!
//! | module | what it does |
//! |---|---|
//! | [`plan`] | what is flown |
//! | [`flown`] | what was flown: summaries and curves |
//! | [`quantity`] | what is compared |
//! | [`setting`] | whether it is what was published |
//! | [`table`] | ours beside theirs |
//! | [`map`] | pictures of the ground |
//! | [`chapter5`], [`table1`], [`chapter4`], [`chapter6`], [`tisdale`], [`clearing`] | the tables and figures of each |
//! | [`page`] | `report.html` |

pub mod chapter4;
pub mod chapter5;
pub mod chapter6;
pub mod clearing;
pub mod flown;
pub mod map;
pub mod page;
pub mod plan;
pub mod quantity;
pub mod setting;
pub mod table;
pub mod table1;
pub mod tisdale;
