//! Impossible values of `[map]`.

use csat_proto::model::FLIGHT_CLEARANCE_M;

use super::report::MapError;
use super::{DesertModel, MAX_HEIGHT_M, MapConfig, MapKind, MapRules, SIZES_M};

/// The mistakes that can be found without reading a file.
pub fn mistakes(config: &MapConfig, rules: &MapRules) -> Vec<MapError> {
    let mut errors = Vec::new();
    let mut expect = |holds: bool, key: &'static str, got: String, expected: String| {
        if !holds {
            errors.push(MapError::Config { key, got, expected });
        }
    };
    let size_ok = config.size_m.iter().all(|s| SIZES_M.contains(s));
    let size_expected = format!("two lengths from {} to {} m", SIZES_M.start(), SIZES_M.end());
    let [east, north] = config.size_m;
    expect(size_ok, "map.size_m", format!("[{east}, {north}]"), size_expected);
    let limit = rules.height_limit_m();
    expect(
        limit > 1.0,
        "agents.altitude_m",
        format!("{} m for the lowest UAV", rules.lowest_altitude_m),
        format!("more than {} m", FLIGHT_CLEARANCE_M + 1.0),
    );
    match config.kind {
        MapKind::GeoJson => {
            let got = "left out with kind = \"geojson\"".into();
            expect(config.file.is_some(), "map.file", got, "a GeoJSON file".into());
        }
        MapKind::Generated => {
            no_file(config, "generated", &mut expect);
            town(config, rules, &mut expect);
        }
        MapKind::Open => {
            no_file(config, "open", &mut expect);
            no_buildings(config, "open", &mut expect);
            let spacing_ok = config.road_spacing_m == MapConfig::default().road_spacing_m;
            let got = format!("{} with kind = \"open\"", config.road_spacing_m);
            expect(spacing_ok, "map.road_spacing_m", got, NO_TOWN.into());
        }
        MapKind::Desert => {
            no_file(config, "desert", &mut expect);
            no_buildings(config, "desert", &mut expect);
            spacing(config, &mut expect);
            suburb(&config.desert, &mut expect);
        }
    }
    if config.kind != MapKind::Desert {
        let expected = "kind = \"desert\" or no such table".into();
        expect(config.desert.is_usual(), "map.desert", format!("{:?}", config.desert), expected);
    }
    start_line(config, &mut expect);
    errors
}

const NO_TOWN: &str = "no such key: there is no town";

/// Takes whether a value holds, its key, the value, and what is expected.
type Expect<'a> = dyn FnMut(bool, &'static str, String, String) + 'a;

/// The keys of imported towns, in a map that is none.
fn no_file(config: &MapConfig, kind: &str, expect: &mut Expect<'_>) {
    let file = config.file.as_deref().unwrap_or(std::path::Path::new(""));
    let got = format!("`{}` with kind = \"{kind}\"", file.display());
    expect(config.file.is_none(), "map.file", got, "kind = \"geojson\" or no file".into());
    let got = format!("set with kind = \"{kind}\"");
    let expected = "kind = \"geojson\" or no key".into();
    expect(config.untagged.is_none(), "map.untagged", got, expected);
}

/// The keys of buildings, in a map that has none.
fn no_buildings(config: &MapConfig, kind: &str, expect: &mut Expect<'_>) {
    let usual = MapConfig::default();
    for (key, got, usual) in [
        ("map.built_share", config.built_share, usual.built_share),
        ("map.min_height_m", config.min_height_m, usual.min_height_m),
        ("map.max_height_m", config.max_height_m, usual.max_height_m),
    ] {
        expect(got == usual, key, format!("{got} with kind = \"{kind}\""), NO_TOWN.into());
    }
}

fn spacing(config: &MapConfig, expect: &mut Expect<'_>) {
    let spacing_ok = (40.0..=1000.0).contains(&config.road_spacing_m);
    let got = config.road_spacing_m.to_string();
    expect(spacing_ok, "map.road_spacing_m", got, "40 to 1000 m".into());
}

/// The keys of desert suburbs.
fn suburb(desert: &DesertModel, expect: &mut Expect<'_>) {
    let DesertModel { loop_share, dead_end_share } = *desert;
    let shares =
        [("map.desert.loop_share", loop_share), ("map.desert.dead_end_share", dead_end_share)];
    let shares_ok = shares.map(|(_, share)| (0.0..=1.0).contains(&share));
    for ((key, share), is_share) in shares.into_iter().zip(shares_ok) {
        expect(is_share, key, share.to_string(), "a share from 0 to 1".into());
    }
    let expected = format!("at most 1 - loop_share = {}", 1.0 - loop_share);
    let sum_ok = shares_ok.contains(&false) || loop_share + dead_end_share <= 1.0;
    expect(sum_ok, "map.desert.dead_end_share", dead_end_share.to_string(), expected);
}

/// Where the start line may be; whether a road is there is known once there is a map.
fn start_line(config: &MapConfig, expect: &mut Expect<'_>) {
    let Some(point) = config.start_line else { return };
    let got = format!("{point:?} with kind = \"open\"");
    expect(config.kind != MapKind::Open, "map.start_line", got, NO_TOWN.into());
    let is_inside = (0..2).all(|axis| point[axis].abs() <= config.size_m[axis] / 2.0);
    let expected = "a point [east, north] of the region, border included, in metres".into();
    expect(is_inside, "map.start_line", format!("{point:?}"), expected);
}

/// The keys of generated towns.
fn town(config: &MapConfig, rules: &MapRules, expect: &mut Expect<'_>) {
    let share_ok = (0.0..1.0).contains(&config.built_share);
    let got = config.built_share.to_string();
    expect(share_ok, "map.built_share", got, "a share from 0 to below 1".into());
    spacing(config, expect);
    let heights = [config.min_height_m, config.max_height_m];
    let is_around = rules.lowest_altitude_m == f64::INFINITY;
    let most_m = if is_around { MAX_HEIGHT_M } else { f64::MAX };
    let heights_ok = heights[0] > 0.0 && heights[0] <= heights[1] && heights[1] <= most_m;
    let expected = match is_around {
        true => format!("0 < min_height_m <= max_height_m <= {MAX_HEIGHT_M} m"),
        false => "0 < min_height_m <= max_height_m".into(),
    };
    expect(heights_ok, "map.max_height_m", format!("{heights:?}"), expected);
}
