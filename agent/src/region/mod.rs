//! Planar sets with their guarantee in the type: outer and inner approximations.
//!
//! An [`Outer`] contains the set it approximates, an [`Inner`] is contained in it. Only operations
//! that keep this guarantee exist:
//!
//! | operation | result |
//! |---|---|
//! | `Outer ∩ Outer`, [`Outer::in_all_but`] | `Outer` |
//! | `Outer \ Inner` | `Outer` |
//! | `Inner ∪ Inner` | `Inner` |
//! | `Inner` without anything | `Inner` |
//! | [`Outer::dilated`], [`Outer::simplified`], [`Outer::limited`] | `Outer` |
//! | [`Inner::eroded`], [`Inner::simplified`], [`Inner::limited`] | `Inner` |
//!
//! `Outer \ Outer` does not exist: code that would break the guarantee does not compile.
//!
//! ```compile_fail
//! # use csat_agent::region::Outer;
//! # use csat_proto::region::Region;
//! let a = Outer::containing(Region::EMPTY);
//! let b = Outer::containing(Region::EMPTY);
//! let _ = a.minus([&b]); // expected `&Inner`, found `&Outer`
//! ```
//!
//! # Rounding
//!
//! All coordinates are integers ([`csat_proto::region`]). A Boolean operation rounds intersection
//! points to the grid and may bend an edge by about one unit (3.8 µm). [`NUMERIC_MARGIN_M`] is added
//! to every dilation and erosion, once per step, and taken from every disc that X° and exclusions are
//! made of. It outweighs 26 units: as many operations that all bend the same edge the same way, of one
//! step in an outer set, and in X° of all steps in which something was added right there. In an outer set
//! the lines along which operations are divided bend an edge by no more than 9 units, and a corner of a raw
//! path is rounded by one.

use std::sync::Arc;

use csat_proto::region::Shape;

mod boolean;
mod cells;
mod disc;
mod grown;
mod inner;
mod limit;
mod outer;
mod reach;
mod relaxed;
mod simplify;
mod sweep;
mod vector;

pub use boolean::solver;
pub use disc::Disc;
pub use grown::Grown;
pub use inner::Inner;
pub use outer::Outer;
pub use reach::Reach;

/// Results of operations on sets, by what went in.
pub type Memo = crate::memo::Memo<Arc<[Shape]>>;

pub(crate) use simplify::{Approximation, Tolerance, simplify_ring};

pub(crate) use boolean::{RULE, filled, overlay};
pub(crate) use vector::turn;

/// ε_num: a bound, with a wide margin, on what the polygon operations of a step lose by rounding,
/// metres.
pub const NUMERIC_MARGIN_M: f64 = 1e-4;
