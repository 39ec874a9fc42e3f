//! Scripted cars: they follow tracks, which are places at times, with straight lines at constant
//! speed in between. Before its first place and after its last one a car stands still.
//!
//! The guarantee assumes that cars keep to the model: the speed (5.34), the separations (3.8) and
//! (3.11), the region. [`Tracks::faults`] checks the tracks as continuous motions, exactly, so that
//! no mission starts whose cars break the assumptions of the agents.

use std::fmt;

use csat_proto::ids::TargetId;
use csat_proto::model::{Ground, TargetsModel};
use csat_proto::region::is_inside;

use crate::obstacle::{Obstacle, Walls};
use crate::plane::{
    Bounds, Point, between, distance_m, distance_to_segment_m, minus, segment_distance_m,
};
use crate::target::{MAX_TURN_RATE_RAD_S, TargetTruth, turned};

/// Added to the distances that the model requires, so that rounding cannot break them, metres.
const MARGIN_M: f64 = 1e-6;
/// Allowance for rounding in speeds, relative.
const SPEED_TOLERANCE: f64 = 1e-9;

/// A place of a car at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// Its line in the file, from 1.
    pub line: usize,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// `world`, metres.
    pub location: [f64; 2],
}

/// A waypoint and its car.
pub type Row = (TargetId, Waypoint);

/// The tracks of all cars, by index; each has a waypoint or more, by increasing time.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracks(Vec<Vec<Waypoint>>);

/// A row of the tracks that is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackError {
    /// Its line in the file, from 1.
    pub line: usize,
    /// What is wrong.
    pub fault: TrackFault,
}

/// What is wrong with a row; lengths in metres, times in seconds.
#[derive(Debug, Clone, PartialEq)]
pub enum TrackFault {
    /// A time or a place that is not a number, or a time before the start.
    Value {
        /// The name of the column.
        column: &'static str,
        /// Its value.
        got: f64,
    },
    /// A time that is not after the one before.
    Order {
        /// Whose.
        target: TargetId,
        /// The time.
        time_s: f64,
        /// The one before.
        before_s: f64,
    },
    /// Targets are numbered from 0 on without gaps.
    Gap {
        /// The highest number.
        highest: TargetId,
        /// The lowest that has no row.
        missing: TargetId,
    },
    /// Faster than v_max from the waypoint before.
    Speed {
        /// Whose.
        target: TargetId,
        /// How fast, m/s.
        speed_m_s: f64,
        /// v_max, m/s.
        limit_m_s: f64,
    },
    /// The cylinder of the car leaves the region.
    Outside {
        /// Whose.
        target: TargetId,
        /// Where.
        location: [f64; 2],
        /// Half of the room that locations have, east and north.
        limit_m: [f64; 2],
    },
    /// A way to this waypoint that is too near to a building (3.8).
    Obstacle {
        /// Whose.
        target: TargetId,
        /// The name of the building.
        name: String,
        /// The distance; 0 inside it.
        distance_m: f64,
        /// What that has to exceed.
        limit_m: f64,
    },
    /// A way to this waypoint on which two cars are too near to each other (3.11).
    Separation {
        /// The car of the row.
        target: TargetId,
        /// The other car.
        other: TargetId,
        /// When they are nearest.
        time_s: f64,
        /// Their least distance.
        distance_m: f64,
        /// What that has to exceed.
        limit_m: f64,
    },
}

impl fmt::Display for TrackFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value { column, got } => write!(f, "`{column}` cannot be {got}"),
            Self::Order { target, time_s, before_s } => {
                write!(f, "car {target} is here at {time_s} s, after a row at {before_s} s")
            }
            Self::Gap { highest, missing } => {
                write!(f, "there is a car {highest}, and none with the number {missing}")
            }
            Self::Speed { target, speed_m_s, .. } => {
                write!(f, "car {target} drives at {speed_m_s:.3} m/s to get here in time")
            }
            Self::Outside { target, location: [x, y], .. } => {
                write!(f, "car {target} leaves the region at ({x}, {y})")
            }
            Self::Obstacle { target, name, distance_m, .. } => {
                let name = name.strip_prefix("building ").unwrap_or(name);
                write!(f, "car {target} comes within {distance_m:.3} m of the building {name}")
            }
            Self::Separation { target, other, time_s, distance_m, .. } => write!(
                f,
                "car {target} comes within {distance_m:.3} m of car {other} at {time_s:.3} s"
            ),
        }
    }
}

