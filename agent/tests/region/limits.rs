//! Input that is valid but extreme never panics and degrades to the safe side.
