//! Help for the tests of this crate and of `csat-experiments`.

#![allow(dead_code, reason = "each crate uses its part")]

use std::collections::BTreeMap;
use std::ops::Deref;
use std::path::Path;

use csat_mission::fleet::Frames;
use csat_mission::mission::Mission;
use csat_world::truth::CheckCounts;
use tempfile::TempDir;

use crate::scenario::{self, Loaded, Request};
use crate::set_membership::SetMembership;
use crate::summary::{Messages, Summary};
use crate::timing::TimingSummary;
use crate::values::Numbers;

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

/// A summary with something in every field.
pub fn summary() -> Summary {
    let (mut numbers, mut last) = (Numbers::default(), Numbers::default());
    let identified = SetMembership::KIND.column("identified_union").expect("a column");
    numbers.push_of(identified, "identified", Some(8.0));
    numbers.push("all_identified_s", Some(93.5));
    let values = [
        ("unexplored_pct", Some(21.5), Some(20.0)),
        ("hidden_pct", Some(3.25), Some(3.0)),
        ("explored_pct", Some(0.0), Some(0.0)),
        ("footprint_pct", Some(0.0), Some(0.0)),
        ("ground_seen_pct", Some(0.0), Some(0.0)),
        ("localization_error_m", None, None),
        ("target_radius_m", None, None),
        ("oem_iou_pct", Some(74.0), None),
    ];
    for (key, half, end) in values {
        numbers.push(key, half);
        last.push(key, end);
    }
    Summary {
        mission: "set-membership".into(),
        scenario: "city".into(),
        seed: 7,
        agents: 4,
        targets: 8,
        thesis_setting: true,
        steps: 600,
        interrupted: false,
        violations: 0,
        checks: 49_000,
        unchecked: 0,
        checked: CheckCounts::default(),
        inconsistencies: 0,
        liars: Vec::new(),
        numbers,
        last,
        stations: Vec::new(),
        frames: vec![Frames { shown: 601, ..Frames::default() }; 4],
        refused: BTreeMap::new(),
        messages: Messages {
            sent: 12,
            delivered: 9,
            dropped: BTreeMap::from([("range".to_owned(), 3)]),
            duplicated: 0,
            ..Messages::default()
        },
        bytes_sent: 1_234_567,
        timing_ms: TimingSummary::default(),
        wall_s: 12.5,
        sim_s: 300.0,
        realtime_factor: 24.0,
        digest: "00000000deadbeef".into(),
    }
}
