//! Predict, correct and fuse: true locations stay in the sets, for any order and delay of messages.

mod estimator {
    pub mod aging;
    pub mod merge;
    pub mod predict;
}
