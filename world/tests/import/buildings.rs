//! Heights, parts and overlaps of buildings.

use csat_world::map::{LeftOut, Map, MapWarning};
use serde_json::{Value, json};

use super::{SQUARE, area_m2, building, left_out, square, tall, with_road};

#[test]
fn heights_are_read_in_every_spelling() {
    for (tags, expected_m, warnings) in [
        (json!({}), 9.0, 0),
        (json!({ "height": "18" }), 18.0, 0),
        (json!({ "height": "18 m", "building:levels": "2" }), 18.0, 0),
        (json!({ "height": "12.5m" }), 12.5, 0),
        (json!({ "height": 7 }), 7.0, 0),
        (json!({ "height": null, "building:levels": "3.5" }), 10.5, 0),
        (json!({ "building:levels": 4 }), 12.0, 0),
        (json!({ "height": "tall", "building:levels": "4" }), 12.0, 1),
        (json!({ "height": "60'" }), 18.288, 0),
        (json!({ "height": "40'6\"" }), 12.3444, 0),
        (json!({ "height": "" }), 9.0, 0),
        (json!({ "building:height": "11 m", "est_height": "5" }), 11.0, 0),
        (json!({ "est_height": "13", "building:levels": "2" }), 13.0, 0),
        (json!({ "height": "?", "est_height": "13" }), 13.0, 1),
        (json!({ "building:levels": "2;3" }), 9.0, 0),
        (json!({ "building:levels": "2", "roof:levels": "1" }), 9.0, 0),
        (json!({ "building:levels": "2", "roof:levels": "1", "roof:height": "5 m" }), 11.0, 0),
        (json!({ "building:levels": "0", "roof:levels": "2" }), 6.0, 0),
        (json!({ "building:levels": "2", "roof:height": "steep" }), 6.0, 1),
        (json!({ "height": "15", "roof:height": "5" }), 15.0, 0),
        (json!({ "height": "6", "min_height": "7" }), 6.0, 1),
        (json!({ "height": "6", "min_height": "low" }), 6.0, 1),
        (json!({ "min_height": "0", "building:min_level": "0" }), 9.0, 0),
        (json!({ "height": "0" }), 9.0, 1),
        (json!({ "height": "-3" }), 9.0, 1),
        (json!({ "height": "NaN", "building:levels": "0" }), 9.0, 2),
        (json!({ "height": "18", "building:levels": "?" }), 18.0, 0),
        (json!({ "height": "50" }), 50.0, 0),
        (json!({ "height": "80" }), 50.0, 1),
    ] {
        let mut value = building(&[&SQUARE]);
        let properties = value["properties"].as_object_mut().unwrap();
        properties.extend(tags.as_object().unwrap().clone());
        let map = with_road(vec![value]);
        assert!((map.obstacles[0].height_m - expected_m).abs() < 1e-9, "{tags}");
        assert_eq!(map.warnings.len(), warnings, "{tags}: {:?}", map.warnings);
        for warning in &map.warnings {
            if let MapWarning::BadHeight { key, got, .. } = warning {
                assert!(tags[*key].to_string().contains(got.trim_matches('"')), "{warning}");
            }
            let clamped =
                matches!(warning, MapWarning::HeightClamped { got_m: 80.0, max_m: 50.0, .. });
            assert!(clamped || matches!(warning, MapWarning::BadHeight { .. }), "{warning}");
        }
    }
}

#[test]
fn overlaps_are_resolved_and_named() {
    let shifted: Vec<[f64; 2]> = SQUARE.iter().map(|p| [p[0] + 5.0, p[1] + 5.0]).collect();
    let map = with_road(vec![building(&[&SQUARE]), building(&[&shifted])]);
    assert!(matches!(map.warnings[..], [MapWarning::Overlap { what: "merged them", .. }]));
    assert_eq!(map.obstacles.len(), 1);
    let mut high = building(&[&shifted]);
    high["properties"]["height"] = json!("20");
    let map = with_road(vec![building(&[&SQUARE]), high]);
    assert!(matches!(map.warnings[..], [MapWarning::Overlap { what: "cut the lower one", .. }]));
    assert_eq!(map.obstacles.len(), 2);
    assert!((area_m2(&map) - 175.0).abs() < 0.02);
}

/// The height at a place; 0 without an obstacle.
fn height_at(map: &Map, p: [f64; 2]) -> f64 {
    let walls = csat_world::obstacle::Walls::new(&map.obstacles);
    walls.nearest_within(p, 1e-3).map_or(0.0, |(index, _)| map.obstacles[index].height_m)
}

