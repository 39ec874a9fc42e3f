//! The boxes of poses.

use csat_proto::camera::PoseError;

use crate::published::reference;

/// Errors of x and y of figure 6.9, metres; the others are those of u1.
pub const POSITION_M: [f64; 3] = [0.1, 1.0, 2.0];
/// r_s^to of figure 6.9, metres. The thesis does not print its own.
pub const RADII_M: [f64; 4] = [2.5, 4.0, 6.0, 8.0];

/// A box of poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Its name in the thesis; `exact` for no box.
    pub name: String,
    /// Its half-widths.
    pub error: PoseError,
}

/// The exact pose, then the four boxes of §6.6.1.
pub fn uncertainties() -> Vec<Uncertainty> {
    let published = reference().chapter6;
    let boxes = [published.u1, published.u2, published.u3, published.u4];
    let exact = Uncertainty { name: "exact".to_owned(), error: PoseError::NONE };
    let named = (1..).zip(boxes).map(|(number, widths)| Uncertainty {
        name: format!("u{number}"),
        error: half_widths(widths),
    });
    std::iter::once(exact).chain(named).collect()
}

/// Half-widths from metres and degrees: x, y, z, roll, pitch, yaw.
pub fn half_widths([x, y, z, roll, pitch, yaw]: [f64; 6]) -> PoseError {
    PoseError {
        p_world: [x, y, z],
        yaw_rad: yaw.to_radians(),
        pitch_rad: pitch.to_radians(),
        roll_rad: roll.to_radians(),
    }
}
