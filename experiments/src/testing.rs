//! Help for this crate's tests.

use std::ops::Deref;
use std::path::Path;

use tempfile::TempDir;

/// A new empty folder that goes away with its test.
#[derive(Debug)]
pub struct Scratch(TempDir);

impl Deref for Scratch {
    type Target = Path;
    fn deref(&self) -> &Path {
        self.0.path()
    }
}

/// A new empty folder.
pub fn scratch(name: &str) -> Scratch {
    let folder = tempfile::Builder::new().prefix(&format!("csat-{name}-")).tempdir();
    Scratch(folder.expect("a scratch folder"))
}