#[test]
fn parts_are_built_and_the_outline_is_not() {
    let outline =
        tall(building(&[&square(0.0, 0.0, 20.0)]), json!({ "building": "yes", "height": "40" }));
    let half = |x: f64| [[x, 0.0], [x + 10.0, 0.0], [x + 10.0, 20.0], [x, 20.0], [x, 0.0]];
    let low = tall(building(&[&half(0.0)]), json!({ "building:part": "yes", "height": "6" }));
    let high = tall(building(&[&half(10.0)]), json!({ "building:part": "yes", "height": "40" }));
    let map = with_road(vec![outline.clone(), low, high]);
    assert_eq!(map.warnings, []);
    assert_eq!(left_out(&map), [(LeftOut::HasParts, 1)]);
    assert_eq!((map.count.buildings, map.count.parts), (0, 2));
    assert_eq!((height_at(&map, [5.0, 10.0]), height_at(&map, [15.0, 10.0])), (6.0, 40.0));

    // A part without a height is as high as its building; a part with the value `no` is left out.
    let bare = tall(building(&[&half(0.0)]), json!({ "building:part": "yes" }));
    let none = tall(building(&[&half(10.0)]), json!({ "building:part": "no", "height": "9" }));
    let map = with_road(vec![outline, bare, none]);
    assert_eq!(height_at(&map, [5.0, 10.0]), 40.0);
    assert_eq!(left_out(&map), [(LeftOut::NotABuilding, 1)]);
}

#[test]
fn ground_that_no_part_covers_is_built_and_told() {
    let tower = tall(
        building(&[&square(5.0, 5.0, 9.0)]),
        json!({ "building:part": "yes", "height": "40" }),
    );
    for (height, rest_m) in [(json!("6"), 6.0), (Value::Null, 40.0), (json!("40"), 40.0)] {
        let tags = json!({ "building": "yes", "height": height });
        let map = with_road(vec![tall(building(&[&square(0.0, 0.0, 30.0)]), tags), tower.clone()]);
        assert_eq!(height_at(&map, [9.0, 9.0]), 40.0);
        assert_eq!(height_at(&map, [25.0, 25.0]), rest_m, "{height}");
        assert!(
            matches!(&map.warnings[..],
            [MapWarning::PartsLeave { parts: 1, area_m2, used_m, .. }]
                if (area_m2 - 819.0).abs() < 0.1 && *used_m == rest_m),
            "{:?}",
            map.warnings
        );
        assert_eq!((map.count.buildings, map.count.parts), (1, 1));
    }
    // The height of the whole building is not that of the rest, which is as high as the lowest part.
    let low = tall(
        building(&[&square(15.0, 5.0, 9.0)]),
        json!({ "building:part": "yes", "height": "8" }),
    );
    let whole =
        tall(building(&[&square(0.0, 0.0, 30.0)]), json!({ "building": "yes", "height": "40" }));
    let map = with_road(vec![whole, tower, low]);
    assert_eq!((height_at(&map, [25.0, 25.0]), height_at(&map, [9.0, 9.0])), (8.0, 40.0));
    // A gap that is an error of drawing is ignored.
    let tags = json!({ "building": "yes" });
    let part = tall(
        building(&[&square(0.2, 0.2, 29.6)]),
        json!({ "building:part": "yes", "height": "7" }),
    );
    let map = with_road(vec![tall(building(&[&square(0.0, 0.0, 30.0)]), tags), part.clone()]);
    assert_eq!((map.obstacles.len(), &map.warnings[..]), (1, &[][..]));
    // A part without a building around it is a building.
    let map = with_road(vec![part]);
    assert_eq!((height_at(&map, [9.0, 9.0]), map.count.parts), (7.0, 1));
}

#[test]
fn what_begins_above_the_ground_is_built_from_the_ground() {
    let podium = tall(
        building(&[&square(0.0, 0.0, 20.0)]),
        json!({ "building:part": "yes", "height": "6" }),
    );
    let on = |side: f64, tags: Value| tall(building(&[&square(5.0, 5.0, side)]), tags);
    let upper = json!({ "building:part": "yes", "height": "30", "min_height": "6" });
    let map = with_road(vec![podium.clone(), on(10.0, upper.clone())]);
    let outlined = tall(building(&[&square(0.0, 0.0, 20.0)]), json!({ "building": "yes" }));
    assert_eq!((height_at(&map, [10.0, 10.0]), height_at(&map, [2.0, 2.0])), (30.0, 6.0));
    assert!(
        !map.warnings.iter().any(|w| matches!(w, MapWarning::Floating { .. })),
        "{:?}",
        map.warnings
    );
    // Within one building parts may stand on each other without a warning.
    let map = with_road(vec![outlined, podium.clone(), on(10.0, upper)]);
    assert_eq!(map.warnings, []);
    // The upper one reaches 5 m x 20 m and 15 m x 5 m beyond the podium.
    let levels =
        json!({ "building:part": "yes", "building:levels": "9", "building:min_level": "2" });
    let map = with_road(vec![podium, on(20.0, levels)]);
    assert_eq!(height_at(&map, [22.0, 22.0]), 27.0);
    let floating = |w: &&MapWarning| matches!(w, MapWarning::Floating { base_m: 6.0, area_m2, .. } if (area_m2 - 175.0).abs() < 0.1);
    assert_eq!(map.warnings.iter().filter(floating).count(), 1, "{:?}", map.warnings);
    // A roof on columns is built down to the ground.
    let canopy =
        tall(building(&[&SQUARE]), json!({ "building": "roof", "height": "5", "min_height": "4" }));
    let map = with_road(vec![canopy]);
    assert_eq!(height_at(&map, [5.0, 5.0]), 5.0);
    assert!(matches!(&map.warnings[..], [MapWarning::Floating { base_m: 4.0, .. }]));
}
