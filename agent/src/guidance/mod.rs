//! Where to fly next.
