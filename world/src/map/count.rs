//! What became of each feature of a map file.

use std::collections::BTreeMap;
use std::fmt;

use super::report::FeatureRef;

/// Why a feature is not in the town.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeftOut {
    /// A polygon without a tag, as programs that find buildings in images make them.
    Untagged,
    /// `building` or `building:part` has a value that is neither text nor true or false.
    OddTag {
        /// The tag.
        key: &'static str,
        /// Its value, as JSON.
        got: String,
    },
    /// `geometry` is null.
    NoGeometry,
    /// A geometry without positions.
    EmptyGeometry {
        /// Its type.
        got: String,
    },
    /// A geometry of the wrong type.
    WrongGeometry {
        /// Its type.
        got: &'static str,
        /// What is expected.
        expected: &'static str,
    },
    /// No ring encloses an area.
    NoArea,
    /// A road without two distinct positions.
    ShortRoad,
    /// It is outside the region.
    Outside,
    /// The outline of a building whose parts cover it: they are built instead.
    HasParts,
    /// `building=no`.
    NotABuilding,
    /// `location=underground`.
    Underground,
    /// A road in a tunnel.
    Tunnel,
    /// A `highway` that cars do not use.
    NotDrivable,
    /// Neither a building nor a road.
    OtherKind,
}

impl LeftOut {
    /// Whether it may be a mistake in the file. Trees, footpaths and tunnels are only counted; each
    /// ring or road without extent has a warning of its own.
    pub fn is_suspicious(&self) -> bool {
        use LeftOut::*;
        match self {
            Untagged | OddTag { .. } | NoGeometry | EmptyGeometry { .. } | WrongGeometry { .. } => {
                true
            }
            Outside => true,
            NoArea | ShortRoad | HasParts | NotABuilding | Underground | Tunnel => false,
            NotDrivable | OtherKind => false,
        }
    }
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = match self {
            Self::Untagged => "polygons without a `building` tag",
            Self::OddTag { key, got } => {
                return write!(f, "`{key}` is {got}, expected text or true");
            }
            Self::NoGeometry => "no geometry",
            Self::EmptyGeometry { got } => return write!(f, "an empty {got}"),
            Self::WrongGeometry { got, expected } => {
                return write!(f, "geometry is a {got}, expected {expected}");
            }
            Self::NoArea => "no ring encloses anything",
            Self::ShortRoad => "roads without two distinct positions",
            Self::Outside => "outside the region",
            Self::HasParts => "outlines whose parts (`building:part`) are built instead",
            Self::NotABuilding => "building=no",
            Self::Underground => "buildings underground",
            Self::Tunnel => "roads in tunnels",
            Self::NotDrivable => "ways that cars do not use",
            Self::OtherKind => "neither building nor road",
        };
        f.write_str(words)
    }
}

/// How many features a file has and what became of each: `features` = [`Self::used`] +
/// [`Self::left_out`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FeatureCount {
    /// Features of the file.
    pub features: usize,
    /// Those built as buildings.
    pub buildings: usize,
    /// Those built as parts of buildings.
    pub parts: usize,
    /// Those that cars may use.
    pub roads: usize,
    /// All others, by reason and in the order of the file.
    pub reasons: BTreeMap<LeftOut, Vec<FeatureRef>>,
}

impl FeatureCount {
    /// Features that are in the town.
    pub fn used(&self) -> usize {
        self.buildings + self.parts + self.roads
    }

    /// Features that are not.
    pub fn left_out(&self) -> usize {
        self.reasons.values().map(Vec::len).sum()
    }

    pub(super) fn leave_out(&mut self, reason: LeftOut, feature: &FeatureRef) {
        self.reasons.entry(reason).or_default().push(feature.clone());
    }
}

impl fmt::Display for FeatureCount {
    /// The sum, then a line per reason.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { features, buildings, parts, roads, reasons } = self;
        let counted =
            |count: usize, thing| format!("{count} {thing}{}", if count == 1 { "" } else { "s" });
        let (buildings, parts) =
            (counted(*buildings, "building"), counted(*parts, "building part"));
        let (roads, left_out) = (counted(*roads, "road"), self.left_out());
        write!(f, "features: {features} = {buildings} + {parts} + {roads} + {left_out} left out")?;
        reasons.iter().try_for_each(|(reason, which)| write!(f, "\n{:>7} {reason}", which.len()))
    }
}
