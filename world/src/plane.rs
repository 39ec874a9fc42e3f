//! Exact distances between points and segments of the ground, `world`, metres.

/// A point of the ground, `world`, metres.
pub(crate) type Point = [f64; 2];

/// a − b.
pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// a + t (b − a).
pub(crate) fn between(a: Point, b: Point, t: f64) -> Point {
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

/// The z component of a × b.
pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// a · b.
pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// |a − b|, metres.
pub(crate) fn distance_m(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Distance from `p` to the segment from `a` to `b`, metres.
pub(crate) fn distance_to_segment_m(p: Point, a: Point, b: Point) -> f64 {
    let (d, v) = (minus(b, a), minus(p, a));
    let length2 = dot(d, d);
    let t = if length2 > 0.0 { (dot(v, d) / length2).clamp(0.0, 1.0) } else { 0.0 };
    distance_m(p, between(a, b, t))
}

/// The parameters t in [0, 1] for which `p + t (q − p)` is within `radius` of the segment from `a`
/// to `b`. They are one interval, since the points within a radius of a segment form a convex set: two
/// discs and a rectangle.
pub(crate) fn interval_near_segment(
    [p, q]: [Point; 2],
    [a, b]: [Point; 2],
    radius: f64,
) -> Option<[f64; 2]> {
    let d = minus(q, p);
    let ab = minus(b, a);
    let length = dot(ab, ab).sqrt();
    let strip = if length > 0.0 {
        let u = [ab[0] / length, ab[1] / length];
        let local = |v: Point| [dot(u, v), cross(u, v)];
        interval_in_box(local(minus(p, a)), local(d), [0.0, -radius], [length, radius])
    } else {
        None
    };
    let parts = [interval_in_disc(p, d, a, radius), interval_in_disc(p, d, b, radius), strip];
    let hull = parts.into_iter().flatten().reduce(|x, y| [x[0].min(y[0]), x[1].max(y[1])])?;
    let clamped = [hull[0].max(0.0), hull[1].min(1.0)];
    (clamped[0] <= clamped[1]).then_some(clamped)
}

/// The parameters t for which `p + t d` is within `radius` of `centre`.
fn interval_in_disc(p: Point, d: Point, centre: Point, radius: f64) -> Option<[f64; 2]> {
    let v = minus(p, centre);
    let (a, b, c) = (dot(d, d), dot(v, d), dot(v, v) - radius * radius);
    if a <= 0.0 {
        return (c <= 0.0).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let discriminant = b * b - a * c;
    (discriminant >= 0.0).then(|| {
        let root = discriminant.sqrt();
        [(-b - root) / a, (-b + root) / a]
    })
}

/// The parameters t for which `p + t d` lies in the box from `min` to `max`.
pub(crate) fn interval_in_box(p: Point, d: Point, min: Point, max: Point) -> Option<[f64; 2]> {
    let mut interval = [f64::NEG_INFINITY, f64::INFINITY];
    for axis in 0..2 {
        if d[axis] == 0.0 {
            if p[axis] < min[axis] || p[axis] > max[axis] {
                return None;
            }
            continue;
        }
        let (near, far) = ((min[axis] - p[axis]) / d[axis], (max[axis] - p[axis]) / d[axis]);
        interval = [interval[0].max(near.min(far)), interval[1].min(near.max(far))];
    }
    (interval[0] <= interval[1]).then_some(interval)
}

/// The parameters (s, t) at which `p + s (q − p)` and `a + t (b − a)` meet, when the segments cross
/// or touch in one point; `None` when they miss each other or are parallel.
pub(crate) fn crossing([p, q]: [Point; 2], [a, b]: [Point; 2]) -> Option<[f64; 2]> {
    let (d, e, v) = (minus(q, p), minus(b, a), minus(a, p));
    let denominator = cross(d, e);
    if denominator.abs() <= 1e-12 * (dot(d, d) * dot(e, e)).sqrt() {
        return None;
    }
    let (s, t) = (cross(v, e) / denominator, cross(v, d) / denominator);
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some([s, t])
}

/// Distance between the segments `[p, q]` and `[a, b]`, metres; 0 where they meet.
pub(crate) fn segment_distance_m([p, q]: [Point; 2], [a, b]: [Point; 2]) -> f64 {
    if crossing([p, q], [a, b]).is_some() {
        return 0.0;
    }
    // The distance of segments that do not cross is attained at an end of one of them.
    let ends = [
        distance_to_segment_m(p, a, b),
        distance_to_segment_m(q, a, b),
        distance_to_segment_m(a, p, q),
        distance_to_segment_m(b, p, q),
    ];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

/// An axis-aligned box, bounds inclusive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub min: Point,
    pub max: Point,
}

impl Bounds {
    /// The smallest box around `points`; `None` when there are none.
    pub fn around(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        let start = Self { min: first, max: first };
        Some(points.fold(start, |b, p| Self {
            min: [b.min[0].min(p[0]), b.min[1].min(p[1])],
            max: [b.max[0].max(p[0]), b.max[1].max(p[1])],
        }))
    }

    /// The box grown by `margin_m` on every side.
    pub fn grown(self, margin_m: f64) -> Self {
        Self { min: self.min.map(|x| x - margin_m), max: self.max.map(|x| x + margin_m) }
    }

    /// Whether two boxes share a point.
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|i| self.min[i] <= other.max[i] && other.min[i] <= self.max[i])
    }

    /// Whether the box contains a point.
    pub fn contains(&self, p: Point) -> bool {
        (0..2).all(|i| self.min[i] <= p[i] && p[i] <= self.max[i])
    }

    /// max − min, metres.
    pub fn size_m(&self) -> [f64; 2] {
        minus(self.max, self.min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point> {
        [-20.0..20.0f64, -20.0..20.0f64]
    }

    proptest! {
        #[test]
        fn the_interval_is_where_the_distance_is_small(
            p in point(), q in point(), a in point(), b in point(), radius in 0.1..6.0f64,
        ) {
            let interval = interval_near_segment([p, q], [a, b], radius);
            for i in 0..=200 {
                let t = f64::from(i) / 200.0;
                let distance = distance_to_segment_m(between(p, q, t), a, b);
                let inside = interval.is_some_and(|[lo, hi]| lo <= t && t <= hi);
                // On the border either answer is right.
                if (distance - radius).abs() > 1e-9 {
                    prop_assert_eq!(inside, distance < radius, "t {} distance {}", t, distance);
                }
            }
        }

        #[test]
        fn crossings_lie_on_both_segments(
            p in point(), q in point(), a in point(), b in point(),
        ) {
            match crossing([p, q], [a, b]) {
                Some([s, t]) => {
                    prop_assert!(distance_m(between(p, q, s), between(a, b, t)) < 1e-6);
                }
                None => {
                    let side = |x, y, z| cross(minus(y, x), minus(z, x)).signum();
                    let apart = side(p, q, a) == side(p, q, b) || side(a, b, p) == side(a, b, q);
                    prop_assert!(apart);
                }
            }
        }
    }

    #[test]
    fn segments_are_as_far_apart_as_their_nearest_points() {
        let across = [[0.0, -1.0], [0.0, 1.0]];
        assert_eq!(segment_distance_m([[-1.0, 0.0], [1.0, 0.0]], across), 0.0);
        assert_eq!(segment_distance_m([[2.0, 0.0], [5.0, 0.0]], across), 2.0);
        assert_eq!(segment_distance_m([[3.0, 5.0]; 2], across), 5.0);
        assert_eq!(segment_distance_m([[1.0, -9.0], [1.0, 9.0]], across), 1.0);
    }

    #[test]
    fn degenerate_segments_are_points() {
        assert_eq!(distance_to_segment_m([3.0, 4.0], [0.0, 0.0], [0.0, 0.0]), 5.0);
        let point = [[1.0, 0.0]; 2];
        assert_eq!(interval_near_segment(point, [[0.0, 0.0]; 2], 2.0), Some([0.0, 1.0]));
        assert_eq!(interval_near_segment(point, [[0.0, 0.0]; 2], 0.5), None);
    }
}
