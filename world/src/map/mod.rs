//! The town: where the ground ends, what stands on it and where cars can drive.
//!
//! | module | what it holds |
//! |---|---|
//! | `generate` | a seeded town of streets and buildings |
//! | `desert` | a seeded suburb of streets without buildings |
//! | [`geojson`] | real towns from RFC 7946 files |
//! | `repair` | outlines of real towns made valid |
//! | `merge` | outlines that overlap made disjoint |
//! | `mistakes` | impossible values of the scenario |
//! | `project` | longitude and latitude to the local tangent plane |
//! | `causes` | warnings by cause |
//! | `count` | what became of each feature of a file |
//! | `report` | what can be wrong with a map, and what was put right |

use std::ops::RangeInclusive;
use std::path::PathBuf;

use csat_proto::model::Ground;
use serde::{Deserialize, Serialize};

mod causes;
mod count;
mod desert;
mod generate;
pub mod geojson;
mod merge;
mod mistakes;
mod project;
mod repair;
mod report;

pub use causes::by_cause;
pub use count::{FeatureCount, LeftOut};
pub use desert::DesertModel;
pub use mistakes::mistakes;
pub use project::TangentPlane;
pub use report::{FeatureRef, MapError, MapWarning};

use crate::obstacle::Obstacle;

/// Sides of a region, metres. The grid of sets spans ±4095 m (`proto::region`), and cameras look
/// farther than the region.
const SIZES_M: RangeInclusive<f64> = 20.0..=4000.0;

pub use csat_proto::model::FLIGHT_CLEARANCE_M;

/// The width of roads whose width is not known, metres.
pub const ROAD_WIDTH_M: f64 = 6.0;

/// The greatest height of a building, metres.
pub const MAX_HEIGHT_M: f64 = 1000.0;

/// Where the town comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MapKind {
    /// From the seed.
    #[default]
    Generated,
    /// From a file.
    GeoJson,
    /// No town: ground without buildings and roads.
    Open,
    /// Streets without buildings, from the seed: a grid with gaps, dead ends and loops.
    Desert,
}

/// What polygons without tags are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Untagged {
    /// Buildings, as in the output of programs that find buildings in images.
    Buildings,
    /// They are ignored.
    Ignore,
}

/// `[map]`: the region of interest and its town.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MapConfig {
    /// Where the town comes from.
    pub kind: MapKind,
    /// The GeoJSON file, for kind `geojson`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// What polygons without tags are, for kind `geojson`. Without it they are left out with a warning,
    /// and a file in which no polygon is tagged as a building is an error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub untagged: Option<Untagged>,
    /// Width (east) and depth (north) of the region of interest, metres.
    pub size_m: [f64; 2],
    /// Share of the region under buildings, 0..1; kind `generated`.
    pub built_share: f64,
    /// Lowest building, metres; kind `generated`.
    pub min_height_m: f64,
    /// Highest building, metres; kind `generated`.
    pub max_height_m: f64,
    /// Mean distance between parallel streets, metres; kinds `generated` and `desert`.
    pub road_spacing_m: f64,
    /// Which streets there are; kind `desert`.
    #[serde(skip_serializing_if = "DesertModel::is_usual")]
    pub desert: DesertModel,
    /// A point on a road at the border of the region, [east, north] in metres of `world`: what UAVs clear are
    /// the roads connected to it. Without it: see [`StartLine::choose`](crate::start_line::StartLine::choose).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_line: Option<[f64; 2]>,
}

impl Default for MapConfig {
    fn default() -> Self {
        Self {
            kind: MapKind::Generated,
            file: None,
            untagged: None,
            size_m: [500.0, 500.0],
            built_share: 0.05,
            min_height_m: 6.0,
            max_height_m: 45.0,
            road_spacing_m: 95.0,
            desert: DesertModel::default(),
            start_line: None,
        }
    }
}

/// What the rest of the scenario requires of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapRules {
    /// Altitude of the lowest UAV, metres. Tops stay [`FLIGHT_CLEARANCE_M`] below; infinite where UAVs
    /// fly around buildings, which then reach up to [`MAX_HEIGHT_M`].
    pub lowest_altitude_m: f64,
    /// How far a car's location stays from every wall, metres: generated streets are this wide on
    /// either side.
    pub road_clearance_m: f64,
}

impl MapRules {
    /// The highest top allowed, metres.
    pub fn height_limit_m(&self) -> f64 {
        if self.lowest_altitude_m == f64::INFINITY {
            return MAX_HEIGHT_M;
        }
        self.lowest_altitude_m - FLIGHT_CLEARANCE_M
    }
}

