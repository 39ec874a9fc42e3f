//! Errors of a map, and warnings of what was corrected. Every entry names the feature, so that the
//! file can be corrected.

use std::path::PathBuf;

use super::count::LeftOut;

/// A feature of a GeoJSON file.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct FeatureRef {
    /// Its 0-based position in `features`.
    pub index: usize,
    /// Its `id`, if it has one.
    pub id: Option<String>,
    /// Its `name` property, if it has one.
    pub name: Option<String>,
}

impl std::fmt::Display for FeatureRef {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "feature {}", self.index)?;
        match (&self.id, &self.name) {
            (None, None) => Ok(()),
            (Some(id), None) => write!(f, " ({id})"),
            (None, Some(name)) => write!(f, " ({name:?})"),
            (Some(id), Some(name)) => write!(f, " ({id}, {name:?})"),
        }
    }
}

/// Why there is no map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MapError {
    /// An impossible value of the scenario.
    #[error("{key}: got {got}, expected {expected}")]
    Config {
        /// The scenario key.
        key: &'static str,
        /// Its value.
        got: String,
        /// What is expected.
        expected: String,
    },
    /// The file could not be read.
    #[error("map.file: cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The message of the system.
        reason: String,
    },
    /// The text is not JSON.
    #[error("not JSON: {reason} at line {line}, column {column}")]
    NotJson {
        /// What the parser said.
        reason: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1, in bytes and without a byte order mark.
        column: usize,
    },
    /// The document is not GeoJSON.
    #[error(
        "got {got}, expected a GeoJSON FeatureCollection with an array of features, or features one \
         after the other (GeoJSONSeq, RFC 8142)"
    )]
    NotCollection {
        /// What it is instead.
        got: String,
    },
    /// The `center` member is not a position.
    #[error("center: got {got}, expected [longitude, latitude] in degrees")]
    BadCenter {
        /// Its value.
        got: String,
    },
    /// A feature is not a GeoJSON feature.
    #[error("{feature}: {reason}, expected a GeoJSON Feature (RFC 7946 §3.2)")]
    BadFeature {
        /// Which one.
        feature: FeatureRef,
        /// What the parser said.
        reason: String,
    },
    /// Further invalid features, after those that are named one by one.
    #[error("{count} more features are no GeoJSON Features (RFC 7946 §3.2)")]
    MoreBadFeatures {
        /// How many.
        count: usize,
    },
    /// Positions outside the ranges of longitude and latitude.
    #[error(
        "{count} feature(s) have positions that are no [longitude, latitude] in degrees; is the file \
         in projected coordinates? The first: {feature} at {got:?}"
    )]
    BadPosition {
        /// The first of them.
        feature: FeatureRef,
        /// Its first such position.
        got: Vec<f64>,
        /// How many features it is.
        count: usize,
    },
    /// The file names a coordinate reference system of its own.
    #[error(
        "crs: the file is in {got}, expected longitude and latitude of WGS 84 (RFC 7946 §4), which \
         `ogr2ogr -t_srs EPSG:4326 out.geojson in.geojson` makes; {bad} of its {features} feature(s) \
         have positions that are none"
    )]
    ForeignCrs {
        /// Its name.
        got: String,
        /// Features of the file.
        features: usize,
        /// Buildings and roads of which a position is outside the ranges of longitude and latitude.
        bad: usize,
    },
    /// Polygons of which none is tagged as a building.
    #[error(
        "no building, and {count} polygon(s) without a `building` tag, the first: {feature}; \
         map.untagged = \"buildings\" makes them buildings, \"ignore\" flies without them"
    )]
    Untagged {
        /// The first of them.
        feature: FeatureRef,
        /// How many.
        count: usize,
    },
    /// The generated town has no room for so many buildings.
    #[error(
        "map.built_share: got {got}, expected at most {max:.3} between streets {road_spacing_m} m \
         apart: lower it or raise map.road_spacing_m"
    )]
    BuiltShare {
        /// The share asked for.
        got: f64,
        /// The share that this region can reach.
        max: f64,
        /// `map.road_spacing_m`.
        road_spacing_m: f64,
    },
}

