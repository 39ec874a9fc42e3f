//! Formations: who follows a cleaner, and where.

use csat_proto::ids::AgentId;

use crate::exchange::message::Formation;
use crate::motion::Direction;

/// A place in a formation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A wing: 0 is the left one, 1 the right one.
    Wing(usize),
    /// A tail: 0 is the first one.
    Tail(usize),
}

/// The agents that follow a cleaner.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Roster {
    /// The left and the right wing.
    pub wings: [Option<AgentId>; 2],
    /// The tails, the first one first.
    pub tails: Vec<AgentId>,
}

impl Roster {
    /// A formation of these agents, the first ones as wings.
    pub fn of(members: impl IntoIterator<Item = AgentId>) -> Self {
        let mut roster = Self { tails: members.into_iter().collect(), ..Self::default() };
        roster.fill();
        roster
    }

    /// All of them.
    pub fn members(&self) -> impl Iterator<Item = AgentId> {
        self.wings.iter().flatten().chain(&self.tails).copied()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.members().count()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Appends an agent as the last tail, unless it belongs to the formation.
    pub fn add(&mut self, id: AgentId) {
        if self.members().all(|member| member != id) {
            self.tails.push(id);
            self.fill();
        }
    }

    /// Keeps those that `stays` holds for, and fills vacant wings from the tails.
    pub fn retain(&mut self, stays: impl Fn(AgentId) -> bool) {
        for wing in &mut self.wings {
            *wing = wing.filter(|id| stays(*id));
        }
        self.tails.retain(|id| stays(*id));
        self.fill();
    }

    fn fill(&mut self) {
        for wing in &mut self.wings {
            if wing.is_none() && !self.tails.is_empty() {
                *wing = Some(self.tails.remove(0));
            }
        }
    }
}

/// The place of an agent in a formation.
pub fn place_of(formation: &Formation, id: AgentId) -> Option<Place> {
    let wing = formation.wings.iter().position(|wing| *wing == Some(id)).map(Place::Wing);
    let tail = || formation.tails.iter().position(|tail| *tail == id).map(Place::Tail);
    wing.or_else(tail)
}

/// The tails that a new cleaner takes with it: the first, the third and so on.
pub fn odd_tails(formation: &Formation) -> impl Iterator<Item = AgentId> {
    formation.tails.iter().step_by(2).copied()
}

/// Where a place is from the cleaner, east and north, metres: wings beside it, so that their images overlap halves of
/// its image; tails behind it. `side_m` is the side of an image.
pub fn station_m(place: Place, heading: Direction, side_m: f64, spacing_m: f64) -> [f64; 2] {
    let length = f64::from(heading[0]).hypot(f64::from(heading[1]));
    let ahead =
        if length > 0.0 { heading.map(|axis| f64::from(axis) / length) } else { [0.0, 1.0] };
    let (behind_m, left_m) = match place {
        Place::Wing(0) => (0.0, side_m / 4.0),
        Place::Wing(_) => (0.0, -side_m / 4.0),
        Place::Tail(index) => (side_m / 8.0 + spacing_m * index as f64, 0.0),
    };
    [-ahead[0] * behind_m - ahead[1] * left_m, -ahead[1] * behind_m + ahead[0] * left_m]
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDS: [AgentId; 6] =
        [AgentId(1), AgentId(2), AgentId(3), AgentId(4), AgentId(5), AgentId(6)];

    #[test]
    fn wings_are_filled_from_the_tails() {
        let mut roster = Roster::of(IDS);
        assert_eq!(roster.wings, [Some(IDS[0]), Some(IDS[1])]);
        roster.retain(|id| id != IDS[0]);
        assert_eq!((roster.wings, roster.tails[0]), ([Some(IDS[2]), Some(IDS[1])], IDS[3]));
        roster.add(IDS[0]);
        roster.add(IDS[0]);
        assert_eq!((roster.len(), roster.tails.last()), (6, Some(&IDS[0])));
        roster.retain(|_| false);
        assert!(roster.is_empty());
    }

    #[test]
    fn a_new_cleaner_takes_the_odd_tails() {
        let formation = Formation { tails: IDS[..5].to_vec(), ..Formation::default() };
        assert_eq!(odd_tails(&formation).collect::<Vec<_>>(), [IDS[0], IDS[2], IDS[4]]);
        assert_eq!(place_of(&formation, IDS[3]), Some(Place::Tail(3)));
        assert_eq!(place_of(&formation, IDS[5]), None);
    }

    #[test]
    fn stations_turn_with_the_heading() {
        let close = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9;
        assert!(close(station_m(Place::Wing(0), [0, 1], 100.0, 8.0), [-25.0, 0.0]));
        assert!(close(station_m(Place::Wing(1), [1, 0], 100.0, 8.0), [0.0, -25.0]));
        assert!(close(station_m(Place::Tail(1), [-1, 0], 100.0, 8.0), [20.5, 0.0]));
    }
}