/// A town.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The region of interest.
    pub ground: Ground,
    /// The obstacles on it, clipped to it and disjoint up to rounding (a few µm).
    pub obstacles: Vec<Obstacle>,
    /// Centre lines of roads as mapped, `world`, metres: neither clipped nor clear of walls.
    pub roads: Vec<Vec<[f64; 2]>>,
    /// The widths of the roads by index, metres; roads beyond its end are [`ROAD_WIDTH_M`] wide.
    pub road_widths_m: Vec<f64>,
    /// The position of the middle of the region on Earth, [longitude, latitude] in degrees; `None`
    /// for a generated town.
    pub centre_deg: Option<[f64; 2]>,
    /// The attribution that has to be shown with the map.
    pub attribution: Option<String>,
    /// What became of each feature of its file; empty for a town without a file.
    pub count: FeatureCount,
    /// What was corrected or left out.
    pub warnings: Vec<MapWarning>,
}

impl Map {
    /// Open ground.
    pub fn open(ground: Ground) -> Self {
        Self {
            ground,
            obstacles: Vec::new(),
            roads: Vec::new(),
            road_widths_m: Vec::new(),
            centre_deg: None,
            attribution: None,
            count: FeatureCount::default(),
            warnings: Vec::new(),
        }
    }

    /// Share of the region under obstacles, 0..1.
    pub fn built_share(&self) -> f64 {
        // Without obstacles the sum is -0, which would be printed.
        (self.obstacles.iter().map(Obstacle::area_m2).sum::<f64>() + 0.0) / self.ground.area_m2()
    }

    /// The width of a road, metres.
    pub fn road_width_m(&self, road: usize) -> f64 {
        self.road_widths_m.get(road).copied().unwrap_or(ROAD_WIDTH_M)
    }

    /// The tangent plane between `world` and longitude and latitude; a town without a position on
    /// Earth is at (0, 0).
    pub fn plane(&self) -> TangentPlane {
        TangentPlane::new(self.centre_deg.unwrap_or_default())
    }
}

/// Generates or reads the town of `config`; equal arguments (and files) give equal maps.
///
/// # Errors
/// All mistakes together.
pub fn load(config: &MapConfig, rules: &MapRules, seed: u64) -> Result<Map, Vec<MapError>> {
    let errors = mistakes(config, rules);
    if !errors.is_empty() {
        return Err(errors);
    }
    match (config.kind, &config.file) {
        (MapKind::GeoJson, Some(path)) => {
            let text = std::fs::read_to_string(path)
                .map_err(|e| vec![MapError::Read { path: path.clone(), reason: e.to_string() }])?;
            geojson::import(&text, Ground { size_m: config.size_m }, rules, config.untagged)
        }
        (MapKind::Desert, _) => Ok(desert::streets(config, seed)),
        (MapKind::Open, _) => Ok(Map::open(Ground { size_m: config.size_m })),
        _ => generate::generate(config, rules, seed).map_err(|e| vec![e]),
    }
}