impl TrackFault {
    /// What would be right.
    pub fn expected(&self) -> String {
        match self {
            Self::Value { column: "time_s", .. } => {
                "seconds from the start on, 0 or more".to_owned()
            }
            Self::Value { .. } => "metres from the middle of the region".to_owned(),
            Self::Order { .. } => "the rows of a car by increasing time".to_owned(),
            Self::Gap { .. } => "numbers from 0 on without gaps".to_owned(),
            Self::Speed { limit_m_s, .. } => {
                format!("at most targets.v_max_m_s = {limit_m_s} m/s")
            }
            Self::Outside { limit_m: [x, y], .. } => format!(
                "all of a car inside: its middle within ±{x} m east and ±{y} m north \
                 (map.size_m / 2 - targets.radius_m)"
            ),
            Self::Obstacle { limit_m, .. } => {
                format!(
                    "farther than {limit_m} m (targets.obstacle_distance_m, half a body's diagonal)"
                )
            }
            Self::Separation { limit_m, .. } => {
                format!("farther than {limit_m} m (targets.target_distance_m, a body's diagonal)")
            }
        }
    }
}

impl fmt::Display for TrackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}, expected {}", self.line, self.fault, self.fault.expected())
    }
}

impl std::error::Error for TrackError {}

impl Tracks {
    /// Sorts rows by car.
    ///
    /// # Errors
    /// Every row with a value that is not a number, out of order, or beyond a gap in the indexes.
    pub fn new(rows: &[Row]) -> Result<Self, Vec<TrackError>> {
        let mut errors = Vec::new();
        let mut refuse = |line, fault| errors.push(TrackError { line, fault });
        let mut tracks: Vec<Vec<Waypoint>> = Vec::new();
        for &(target, waypoint) in rows {
            let Waypoint { line, time_s, location: [x, y] } = waypoint;
            for (column, got) in [("x_m", x), ("y_m", y)].into_iter().filter(|c| !c.1.is_finite()) {
                refuse(line, TrackFault::Value { column, got });
            }
            if !(time_s >= 0.0 && time_s.is_finite()) {
                refuse(line, TrackFault::Value { column: "time_s", got: time_s });
                continue;
            }
            let index = usize::from(target.0);
            if tracks.len() <= index {
                tracks.resize(index + 1, Vec::new());
            }
            match tracks[index].last() {
                Some(last) if last.time_s >= time_s => {
                    refuse(line, TrackFault::Order { target, time_s, before_s: last.time_s });
                }
                _ => tracks[index].push(waypoint),
            }
        }
        let missing = tracks.iter().position(Vec::is_empty);
        if let (Some(missing), Some(last)) = (missing, tracks.last().and_then(|t| t.first())) {
            let [highest, missing] = [tracks.len() - 1, missing].map(|i| TargetId(i as u16));
            refuse(last.line, TrackFault::Gap { highest, missing });
        }
        if errors.is_empty() { Ok(Self(tracks)) } else { Err(errors) }
    }

