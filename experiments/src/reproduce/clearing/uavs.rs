//! What each UAV did over time, from `metrics.csv`.

use csat_mission::measures::index_of;
use csat_mission::mission::Mission;
use csat_mission::row::Role;

use crate::clearing::Clearing;
use crate::metrics_file;
use crate::reproduce::flown::{Flown, unreadable};
use crate::sweep::SweepError;

/// Every so many steps are kept.
const KEPT_STEPS: u32 = 8;

/// `duty` of a cleaner.
const CLEANER: f64 = 0.0;
/// `duty` of a helper.
const HELPER: f64 = 3.0;

/// What a UAV did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Uav {
    /// Whether it was a cleaner at any step.
    pub was_cleaner: bool,
    /// Some of its steps, in order.
    pub instants: Vec<Instant>,
}

/// A UAV at a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// k.
    pub step: u32,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// What it does.
    pub duty: Duty,
    /// What it was the first to clear so far, % of R_S.
    pub cleared_pct: f64,
    /// How far it has flown, metres.
    pub path_m: f64,
}

/// What a UAV does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Duty {
    /// It clears.
    Cleaner,
    /// It follows a cleaner.
    Follower,
    /// It looks for a cleaner.
    Helper,
}

impl Uav {
    /// What it was the first to clear, % of R_S.
    pub fn share_pct(&self) -> f64 {
        self.instants.last().map_or(0.0, |instant| instant.cleared_pct)
    }

    /// How far it had flown at a time, metres.
    pub fn path_m_at(&self, time_s: f64) -> f64 {
        let until = self.instants.iter().take_while(|instant| instant.time_s <= time_s);
        until.last().map_or(0.0, |instant| instant.path_m)
    }
}

/// The UAVs of a mission, by index.
///
/// # Errors
/// When its `metrics.csv` is missing or not what it should be.
pub fn read(run: &Flown) -> Result<Vec<Uav>, SweepError> {
    let columns = Clearing::KIND.columns;
    let path = run.folder.join("metrics.csv");
    let rows = metrics_file::rows(&path, columns);
    let rows = rows.map_err(|e| unreadable(path, "the metrics of a run", &e))?;
    let last = rows.last().map_or(0, |row| row.step);
    let mut uavs = vec![Uav::default(); usize::from(run.summary.agents)];
    for row in rows.iter().filter(|row| row.role == Role::Uav) {
        let value = |key: &str| index_of(columns, key).and_then(|index| row.values[index]);
        let Some(uav) = uavs.get_mut(usize::from(row.agent)) else { continue };
        let duty = match value("duty") {
            Some(CLEANER) => Duty::Cleaner,
            Some(HELPER) => Duty::Helper,
            _ => Duty::Follower,
        };
        uav.was_cleaner |= duty == Duty::Cleaner;
        if row.step.is_multiple_of(KEPT_STEPS) || row.step == last {
            uav.instants.push(Instant {
                step: row.step,
                time_s: row.time_s,
                duty,
                cleared_pct: value("cleared_by_uav_pct").unwrap_or_default(),
                path_m: value("path_m").unwrap_or_default(),
            });
        }
    }
    Ok(uavs)
}
