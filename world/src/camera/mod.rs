//! The camera and the computer-vision system (CVS) of a UAV: the frames that they make of a [`Scene`].
//!
//! [`Renderer`] is fast and exact; [`oracle::Oracle`] is an independent ray caster with which the tests
//! compare it pixel by pixel. A frame is made in three steps:
//!
//! 1. `render`: depth buffer at pixel centres, visible contours, reach (thesis §3.5.2);
//! 2. `noise`: D = ρ(1+w) (3.33), quantised;
//! 3. `detect`: boxes of the identified targets (3.53).
//!
//! # Why the labels are exact (Assumption 4)
//!
//! A pixel is a closed square Q of the image. It may be labelled Ground, Obstacle or Target only if
//! every ray through Q meets the ground, one and the same obstacle, or one and the same target
//! first, at a distance of at most d_max.
//!
//! Every prism is a closed polyhedron standing on the plane z = 0, and the camera is above the ground
//! and outside all prisms: above a roof, or beside a higher prism. Floors never face the camera, roofs
//! do when they are below it, and the sky is met by rays at or above the horizon only. Call *contour*
//! of a prism all edges between a face that faces the camera and one that does not:
//!
//! - the base edge of a wall that faces the camera (wall | floor),
//! - the roof edge of a wall if one of roof and wall faces the camera and the other does not: below the
//!   camera of the walls that face away, above it of those that face the camera,
//! - the vertical edge between a wall that faces the camera and one that does not.
//!
//! A face whose plane contains the camera (within 1 µm) is treated as facing both ways: all its
//! edges are contour. The image of the prism's own outline is made of contour edges, and so is
//! every line where the prism's nearest surface jumps to a farther one.
//!
//! **Claim.** If no point of Q is the image of a *visible* contour point (one that no solid
//! strictly hides), all rays of Q meet the same entity, the one at the centre. **Proof.** Walk in Q
//! on a straight line from the centre q₀ to any q₁. Let q be the first place where the entity met
//! first stops being F. Either the first point of F on the ray of q is on the rim of F's image: a
//! contour point of F with nothing before it, thus visible. Or F goes on and another solid G gets
//! in front of it. Solids do not overlap, so on a connected piece of image covered by both, neither
//! having a contour, their order along the rays is constant: G can only come to lie in front of F
//! where its nearest surface begins or jumps, at a contour point of G that is at or before F:
//! visible as well. Where solids touch, the common wall faces the camera for one of them and away
//! for the other: of two roofs below the camera one has its roof edge and the other its base edge
//! there, and over a roof above the camera only its front edge leads to the other; a contour point that
//! merely touches another solid counts as visible. Ground and sky are behind everything: they need no
//! case. ∎
//!
//! So it suffices to know the nearest face at the centre of each pixel (`depth`, exact up to rounding,
//! and roundings matter only within ~1e-9 px of a contour), to know exactly which parts of which
//! contour edges are visible (`hidden`: classical hidden-line removal, not sampling), and to
//! declare Unknown every pixel that a visible part touches (`cover`: all closed squares that meet
//! the part widened by [`CONTOUR_MARGIN_PX`], so a part on a border counts for both sides).
//!
//! A contour edge changes from visible to hidden by F only where its image crosses the image of a
//! contour edge of F: the hidden part is where the triangle camera-edge cuts F, and its rim is a ray
//! that touches F with F on one side only. All such crossings (and more: superfluous ones are
//! harmless) split the edge. The middle of each piece decides for the piece, by an exact test whether
//! the segment from the camera pierces the prism by more than [`CLEARANCE_M`]; otherwise it counts as
//! visible.
//!
//! **Distance.** Along a plane, the set of rays with ρ ≤ d_max is convex in the image, so a plane
//! is within d_max on all of Q when it is at the four corners; the horizon is the same test. The
//! distance of a planar polygon is largest at a vertex, so faces without a vertex beyond d_max are
//! not tested at all; on the others every face that takes part in a pixel is tested: the one at the
//! centre, and both sides of each crease (edge between two faces that face the camera) that touches
//! the pixel. As no contour runs through a labelled pixel, there is no other way to reach a face.
//! Prisms that are entirely beyond d_max are dropped: behind one, a ray would meet the ground even
//! farther away, or the sky.
//!
//! # Pixels that are Unknown without need
//!
//! Pixels where an obstacle hides a farther part of itself (a contour with the same obstacle on
//! both sides), those within the margins above of a contour, and those at d_max where the plane of
//! a face, but not the face, leaves the sphere.
//!
//! [`Scene`]: crate::scene::Scene

mod cover;
mod depth;
mod detect;
mod hidden;
mod lens;
pub(crate) mod noise;
pub mod oracle;
mod outline;
mod reach;
mod render;

pub use render::{Classified, Renderer};

/// A visible contour makes every pixel Unknown that is at most this far from it, pixels. It absorbs
/// the rounding of projections and crossings, which is about 1e-10 px.
pub const CONTOUR_MARGIN_PX: f64 = 1e-5;

/// A prism hides a point only if the segment from the camera gets this deep into it, metres.
pub const CLEARANCE_M: f64 = 1e-7;

/// A camera nearer than this to a prism in view, above its top or beside its walls, reports Unknown
/// everywhere, metres.
pub const MIN_CLEARANCE_M: f64 = 1e-3;
