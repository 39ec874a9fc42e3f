//! Differences of grid points, and exact turns of paths.

use csat_proto::region::GridPoint;

/// A difference of grid points, grid units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Vector {
    pub(crate) x: i64,
    pub(crate) y: i64,
}

impl Vector {
    /// b − a.
    pub(crate) fn between(a: GridPoint, b: GridPoint) -> Self {
        Self { x: i64::from(b.x) - i64::from(a.x), y: i64::from(b.y) - i64::from(a.y) }
    }

    /// The z component of self × other: positive if `other` points to the left.
    pub(crate) fn cross(self, other: Self) -> i128 {
        i128::from(self.x) * i128::from(other.y) - i128::from(self.y) * i128::from(other.x)
    }

    /// self · other.
    pub(crate) fn dot(self, other: Self) -> i128 {
        i128::from(self.x) * i128::from(other.x) + i128::from(self.y) * i128::from(other.y)
    }

    /// The vector turned to the right: the normal of an edge, away from the set on its left.
    pub(crate) fn outward(self) -> Self {
        Self { x: self.y, y: -self.x }
    }

    /// Its length, grid units.
    pub(crate) fn length(self) -> f64 {
        (self.x as f64).hypot(self.y as f64)
    }
}

/// Twice the signed area of the triangle (a, b, c): positive if the path a → b → c turns to the left,
/// 0 if it goes straight on or back.
pub(crate) fn turn(a: GridPoint, b: GridPoint, c: GridPoint) -> i128 {
    Vector::between(a, b).cross(Vector::between(b, c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_corners_of_the_grid_do_not_overflow() {
        let [west, east, north] =
            [(i32::MIN, i32::MIN), (i32::MAX, i32::MIN), (i32::MAX, i32::MAX)]
                .map(|(x, y)| GridPoint::new(x, y));
        let side = i128::from(u32::MAX);
        assert_eq!(turn(west, east, north), side * side);
        assert_eq!(turn(north, east, west), -side * side);
        assert_eq!(turn(west, north, west), 0);
        let (along, up) = (Vector::between(west, east), Vector::between(east, north));
        assert_eq!([along.dot(along), along.dot(up)], [side * side, 0]);
        assert_eq!(up.outward(), along);
        assert_eq!(along.length(), u32::MAX.into());
    }
}
