//! What can be wrong with a map, and what was put right. Every entry names the feature, so that the
//! file can be corrected.

use std::path::PathBuf;

/// A feature of a GeoJSON file.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct FeatureRef {
    /// Its 0-based place in `features`.
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
    /// A value of the scenario that cannot work.
    #[error("{key}: got {got}, expected {expected}")]
    Config {
        /// The scenario key.
        key: &'static str,
        /// Its value.
        got: String,
        /// What would do.
        expected: String,
    },
    /// The file could not be read.
    #[error("map.file: cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The text is not JSON.
    #[error("not JSON: {reason}")]
    NotJson {
        /// What the parser said, with line and column.
        reason: String,
    },
    /// The document is not a feature collection.
    #[error("got {got}, expected a GeoJSON FeatureCollection with an array of features")]
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
    /// A position outside the ranges of longitude and latitude.
    #[error(
        "{feature}: position {got:?}, expected [longitude, latitude] in degrees (is the file in \
         projected coordinates?)"
    )]
    BadPosition {
        /// Which feature.
        feature: FeatureRef,
        /// The position.
        got: Vec<f64>,
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

/// What was put right or left out.
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
    /// A ring that encloses nothing.
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
    /// A feature without geometry.
    #[error("{feature}: no geometry; left out")]
    NoGeometry {
        /// Which feature.
        feature: FeatureRef,
    },
    /// A geometry of the wrong type.
    #[error("{feature}: geometry is a {got}, expected {expected}; left out")]
    WrongGeometry {
        /// Which feature.
        feature: FeatureRef,
        /// Its type.
        got: &'static str,
        /// What would do.
        expected: &'static str,
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
    #[error("{feature}: {key} = {got}, expected a positive number{unit}; took {used_m} m")]
    BadHeight {
        /// Which feature.
        feature: FeatureRef,
        /// `height` or `building:levels`.
        key: &'static str,
        /// Its value.
        got: String,
        /// The unit it may carry.
        unit: &'static str,
        /// The height used instead, metres.
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
        /// The one.
        feature: FeatureRef,
        /// The other.
        other: FeatureRef,
        /// How much they share, m².
        area_m2: f64,
        /// What was done.
        what: &'static str,
    },
    /// Features that do not reach the region.
    #[error("{} feature(s) outside the region; left out, the first: {}", features.len(), features[0])]
    Outside {
        /// Which ones; never empty.
        features: Vec<FeatureRef>,
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
    /// Generated buildings would reach the UAVs.
    #[error("map.max_height_m: got {got_m} m, flights allow {max_m} m; lowered")]
    MaxHeightLowered {
        /// The height asked for, metres.
        got_m: f64,
        /// The height used, metres.
        max_m: f64,
    },
}
