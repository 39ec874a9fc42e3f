//! Predict, correct and fuse: what is true stays in, in whatever order and however late it is told.

mod estimator {
    pub mod aging;
    pub mod merge;
    pub mod predict;
}
