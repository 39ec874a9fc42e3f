//! Which sub-frontiers a cleaner gives away so that it can move on.

use crate::config::Give;
use crate::frontier::{Run, Side, rect_of, sides_of};
use crate::motion::{Direction, Mover, STAY, candidate};

/// With more runs than this not all choices are compared.
const MAX_COMPARED: usize = 8;
/// A choice of runs to keep has to allow so many displacements.
const TRAVEL: u32 = 16;

/// What a cleaner does next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decision {
    /// The displacement that pushes the frontier on; `None` if there is none.
    pub advance: Option<Direction>,
    /// The runs to give away, by their indices.
    pub give: Vec<usize>,
}

/// Decides for a cleaner with these runs.
pub fn decide(mover: &Mover, give: Give, runs: &[Run]) -> Decision {
    let along = give == Give::Balanced;
    let Some(rect) = rect_of(runs.iter()) else {
        return Decision { advance: None, give: Vec::new() };
    };
    let advance = mover.advance(runs.iter(), along);
    let whole = candidate(sides_of(runs.iter()));
    let is_whole = whole != STAY && mover.is_feasible(&rect, whole);
    let give = match give {
        _ if is_whole => Vec::new(),
        Give::Paper => hindering(mover, runs),
        Give::Balanced if runs.len() <= MAX_COMPARED => fewest(mover, runs),
        Give::Balanced => hindering(mover, runs),
    };
    Decision { advance, give }
}

/// The paper's rule: the runs that hinder, in the order of the sides, until the rest can move on.
fn hindering(mover: &Mover, runs: &[Run]) -> Vec<usize> {
    let mut given: Vec<usize> = Vec::new();
    for side in 0..Side::ALL.len() {
        for (index, run) in runs.iter().enumerate() {
            let is_free =
                mover.advance(kept(runs, |index| !given.contains(&index)), false).is_some();
            if is_free {
                return given;
            }
            let is_last = given.len() + 1 == runs.len();
            if !is_last && run.sides[side] && !given.contains(&index) {
                given.push(index);
            }
        }
    }
    given
}

/// The fewest pixels whose absence lets the rest move on.
fn fewest(mover: &Mover, runs: &[Run]) -> Vec<usize> {
    let choices = (1_u32..1 << runs.len()).filter_map(|choice| {
        let rest = kept(runs, |index| choice >> index & 1 == 1);
        let way = mover.advance(rest.clone(), false)?;
        let travel = mover.travel(&rect_of(rest.clone())?, way).min(TRAVEL);
        let pixels: u32 = rest.map(|run| run.pixels).sum();
        Some(((travel, pixels), choice))
    });
    let Some((_, best)) = choices.max() else { return hindering(mover, runs) };
    (0..runs.len()).filter(|index| best >> index & 1 == 0).collect()
}

fn kept(
    runs: &[Run],
    is_kept: impl Fn(usize) -> bool + Clone,
) -> impl Iterator<Item = &Run> + Clone {
    runs.iter().enumerate().filter(move |(index, _)| is_kept(*index)).map(|(_, run)| run)
}
