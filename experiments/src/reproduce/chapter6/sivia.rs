//! Set inversion by interval analysis: SIVIA and Thick SIVIA (thesis A.3, A.4).
//!
//! A box is bisected until something is proved of it or it is small. The arithmetic rounds outward, so what is proved
//! is true: this is what the sets of [`csat_agent::sense`] are held against.

use super::interval::Interval;

/// A box of the plane.
pub type Cell = [Interval; 2];

/// What is proved of a box, for a set that depends on a parameter that is only known to be in a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Proof {
    /// It is in the set for every parameter: in X^∀.
    Inside,
    /// It is in the set for no parameter: outside X^∃.
    Outside,
    /// It is in X^∃ and outside X^∀.
    Penumbra,
    /// Nothing.
    Nothing,
}

/// Boxes that cover the first one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Paving {
    /// In X^∀.
    pub inside: Vec<Cell>,
    /// In X^∃ and outside X^∀.
    pub penumbra: Vec<Cell>,
    /// Outside X^∃.
    pub outside: Vec<Cell>,
    /// Too small to be bisected again.
    pub border: Vec<Cell>,
}

impl Paving {
    /// Paves `start`. A box is bisected across its longer side, of which neither is to be shorter than `least`.
    pub fn of(start: Cell, least: f64, prove: impl Fn(&Cell) -> Proof) -> Self {
        let (mut paving, mut stack) = (Self::default(), vec![start]);
        while let Some(cell) = stack.pop() {
            match prove(&cell) {
                Proof::Inside => paving.inside.push(cell),
                Proof::Outside => paving.outside.push(cell),
                Proof::Penumbra => paving.penumbra.push(cell),
                Proof::Nothing if cell.iter().any(|side| side.width() < least) => {
                    paving.border.push(cell);
                }
                Proof::Nothing => stack.extend(halves(&cell)),
            }
        }
        paving
    }
}

/// The halves of a box across its longer side.
fn halves(cell: &Cell) -> [Cell; 2] {
    let axis = usize::from(cell[1].width() > cell[0].width());
    let (side, middle) = (cell[axis], cell[axis].middle());
    [[side.low, middle], [middle, side.high]].map(|[from, to]| {
        let mut half = *cell;
        half[axis] = Interval::new(from, to);
        half
    })
}

/// The area of boxes that do not overlap.
pub fn area(cells: &[Cell]) -> f64 {
    cells.iter().map(|[x, y]| x.width() * y.width()).sum()
}

/// The box of the example of the thesis; its least width, which is not printed, gives the printed counts.
const RING: Interval = Interval::new(-5.0, 5.0);
const RING_LEAST: f64 = 0.1;
/// More than rounding.
const TIE: f64 = 1e-12;

/// How a set is inverted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Algorithm {
    /// SIVIA (A.3): one range of values for all parameters.
    Sivia,
    /// Thick SIVIA for X^∃ (A.4.3): what is in it is not asked whether it is in X^∀.
    ThickOuter,
    /// Thick SIVIA for X^∀ (A.4.4).
    ThickInner,
}

/// The distance from points of the plane to a point p that is in [-half, half]², between 2 and 4 (A.21).
pub fn ring(half: f64, algorithm: Algorithm) -> Paving {
    // Some boxes touch the ring in a point, which rounding outward must not deny.
    let wanted = Interval::new(2.0 - TIE, 4.0 + TIE);
    let parameter = Interval::new(-half, half);
    let half = Interval::point(half);
    Paving::of([RING; 2], RING_LEAST, |cell| {
        if algorithm == Algorithm::Sivia {
            let [x, y] = cell.map(|x| x - parameter);
            let all = Interval::length(x, y);
            return match (all.is_in(wanted), all.misses(wanted)) {
                (true, _) => Proof::Inside,
                (_, true) => Proof::Outside,
                _ => Proof::Nothing,
            };
        }
        // The least and the greatest distance over p, for all points of the cell (A.24), (A.25).
        let [x, y] = cell.map(Interval::abs);
        let least = Interval::length((x - half).or_zero(), (y - half).or_zero());
        let greatest = Interval::length(x + half, y + half);
        thick_proof([least, greatest], wanted, algorithm)
    })
}

/// What the ranges of the least and of the greatest value of a continuous function over its parameters prove
/// (propositions 28 to 31).
fn thick_proof([least, greatest]: [Interval; 2], wanted: Interval, algorithm: Algorithm) -> Proof {
    let is_outside = greatest.high < wanted.low || least.low > wanted.high;
    let is_met = least.high <= wanted.high && greatest.low >= wanted.low;
    let is_inside = least.low >= wanted.low && greatest.high <= wanted.high;
    let is_left = least.high < wanted.low || greatest.low > wanted.high;
    let (is_inside, is_left) = match algorithm {
        Algorithm::ThickOuter => (false, true),
        _ => (is_inside, is_left),
    };
    match (is_inside, is_outside, is_met && is_left) {
        (true, ..) => Proof::Inside,
        (_, true, _) => Proof::Outside,
        (.., true) => Proof::Penumbra,
        _ => Proof::Nothing,
    }
}
