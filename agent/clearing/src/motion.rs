//! Where a cleaner moves (III-B of the paper): one of nine displacements.
//!
//! The candidate follows from the sides of the image that the frontier touches. It is feasible if the whole frontier
//! stays in the image, at least `guard` from its edge, whatever the vehicle errs.

use crate::bitmap::Rect;
use crate::config::AgentConfig;
use crate::frontier::{Run, Side, Sides, rect_of, sides_of};

/// A displacement: east and north, in units of `step_m`.
pub type Direction = [i8; 2];

/// Nowhere.
pub const STAY: Direction = [0, 0];
/// With less room than this between the frontier and where it must not go, a cleaner moves aside, pixels.
const COMFORT_PX: f64 = 4.0;

/// What a cleaner has to keep to.
#[derive(Debug, Clone, Copy)]
pub struct Mover {
    size: u16,
    /// The least distance of a frontier from the edge at the next decision, with the error of the vehicle, pixels.
    least_px: f64,
    /// |Δ|, pixels.
    step_px: f64,
}

impl Mover {
    /// That of an agent.
    pub fn new(config: &AgentConfig) -> Self {
        let motion = config.radii().motion;
        Self {
            size: config.camera.columns,
            least_px: f64::from(config.clearing.guard_px + motion),
            step_px: config.clearing.step_m / config.pixel_m(),
        }
    }

    /// Room between a frontier in this rectangle and where it must not go, at each side, pixels.
    fn room(&self, rect: &Rect) -> [f64; 4] {
        Side::ALL.map(|side| f64::from(side.distance(rect, self.size)) - self.least_px)
    }

    /// The same after a displacement.
    fn room_after(&self, rect: &Rect, direction: Direction) -> [f64; 4] {
        let room = self.room(rect);
        [0, 1, 2, 3].map(|side| {
            let [east, north] = Side::ALL[side].direction();
            let towards = east * direction[0] + north * direction[1];
            room[side] + f64::from(towards) * self.step_px
        })
    }

    /// Whether the frontier in this rectangle stays where it may be. Where it is out of bounds already, it has to
    /// come nearer.
    pub fn is_feasible(&self, rect: &Rect, direction: Direction) -> bool {
        let (before, after) = (self.room(rect), self.room_after(rect, direction));
        before.iter().zip(after).all(|(before, after)| after >= 0.0 || after > *before)
    }

    /// How many displacements in this direction are feasible, one after the other.
    pub fn travel(&self, rect: &Rect, direction: Direction) -> u32 {
        let (room, after) = (self.room(rect), self.room_after(rect, direction));
        let steps = |side: usize| {
            let lost = room[side] - after[side];
            if lost > 0.0 { (room[side] / lost).max(0.0) as u32 } else { u32::MAX }
        };
        (0..4).map(steps).min().unwrap_or_default()
    }

    /// Where these runs can be pushed on to: their candidate, or with `along` one of its two components.
    pub fn advance<'a>(
        &self,
        runs: impl Iterator<Item = &'a Run> + Clone,
        along: bool,
    ) -> Option<Direction> {
        let rect = rect_of(runs.clone())?;
        let whole = candidate(sides_of(runs));
        let [east, north] = whole;
        let parts = if along { [[0, north], [east, 0]] } else { [STAY; 2] };
        let mut choices = std::iter::once(whole).chain(parts);
        let way = choices.find(|way| *way != STAY && self.is_feasible(&rect, *way))?;
        Some(self.aside(&rect, way))
    }

    /// A direction, turned by 45 degrees away from a side that the frontier is near to.
    fn aside(&self, rect: &Rect, way: Direction) -> Direction {
        let room = self.room(rect);
        let turned = match way {
            [0, north] if north != 0 => [push(room[1], room[3]), north],
            [east, 0] if east != 0 => [east, push(room[0], room[2])],
            _ => way,
        };
        if self.is_feasible(rect, turned) { turned } else { way }
    }

    /// How to wait with these runs, `back` displacements from where the cleaner should be.
    pub fn hold(&self, runs: &[Run], back: [f64; 2]) -> Hold {
        let Some(rect) = rect_of(runs.iter()) else { return Hold { way: STAY, away: None } };
        let room = self.room(&rect);
        let away = [push(room[1], room[3]), push(room[0], room[2])];
        let home = back.map(|steps| if steps.abs() > 1.0 { steps.signum() as i8 } else { 0 });
        let way = [0, 1].map(|axis| if away[axis] == 0 { home[axis] } else { away[axis] });
        let mut choices = [way, [way[0], 0], [0, way[1]]].into_iter();
        let way = choices.find(|way| self.is_feasible(&rect, *way)).unwrap_or(STAY);
        Hold { way, away: (away != STAY).then_some(away) }
    }
}

/// How a cleaner waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hold {
    /// Its displacement.
    pub way: Direction,
    /// Along which axes it gets away from where the frontier must not go.
    pub away: Option<Direction>,
}

/// Towards the side with less room, if it is too little and the other side has clearly more: 1 for the first one.
fn push(first_px: f64, second_px: f64) -> i8 {
    let is_close = |px: f64, other_px: f64| px < COMFORT_PX && other_px > px + 2.0;
    i8::from(is_close(first_px, second_px)) - i8::from(is_close(second_px, first_px))
}

/// III-B: one side: towards it; two that touch: between them; three: the middle one; otherwise nowhere.
pub fn candidate(sides: Sides) -> Direction {
    let [north, east, south, west] = sides.map(i8::from);
    [east - west, north - south]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_are_those_of_the_paper() {
        for (touched, expected) in [
            ("", STAY),
            ("n", [0, 1]),
            ("ne", [1, 1]),
            ("es", [1, -1]),
            ("wne", [0, 1]),
            ("nes", [1, 0]),
            ("ns", STAY),
            ("ew", STAY),
            ("nesw", STAY),
        ] {
            let sides = ['n', 'e', 's', 'w'].map(|side| touched.contains(side));
            assert_eq!(candidate(sides), expected, "{touched}");
        }
    }
}