    /// The number of cars.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Every row on whose way the cars do not keep to the model, by line.
    pub fn faults(
        &self,
        model: &TargetsModel,
        ground: &Ground,
        obstacles: &[Obstacle],
    ) -> Vec<TrackError> {
        let mut faults = Vec::new();
        let walls = Walls::new(obstacles);
        let diagonal_m = model.body_m[0].hypot(model.body_m[1]);
        let limit_m = model.obstacle_distance_m.max(diagonal_m / 2.0);
        for (target, track) in self.by_target() {
            for (way, &Waypoint { line, location, .. }) in ways(track).zip(track) {
                let mut refuse = |fault| faults.push(TrackError { line, fault });
                if let Some(fault) = too_fast(target, &way, model.v_max_m_s) {
                    refuse(fault);
                }
                let half = ground.size_m.map(|size| size / 2.0 - model.radius_m);
                if (0..2).any(|axis| location[axis].abs() > half[axis]) {
                    refuse(TrackFault::Outside { target, location, limit_m: half });
                }
                if let Some((index, distance_m)) =
                    nearest([way[0].location, way[1].location], &walls, limit_m + MARGIN_M)
                {
                    let name = obstacles[index].name.clone();
                    refuse(TrackFault::Obstacle { target, name, distance_m, limit_m });
                }
            }
        }
        let limit_m = model.target_distance_m.max(diagonal_m);
        for (target, track) in self.by_target() {
            for (other, beside) in self.by_target().take(usize::from(target.0)) {
                too_near((target, track), (other, beside), limit_m, &mut faults);
            }
        }
        faults.sort_by_key(|error| error.line);
        faults
    }

    fn by_target(&self) -> impl Iterator<Item = (TargetId, &[Waypoint])> {
        self.0.iter().enumerate().map(|(index, track)| (TargetId(index as u16), track.as_slice()))
    }
}

/// The way to each waypoint: from the one before, and to the first one from itself.
fn ways(track: &[Waypoint]) -> impl Iterator<Item = [Waypoint; 2]> {
    let first = track.first().map(|first| [*first; 2]);
    first.into_iter().chain(track.windows(2).map(|pair| [pair[0], pair[1]]))
}

fn too_fast(target: TargetId, [from, to]: &[Waypoint; 2], limit_m_s: f64) -> Option<TrackFault> {
    let taken_s = to.time_s - from.time_s;
    let moved_m = distance_m(from.location, to.location);
    (moved_m > limit_m_s * taken_s * (1.0 + SPEED_TOLERANCE)).then(|| TrackFault::Speed {
        target,
        speed_m_s: moved_m / taken_s,
        limit_m_s,
    })
}