/// What was corrected or left out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MapWarning {
    /// A ring did not end where it began.
    #[error("{feature}: {ring} was not closed; closed it")]
    RingClosed {
        /// Which feature.
        feature: FeatureRef,
        /// Which ring of it.
        ring: String,
    },
    /// A ring repeated positions.
    #[error("{feature}: {ring} repeats {count} positions in a row; dropped them")]
    RepeatedPositions {
        /// Which feature.
        feature: FeatureRef,
        /// Which ring of it.
        ring: String,
        /// How many.
        count: usize,
    },
    /// A ring crossed or touched itself.
    #[error("{feature}: {ring} crosses itself; rebuilt as {parts} simple part(s)")]
    SelfCrossing {
        /// Which feature.
        feature: FeatureRef,
        /// Which ring of it.
        ring: String,
        /// How many polygons it became.
        parts: usize,
    },
    /// A ring too short to enclose anything.
    #[error("{feature}: {ring} has {got} positions, expected at least 4; left out")]
    ShortRing {
        /// Which feature.
        feature: FeatureRef,
        /// Which ring of it.
        ring: String,
        /// Its number of positions.
        got: usize,
    },
    /// A ring that encloses no area.
    #[error("{feature}: {ring} encloses {got_m2:.4} m²; left out")]
    ZeroArea {
        /// Which feature.
        feature: FeatureRef,
        /// Which ring of it.
        ring: String,
        /// Its area, m².
        got_m2: f64,
    },
    /// A hole that is not inside its outer ring.
    #[error("{feature}: {ring} leaves the outer ring by {outside_m2:.2} m²; ignored that part")]
    HoleOutside {
        /// Which feature.
        feature: FeatureRef,
        /// Which ring of it.
        ring: String,
        /// How much of it is outside, m².
        outside_m2: f64,
    },
    /// Features that are not in the town.
    #[error(
        "{} feature(s) left out: {reason}{}; the first: {}",
        features.len(), hint(reason), features[0]
    )]
    LeftOut {
        /// Why.
        reason: LeftOut,
        /// Which ones; never empty.
        features: Vec<FeatureRef>,
    },
    /// A road with fewer than two distinct positions.
    #[error("{feature}: road with {got} distinct position(s), expected at least 2; left out")]
    ShortRoad {
        /// Which feature.
        feature: FeatureRef,
        /// How many it has.
        got: usize,
    },
    /// A height that cannot be read.
    #[error("{feature}: {key} = {got}, expected {expected}; took {used_m} m")]
    BadHeight {
        /// Which feature.
        feature: FeatureRef,
        /// The tag.
        key: &'static str,
        /// Its value, as JSON.
        got: String,
        /// What can be read.
        expected: &'static str,
        /// The height used instead, metres.
        used_m: f64,
    },
    /// A building or part that does not reach down to the ground.
    #[error(
        "{feature}: begins {base_m} m above the ground and nothing stands under {area_m2:.0} m² of it; \
         built from the ground"
    )]
    Floating {
        /// Which feature.
        feature: FeatureRef,
        /// Height of its underside, metres.
        base_m: f64,
        /// Area without a building underneath, m².
        area_m2: f64,
    },
    /// A building whose parts do not cover all of its outline.
    #[error(
        "{feature}: its {parts} part(s) leave {area_m2:.0} m² of the outline free; built that {used_m} m high"
    )]
    PartsLeave {
        /// The building.
        feature: FeatureRef,
        /// How many parts it has.
        parts: usize,
        /// Area that they do not cover, m².
        area_m2: f64,
        /// The height used there, metres.
        used_m: f64,
    },
    /// A building as high as the UAVs fly.
    #[error("{feature}: {got_m} m high, flights allow {max_m} m; lowered")]
    HeightClamped {
        /// Which feature.
        feature: FeatureRef,
        /// Its height, metres.
        got_m: f64,
        /// The height it was given, metres.
        max_m: f64,
    },
    /// Two buildings share ground.
    #[error("{feature} and {other} overlap by {area_m2:.2} m²; {what}")]
    Overlap {
        /// One building.
        feature: FeatureRef,
        /// The other building.
        other: FeatureRef,
        /// The common area, m².
        area_m2: f64,
        /// What was done.
        what: &'static str,
    },
    /// The file has no `center`.
    #[error("no center; took the middle of the data, [{}, {}]", got[0], got[1])]
    NoCenter {
        /// Longitude and latitude used, degrees.
        got: [f64; 2],
    },
    /// The file has no building inside the region.
    #[error("no building inside the region")]
    NoBuildings,
    /// The file has no drivable road.
    #[error("no drivable road in the file")]
    NoRoads,
    /// A building that is too high near a start.
    #[error(
        "{name}: {got_m:.1} m high, {max_m} m allow UAVs to start within {radius_m} m; lowered"
    )]
    LaunchSite {
        /// The building.
        name: String,
        /// Its height, metres.
        got_m: f64,
        /// The height it was given, metres.
        max_m: f64,
        /// The radius about a start within which buildings are lowered, metres.
        radius_m: f64,
    },
    /// Generated buildings would reach the UAVs.
    #[error("map.max_height_m: got {got_m} m, flights allow {max_m} m; lowered")]
    MaxHeightLowered {
        /// The height asked for, metres.
        got_m: f64,
        /// The height used, metres.
        max_m: f64,
    },
}

fn hint(reason: &LeftOut) -> &'static str {
    match reason {
        LeftOut::Untagged => " (map.untagged = \"buildings\" makes them buildings)",
        _ => "",
    }
}
