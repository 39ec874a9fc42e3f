//! What cameras see: vertical prisms that stand on the ground.

use csat_proto::ids::TargetId;

/// The thing that a ray meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Entity {
    /// The obstacle of this index.
    Obstacle(u32),
    /// The body of a target.
    Target(TargetId),
}

/// A simple polygon with holes extruded from z = 0 to `height_m`.
#[derive(Debug, Clone, PartialEq)]
pub struct Prism {
    /// The thing that has this body.
    pub entity: Entity,
    /// Outer ring counter-clockwise, then holes clockwise; `world`, metres; not closed.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Height of the flat top, metres.
    pub height_m: f64,
}

/// Everything that stands on the ground at one step. Solids of different entities never overlap;
/// obstacles may touch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// The prisms.
    pub prisms: Vec<Prism>,
}