/// The obstacle nearest to a way among those within `reach_m`, and its distance.
fn nearest(way: [Point; 2], walls: &Walls, reach_m: f64) -> Option<(usize, f64)> {
    let near = walls.near_segment(way, reach_m).map(|(index, edges)| {
        let to_edge = edges.iter().map(|edge| segment_distance_m(way, *edge));
        let inside = is_inside(edges, way[0]);
        (index, if inside { 0.0 } else { to_edge.fold(f64::INFINITY, f64::min) })
    });
    near.filter(|(_, distance)| *distance <= reach_m).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The rows of either car on whose ways the two cars are no farther apart than `limit_m`.
///
/// Between two consecutive times of the rows of both, both cars have constant velocities. So their
/// difference runs along a segment, whose distance from the origin is their least distance.
fn too_near(
    (target, track): (TargetId, &[Waypoint]),
    (other, beside): (TargetId, &[Waypoint]),
    limit_m: f64,
    faults: &mut Vec<TrackError>,
) {
    let reach_m = limit_m + MARGIN_M;
    let bounds = |track: &[Waypoint]| Bounds::around(track.iter().map(|w| w.location));
    if let (Some(a), Some(b)) = (bounds(track), bounds(beside))
        && !a.grown(reach_m).meets(&b)
    {
        return;
    }
    let mut times: Vec<f64> = track.iter().chain(beside).map(|w| w.time_s).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let mut last_line = None;
    for span in std::iter::once([times[0]; 2]).chain(times.windows(2).map(|t| [t[0], t[1]])) {
        let apart = span.map(|t| minus(place(track, t).0, place(beside, t).0));
        let distance_m = distance_to_segment_m([0.0; 2], apart[0], apart[1]);
        if distance_m > reach_m {
            continue;
        }
        // The row at the end of this way: of the car that still moves, or the later one of both.
        let [own, its] = [track, beside].map(|track| next(track, span[1]).line);
        let (line, target, other) =
            if own >= its { (own, target, other) } else { (its, other, target) };
        if last_line.replace(line) != Some(line) {
            let time_s = nearest_time_s(span, apart);
            let fault = TrackFault::Separation { target, other, time_s, distance_m, limit_m };
            faults.push(TrackError { line, fault });
        }
    }
}

/// When a point that moves from `apart[0]` to `apart[1]` at constant velocity is nearest to the origin.
fn nearest_time_s(span: [f64; 2], apart: [Point; 2]) -> f64 {
    let d = minus(apart[1], apart[0]);
    let length2 = d[0] * d[0] + d[1] * d[1];
    let along = -(apart[0][0] * d[0] + apart[0][1] * d[1]);
    let t = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
    span[0] + t * (span[1] - span[0])
}

/// The first waypoint not before a time, or the last one.
fn next(track: &[Waypoint], time_s: f64) -> &Waypoint {
    let index = track.partition_point(|waypoint| waypoint.time_s < time_s);
    &track[index.min(track.len() - 1)]
}

/// Where a car is at a time, and the way that it is on unless it stands still.
fn place(track: &[Waypoint], time_s: f64) -> (Point, Option<[&Waypoint; 2]>) {
    let index = track.partition_point(|waypoint| waypoint.time_s <= time_s);
    match (index.checked_sub(1).map(|i| &track[i]), track.get(index)) {
        (Some(from), Some(to)) => {
            let t = (time_s - from.time_s) / (to.time_s - from.time_s);
            let moves = from.location != to.location;
            (between(from.location, to.location, t), moves.then_some([from, to]))
        }
        (Some(end), None) | (None, Some(end)) => (end.location, None),
        (None, None) => ([0.0; 2], None),
    }
}

/// The heading and the speed of a way.
fn motion([from, to]: [&Waypoint; 2]) -> (f64, f64) {
    let d = minus(to.location, from.location);
    (d[1].atan2(d[0]), d[0].hypot(d[1]) / (to.time_s - from.time_s))
}

/// Cars on their tracks.
#[derive(Debug, Clone)]
pub(crate) struct Scripted {
    tracks: Tracks,
    truths: Vec<TargetTruth>,
}

impl Scripted {
    /// The cars at time 0, each with the heading of its first motion.
    pub(crate) fn new(tracks: Tracks) -> Self {
        let truths = tracks.by_target().map(|(id, track)| {
            let (location, way) = place(track, 0.0);
            let moves = |pair: &[Waypoint]| pair[0].location != pair[1].location;
            let first = track.windows(2).find(|pair| moves(pair)).map(|pair| [&pair[0], &pair[1]]);
            TargetTruth {
                id,
                location,
                heading_rad: first.map_or(0.0, |way| motion(way).0),
                speed_m_s: way.map_or(0.0, |way| motion(way).1),
            }
        });
        let truths = truths.collect();
        Self { tracks, truths }
    }

    /// Lets time pass until `time_s`, which is `period_s` after the last time. The turn rate of
    /// bodies is bounded as for other cars.
    pub(crate) fn advance_to(&mut self, time_s: f64, period_s: f64) {
        for (truth, track) in self.truths.iter_mut().zip(&self.tracks.0) {
            let (location, way) = place(track, time_s);
            let (wanted_rad, speed_m_s) = way.map_or((truth.heading_rad, 0.0), motion);
            let most_rad = MAX_TURN_RATE_RAD_S * period_s;
            truth.heading_rad = turned(truth.heading_rad, wanted_rad, most_rad);
            (truth.location, truth.speed_m_s) = (location, speed_m_s);
        }
    }

    /// What is true of every car, by index.
    pub(crate) fn truths(&self) -> &[TargetTruth] {
        &self.truths
    }
}

#[cfg(test)]
mod tests;
