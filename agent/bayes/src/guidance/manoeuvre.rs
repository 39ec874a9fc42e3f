//! Turns that plans are made of, and their prediction.

use csat_proto::camera::Pose;
use csat_proto::fixed_wing::{FixedWing, FixedWingModel, GRAVITY_M_S2};

use super::navigation::Airframe;

/// Banks as shares of the steepest one, the gentlest first; positive to the right.
const BANKS: [f64; TURNS] = [0.0, -0.5, 0.5, -1.0, 1.0];
/// How many turns there are.
pub const TURNS: usize = 5;
/// The longest turn that is tabulated, seconds.
pub const LONGEST_S: usize = 6;

/// A bank that is held, by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Turn(u8);

impl Turn {
    /// Straight flight.
    pub const STRAIGHT: Self = Self(0);

    /// All of them, the gentlest first.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..TURNS as u8).map(Self)
    }

    fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// How turns are flown: headings are all that can be commanded, so that a bank is held by a heading that runs
/// ahead of the aircraft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steering {
    turn: Turn,
    /// In straight flight, the heading that is held, radians.
    held_yaw_rad: f64,
}

impl Steering {
    /// Goes on with a turn from a pose. A straight flight that is already flown is held.
    pub fn go_on(before: Option<Self>, turn: Turn, pose: &Pose, flight: &Flight) -> Self {
        match before {
            Some(before) if before.turn == turn => before,
            _ => Self { turn, held_yaw_rad: pose.yaw_rad + flight.roll_out_rad(pose.roll_rad) },
        }
    }

    /// The heading to command at a pose, radians.
    pub fn yaw(&self, pose: &Pose, flight: &Flight) -> f64 {
        match self.turn {
            Turn::STRAIGHT => self.held_yaw_rad,
            turn => pose.yaw_rad + flight.ahead_rad[turn.index()],
        }
    }
}

/// The aircraft's flight and a table of its turns.
#[derive(Debug, Clone)]
pub struct Flight {
    airframe: Airframe,
    /// How far ahead of the aircraft the commanded heading is, by turn, radians.
    ahead_rad: [f64; TURNS],
    /// Poses after 1, 2, … seconds of a turn from the origin, without wind, by the turn before and the turn.
    table: Vec<[[Pose; LONGEST_S]; TURNS]>,
}

impl Flight {
    /// The flight of an aircraft.
    pub fn new(airframe: Airframe) -> Self {
        let Airframe { model, airspeed_m_s, period_s } = airframe;
        let roll_max = model.roll_max_deg.to_radians();
        let ahead = |share: f64| {
            let rate = -GRAVITY_M_S2 * (share * roll_max).tan() / airspeed_m_s;
            // Until the next command the aircraft catches up: by half a period in the mean.
            let lead = rate * (model.heading_time_constant_s + period_s / 2.0);
            // The steepest bank is limited anyway.
            if share.abs() == 1.0 { lead * 1.5 } else { lead }
        };
        let mut flight = Self { airframe, ahead_rad: BANKS.map(ahead), table: Vec::new() };
        flight.table = Turn::all().map(|before| flight.turns_after(before)).collect();
        flight
    }

    /// The aircraft.
    pub fn airframe(&self) -> &Airframe {
        &self.airframe
    }

    /// How far the aircraft still turns while it levels its wings, radians.
    fn roll_out_rad(&self, roll_rad: f64) -> f64 {
        -GRAVITY_M_S2 * roll_rad.tan() / self.airframe.airspeed_m_s
            * self.airframe.model.roll_time_constant_s
    }

    /// Flies a turn for whole seconds; gives the pose after each.
    pub fn fly(
        &self,
        vehicle: &mut FixedWing,
        steering: &Steering,
        seconds: usize,
        mut each: impl FnMut(Pose),
    ) {
        let commands = self.airframe.per_second();
        for _ in 0..seconds {
            for _ in 0..commands {
                let pose = vehicle.pose();
                vehicle.command(steering.yaw(&pose, self));
                vehicle.advance(1.0 / f64::from(commands));
            }
            each(vehicle.pose());
        }
    }

    fn turns_after(&self, before: Turn) -> [[Pose; LONGEST_S]; TURNS] {
        let calm = FixedWingModel { wind_m_s: [0.0; 2], ..self.airframe.model };
        let mut steady = FixedWing::level(calm, [0.0; 3], 0.0, self.airframe.airspeed_m_s);
        let steering = Steering::go_on(None, before, &steady.pose(), self);
        self.fly(&mut steady, &steering, 4, |_| ());
        let origin = Pose { p_world: [0.0; 3], yaw_rad: 0.0, ..steady.pose() };
        let mut turns = [[Pose::default(); LONGEST_S]; TURNS];
        for (turn, poses) in Turn::all().zip(&mut turns) {
            let mut vehicle = FixedWing::new(calm, origin, self.airframe.airspeed_m_s);
            let steering = Steering::go_on(None, turn, &origin, self);
            let mut poses = poses.iter_mut();
            self.fly(&mut vehicle, &steering, LONGEST_S, |pose| {
                if let Some(place) = poses.next() {
                    *place = pose;
                }
            });
        }
        turns
    }

    /// The poses after each of some seconds of a turn, from a pose in the steady turn `before`.
    pub fn predict(&self, from: &Pose, before: Turn, turn: Turn, seconds: usize) -> Leg {
        let (sin, cos) = from.yaw_rad.sin_cos();
        let [east, north] = self.airframe.model.wind_m_s;
        let [x, y, z] = from.p_world;
        let mut leg = Leg { poses: [Pose::default(); LONGEST_S], seconds: seconds.min(LONGEST_S) };
        let table = &self.table[before.index()][turn.index()];
        for (second, (pose, of)) in leg.poses.iter_mut().zip(table).enumerate() {
            let ([u, v, _], t) = (of.p_world, (second + 1) as f64);
            *pose = Pose {
                p_world: [x + u * cos - v * sin + t * east, y + u * sin + v * cos + t * north, z],
                yaw_rad: from.yaw_rad + of.yaw_rad,
                ..*of
            };
        }
        leg
    }
}

/// Poses after each of some seconds.
#[derive(Debug, Clone, Copy)]
pub struct Leg {
    poses: [Pose; LONGEST_S],
    seconds: usize,
}

impl Leg {
    /// At most [`LONGEST_S`] poses.
    pub fn new(poses: &[Pose]) -> Self {
        let seconds = poses.len().min(LONGEST_S);
        let mut leg = Self { poses: [Pose::default(); LONGEST_S], seconds };
        leg.poses[..seconds].copy_from_slice(&poses[..seconds]);
        leg
    }

    /// The poses.
    pub fn poses(&self) -> &[Pose] {
        &self.poses[..self.seconds]
    }
}
