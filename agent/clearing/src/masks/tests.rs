use super::*;
use crate::exchange::validate::tests::config;

fn sight() -> Sight {
    Sight::new(&config())
}

fn rect(rows: [u16; 2], columns: [u16; 2]) -> Rect {
    Rect { rows, columns }
}

fn filled(sight: &Sight, rects: &[Rect]) -> Bitmap {
    let mut bitmap = sight.nothing();
    rects.iter().for_each(|rect| bitmap.fill(rect));
    bitmap
}

const STILL: Moved = moved([0, 0], false);

const fn moved(by: [i32; 2], is_drifted: bool) -> Moved {
    Moved { by, is_drifted, is_lost: false }
}

/// A road from north to south through the middle, cleared from its middle on.
fn road() -> (Sight, Bitmap, Masks) {
    let sight = sight();
    let road = filled(&sight, &[rect([0, 255], [120, 135])]).and(&sight.decided);
    let mut masks = Masks::new(&sight, road.clone());
    masks.begin(&sight, &filled(&sight, &[rect([128, 128], [120, 135])]));
    (sight, road, masks)
}

#[test]
fn cleared_ground_grows_up_to_the_margin() {
    let (sight, _, masks) = road();
    let margin = sight.margin;
    let expected = rect([margin, 255 - margin], [120, 135]);
    assert_eq!(masks.mine().bounds(), Some(expected));
    let frontier = filled(
        &sight,
        &[
            rect([margin, margin + sight.radii.reach - 1], [120, 135]),
            rect([256 - margin - sight.radii.reach, 255 - margin], [120, 135]),
        ],
    );
    assert_eq!(masks.frontier(), &frontier);
    // Nothing is claimed, or said to be safe, near to what is unknown or to the edge.
    let Radii { claim, rho, .. } = sight.radii;
    let rows = [margin + claim, 255 - margin - claim];
    assert_eq!(masks.claims(&sight).bounds(), Some(rect(rows, [120, 135])));
    let safe = masks.safe(&sight);
    assert!(safe.get(margin + rho, 128) && !safe.get(margin + rho - 1, 128));
    assert!(safe.get(sight.radii.blind() + rho, 20));
    assert!(!safe.get(128, sight.radii.blind() + rho - 1));
}

#[test]
fn what_enters_is_unknown_and_no_boundary_of_what_was_cleared() {
    let (sight, road, mut masks) = road();
    // North: the southern frontier would leave; another cleaner has it.
    masks.learn(&sight, &filled(&sight, &[rect([200, 255], [0, 255])]));
    for _ in 0..60 {
        let _ = masks.advance(&sight, moved([1, 0], false), &road);
        masks.grow(&sight);
    }
    let north = masks.frontier().clone();
    assert!(north.bounds().unwrap().rows[1] < 30, "only the northern one is left");
    // Back to the south.
    for _ in 0..20 {
        let _ = masks.advance(&sight, moved([-1, 0], false), &road);
    }
    let entered = rect([256 - sight.radii.blind() - 20, 255 - sight.radii.blind()], [120, 135]);
    let expected = filled(&sight, &[entered]);
    assert_eq!(
        masks.unknown().clone().and(&filled(&sight, &[rect([128, 255], [0, 255])])),
        expected
    );
    let _ = masks.advance(&sight, moved([0, 0], true), &road);
    masks.grow(&sight);
    assert!(masks.frontier().bounds().is_none_or(|bounds| bounds.rows[1] < 128));
}

#[test]
fn a_frontier_is_held_up_to_the_rim() {
    let (sight, road, mut masks) = road();
    // The southern frontier nears the edge.
    let steps = sight.margin - sight.radii.rim();
    for step in 0..=steps {
        let is_held = masks.advance(&sight, moved([1, 0], false), &road);
        assert_eq!(is_held, step < steps, "{step} of {steps}");
        masks.grow(&sight);
    }
    let (sight, road, mut masks) = self::road();
    assert!(masks.advance(&sight, moved([i32::from(steps), 0], false), &road));
    masks.grow(&sight);
    assert!(!masks.advance(&sight, moved([0, 0], true), &road), "one pixel more");
    let (sight, road, mut masks) = self::road();
    assert!(!masks.advance(&sight, moved([120, 0], false), &road), "out of sight");
}

#[test]
fn what_comes_into_sight_with_the_drift_is_unknown() {
    let (sight, road, mut masks) = road();
    let edge = sight.radii.blind();
    let all = filled(&sight, &[rect([0, 60], [0, 255])]);
    masks.learn(&sight, &all);
    assert!(!masks.unknown().get(edge, 128));
    let _ = masks.advance(&sight, moved([0, 0], true), &road);
    assert!(masks.unknown().get(edge, 128), "another cell may be there now");
    assert!(!masks.unknown().get(edge + 1, 128));
}

#[test]
fn the_three_sets_are_all_that_can_be_road() {
    let (sight, road, mut masks) = road();
    let moves = [[1, 0], [0, 1], [-2, 1], [0, -3], [1, 1]];
    for (index, by) in moves.into_iter().cycle().take(40).enumerate() {
        let seen = if index % 3 == 0 { road.dilated(2).and(&sight.decided) } else { road.clone() };
        let _ = masks.advance(&sight, moved(by, index % 7 == 0), &seen);
        masks.grow(&sight);
        let parts = [masks.mine(), masks.foreign(), masks.unknown()];
        let total: u32 = parts.iter().map(|part| part.count()).sum();
        assert_eq!(total, masks.road().count());
        assert!(parts.iter().all(|part| (*part).clone().and_not(masks.road()).is_empty()));
        let near = masks.unknown().dilated(sight.radii.reach).and(masks.mine());
        assert_eq!(&near, masks.frontier());
    }
}

#[test]
fn speckle_is_forgotten_and_gaps_stay() {
    let (sight, road, mut masks) = road();
    let before = masks.road().clone();
    let speckled = road.clone().or(&filled(&sight, &[rect([50, 55], [50, 55])]));
    let _ = masks.advance(&sight, STILL, &speckled);
    assert_eq!(masks.road(), &before, "it was seen to be no road");
    let narrow = filled(&sight, &[rect([0, 255], [121, 134])]);
    let _ = masks.advance(&sight, STILL, &narrow);
    assert_eq!(masks.mine().bounds().unwrap().columns, [121, 134]);
}

#[test]
fn who_learns_that_the_road_beyond_is_cleared_needs_no_frontier_there() {
    let (sight, _, mut masks) = road();
    let both = masks.frontier().count();
    let near = filled(&sight, &[rect([0, 10], [0, 255])]);
    assert_eq!(masks.learn(&sight, &near), 0, "unknown road is left between");
    let north = filled(&sight, &[rect([0, 60], [0, 255])]);
    assert_eq!(masks.learn(&sight, &north), both / 2);
    assert_eq!(masks.learn(&sight, &north), 0, "repeats change nothing");
    assert_eq!(masks.foreign().bounds().unwrap().rows, [sight.radii.blind(), sight.margin - 1]);
}