/// Reads the town from GeoJSON text; the file that `config` names is not read.
///
/// # Errors
/// All mistakes together.
pub fn from_geojson(
    config: &MapConfig,
    text: &str,
    rules: &MapRules,
) -> Result<Map, Vec<MapError>> {
    let errors = mistakes(config, rules);
    if !errors.is_empty() {
        return Err(errors);
    }
    geojson::import(text, Ground { size_m: config.size_m }, rules, config.untagged)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: MapRules = MapRules { lowest_altitude_m: 52.0, road_clearance_m: 2.55 };

    fn keys(config: &MapConfig, rules: &MapRules) -> Vec<&'static str> {
        let errors = load(config, rules, 1).unwrap_err();
        errors
            .iter()
            .map(|e| match e {
                MapError::Config { key, .. } => *key,
                other => panic!("{other}"),
            })
            .collect()
    }

    #[test]
    fn all_mistakes_are_named_at_once() {
        let config = MapConfig {
            file: Some("x.geojson".into()),
            size_m: [f64::NAN, 500.0],
            built_share: 1.0,
            road_spacing_m: -1.0,
            max_height_m: 5.0,
            ..MapConfig::default()
        };
        let rules = MapRules { lowest_altitude_m: 3.0, ..RULES };
        let expected = [
            "map.size_m",
            "agents.altitude_m",
            "map.file",
            "map.built_share",
            "map.road_spacing_m",
            "map.max_height_m",
        ];
        assert_eq!(keys(&config, &rules), expected);
        let config = MapConfig { kind: MapKind::GeoJson, ..MapConfig::default() };
        assert_eq!(keys(&config, &RULES), ["map.file"]);
    }

    #[test]
    fn open_ground_has_nothing_on_it_and_no_keys_of_towns() {
        let config =
            MapConfig { kind: MapKind::Open, size_m: [600.0, 400.0], ..MapConfig::default() };
        let map = load(&config, &RULES, 1).unwrap();
        assert_eq!(
            (map.ground.size_m, map.obstacles.len(), map.roads.len()),
            ([600.0, 400.0], 0, 0)
        );
        assert!(map.built_share().is_sign_positive(), "no -0");
        let wrong = MapConfig {
            file: Some("x.geojson".into()),
            untagged: Some(Untagged::Ignore),
            built_share: 0.1,
            min_height_m: 7.0,
            max_height_m: 44.0,
            road_spacing_m: 90.0,
            ..config
        };
        let expected = [
            "map.file",
            "map.untagged",
            "map.built_share",
            "map.min_height_m",
            "map.max_height_m",
            "map.road_spacing_m",
        ];
        assert_eq!(keys(&wrong, &RULES), expected);
    }

    #[test]
    fn the_keys_of_deserts_are_checked_and_belong_to_deserts() {
        let desert = |loop_share, dead_end_share| DesertModel { loop_share, dead_end_share };
        let config = MapConfig { kind: MapKind::Desert, ..MapConfig::default() };
        let map = load(&config, &RULES, 1).unwrap();
        assert_eq!((map.obstacles.len(), map.roads.len() > 24), (0, true));
        let wrong = MapConfig {
            file: Some("x.geojson".into()),
            untagged: Some(Untagged::Ignore),
            built_share: 0.1,
            min_height_m: 7.0,
            max_height_m: 44.0,
            road_spacing_m: 30.0,
            desert: desert(1.1, f64::NAN),
            start_line: Some([-250.1, 0.0]),
            ..config.clone()
        };
        let expected = [
            "map.file",
            "map.untagged",
            "map.built_share",
            "map.min_height_m",
            "map.max_height_m",
            "map.road_spacing_m",
            "map.desert.loop_share",
            "map.desert.dead_end_share",
            "map.start_line",
        ];
        assert_eq!(keys(&wrong, &RULES), expected);
        let wrong = MapConfig { desert: desert(0.6, 0.6), ..config };
        assert_eq!(keys(&wrong, &RULES), ["map.desert.dead_end_share"]);
        for (kind, expected) in [
            (MapKind::Generated, vec!["map.desert"]),
            (MapKind::Open, vec!["map.desert", "map.start_line"]),
        ] {
            let start_line = Some([-250.0, 0.0]);
            let wrong = MapConfig { kind, start_line, desert: desert(0.5, 0.5), ..wrong.clone() };
            assert_eq!(keys(&wrong, &RULES), expected);
        }
    }

    #[test]
    fn a_missing_file_is_named() {
        let config = MapConfig {
            kind: MapKind::GeoJson,
            file: Some("no/such.geojson".into()),
            ..MapConfig::default()
        };
        let errors = load(&config, &RULES, 1).unwrap_err();
        assert!(
            matches!(&errors[..], [MapError::Read { path, .. }] if path.ends_with("such.geojson"))
        );
    }

    #[test]
    fn the_scenario_table_reads_and_refuses_unknown_keys() {
        let json = r#"{"kind": "geojson", "file": "a.geojson", "size_m": [400, 300]}"#;
        let config: MapConfig = serde_json::from_str(json).unwrap();
        assert_eq!(config.kind, MapKind::GeoJson);
        assert_eq!(config.size_m, [400.0, 300.0]);
        assert!(serde_json::from_str::<MapConfig>(r#"{"sise_m": [1, 1]}"#).is_err());
        let json = r#"{"kind": "desert", "desert": {"loop_share": 0}, "start_line": [-250, 3]}"#;
        let config: MapConfig = serde_json::from_str(json).unwrap();
        let desert = DesertModel { loop_share: 0.0, ..DesertModel::default() };
        assert_eq!((config.desert, config.start_line), (desert, Some([-250.0, 3.0])));
        assert!(serde_json::from_str::<MapConfig>(r#"{"desert": {"loops": 1}}"#).is_err());
        let usual = serde_json::to_string(&MapConfig::default()).unwrap();
        assert!(!usual.contains("desert") && !usual.contains("start_line"), "{usual}");
    }
}
