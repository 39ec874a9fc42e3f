//! What one UAV knows: predict, correct with the own frame, fuse what others sent.

pub mod oem;
