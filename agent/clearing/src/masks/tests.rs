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

const STILL: Moved = Moved { by: [0, 0], is_drifted: false };

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
            rect([margin, margin + REACH - 1], [120, 135]),
            rect([256 - margin - REACH, 255 - margin], [120, 135]),
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
    masks.learn(&filled(&sight, &[rect([200, 255], [0, 255])]));
    for _ in 0..60 {
        masks.advance(&sight, Moved { by: [1, 0], is_drifted: false }, &road);
        masks.grow(&sight);
    }
    let north = masks.frontier().clone();
    assert!(north.bounds().unwrap().rows[1] < 30, "only the northern one is left");
    // Back to the south.
    for _ in 0..20 {
        masks.advance(&sight, Moved { by: [-1, 0], is_drifted: false }, &road);
    }
    let entered = rect([256 - sight.radii.blind() - 20, 255 - sight.radii.blind()], [120, 135]);
    let expected = filled(&sight, &[entered]);
    assert_eq!(
        masks.unknown().clone().and(&filled(&sight, &[rect([128, 255], [0, 255])])),
        expected
    );
    masks.advance(&sight, Moved { by: [0, 0], is_drifted: true }, &road);
    masks.grow(&sight);
    assert!(masks.frontier().bounds().is_none_or(|bounds| bounds.rows[1] < 128));
}

#[test]
fn the_three_sets_are_all_that_can_be_road() {
    let (sight, road, mut masks) = road();
    let moves = [[1, 0], [0, 1], [-2, 1], [0, -3], [1, 1]];
    for (index, by) in moves.into_iter().cycle().take(40).enumerate() {
        let seen = if index % 3 == 0 { road.dilated(2).and(&sight.decided) } else { road.clone() };
        masks.advance(&sight, Moved { by, is_drifted: index % 7 == 0 }, &seen);
        masks.grow(&sight);
        let parts = [masks.mine(), masks.foreign(), masks.unknown()];
        let total: u32 = parts.iter().map(|part| part.count()).sum();
        assert_eq!(total, masks.road().count());
        assert!(parts.iter().all(|part| (*part).clone().and_not(masks.road()).is_empty()));
        let near = masks.unknown().dilated(REACH).and(masks.mine());
        assert_eq!(&near, masks.frontier());
    }
}

#[test]
fn speckle_is_forgotten_and_gaps_stay() {
    let (sight, road, mut masks) = road();
    let before = masks.road().clone();
    let speckled = road.clone().or(&filled(&sight, &[rect([50, 55], [50, 55])]));
    masks.advance(&sight, STILL, &speckled);
    assert_eq!(masks.road(), &before, "it was seen to be no road");
    let narrow = filled(&sight, &[rect([0, 255], [121, 134])]);
    masks.advance(&sight, STILL, &narrow);
    assert_eq!(masks.mine().bounds().unwrap().columns, [121, 134]);
}

#[test]
fn who_learns_that_the_road_beyond_is_cleared_needs_no_frontier_there() {
    let (sight, _, mut masks) = road();
    let both = masks.frontier().count();
    let near = filled(&sight, &[rect([0, 10], [0, 255])]);
    assert_eq!(masks.learn(&near), 0, "unknown road is left between");
    let north = filled(&sight, &[rect([0, 60], [0, 255])]);
    assert_eq!(masks.learn(&north), both / 2);
    assert_eq!(masks.learn(&north), 0, "repeats change nothing");
    assert_eq!(masks.foreign().bounds().unwrap().rows, [sight.radii.blind(), sight.margin - 1]);
}
