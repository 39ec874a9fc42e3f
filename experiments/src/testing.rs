//! Help for this crate's tests.

use std::ops::Deref;
use std::path::Path;

use tempfile::TempDir;

use crate::scenario::{self, Loaded, Request};

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

/// A mission that takes a fraction of a second, of `duration_s` simulated seconds.
pub fn small_mission(duration_s: f64) -> Loaded {
    let sets = [
        &format!("run.duration_s={duration_s}"),
        "map.size_m=[150, 150]",
        "camera.columns=96",
        "camera.rows=72",
        "camera.min_pixels=1",
        "targets.count=2",
        "agents.count=2",
        "netem.radio.loss={model=\"iid\",p=0.3}",
    ]
    .map(str::to_owned);
    scenario::load(Request { sets: &sets, ..Request::default() }).expect("a good scenario")
}
