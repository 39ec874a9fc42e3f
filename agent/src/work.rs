//! The work on sets, counted instead of timed: the counts are the same on a busy machine.
//!
//! Counts are made with the feature `work-counts`, which only `csat-tests` enables.

/// The work of one thread.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Work {
    /// Edges handed to Boolean operations.
    pub edges: u64,
    /// The sum, over edges, of how far dilations and erosions swept them, metres. The number of
    /// crossings of paths grows with it.
    pub swept_m: f64,
}

impl Work {
    /// The maximum of two, count by count.
    pub fn max(self, other: Self) -> Self {
        Self { edges: self.edges.max(other.edges), swept_m: self.swept_m.max(other.swept_m) }
    }
}

#[cfg(feature = "work-counts")]
thread_local! {
    static DONE: std::cell::Cell<Work> = const { std::cell::Cell::new(Work { edges: 0, swept_m: 0.0 }) };
}

/// The work of this thread since the last call.
#[cfg(feature = "work-counts")]
pub fn take() -> Work {
    DONE.take()
}

/// Notes edges handed to a Boolean operation.
#[cfg(feature = "work-counts")]
pub(crate) fn note_edges(edges: usize) {
    let done = DONE.get();
    DONE.set(Work { edges: done.edges + edges as u64, ..done });
}

/// Notes edges swept so far.
#[cfg(feature = "work-counts")]
pub(crate) fn note_swept(edges: usize, far_m: f64) {
    let done = DONE.get();
    DONE.set(Work { swept_m: done.swept_m + edges as f64 * far_m, ..done });
}

/// Notes edges handed to a Boolean operation.
#[cfg(not(feature = "work-counts"))]
pub(crate) const fn note_edges(_: usize) {}

/// Notes edges swept so far.
#[cfg(not(feature = "work-counts"))]
pub(crate) const fn note_swept(_: usize, _: f64) {}
