"""The thesis's literal method of sensing, on the frames of a folder that the example `literal` wrote.

One quadrangle per Ground pixel (4.6), the intersection of the discs about the corners of one pyramid
per Obstacle pixel (4.7), the dilated hull of one pyramid per Target pixel (4.4), each united by
shapely (GEOS): what this project does with outlines and a memory of what was measured. Prints times,
their ratios, and that both methods mean the same sets.

Usage: python3 literal.py FOLDER        (needs numpy and shapely 2)
"""

import functools
import json
import sys
import time
from pathlib import Path

import numpy as np
import shapely

GROUND, OBSTACLE, TARGET = 1, 2, 3
# Corners of the polygons that stand for discs: four times this.
QUAD_SEGS = 4


class Frame:
    def __init__(self, path):
        self.__dict__.update(json.loads(path.read_text()))
        shape = (self.rows, self.columns)
        self.labels = np.fromfile(path.with_suffix(".labels"), np.uint8).reshape(shape)
        self.depth = np.fromfile(path.with_suffix(".depth"), np.uint16).reshape(shape)
        self.matrix = np.array(self.ray_matrix)
        self.centre = np.array(self.centre_world)
        half_x, half_y = (side / 2 for side in self.ground_m)
        self.region = shapely.box(-half_x, -half_y, half_x, half_y)

    def rays(self, columns, rows):
        """Directions in `world` of the rays through image points, shape (n, 3)."""
        return np.stack([columns, rows, np.ones_like(columns)], -1) @ self.matrix.T

    def corners(self, pixels):
        """The image points of the corners of `pixels` (n, 2: row, column), shape (n, 4) each."""
        columns = pixels[:, 1, None] + np.array([0.0, 1.0, 1.0, 0.0])
        rows = pixels[:, 0, None] + np.array([0.0, 0.0, 1.0, 1.0])
        return columns, rows

    def quadrangles(self):
        """The ground seen by each Ground pixel."""
        columns, rows = self.corners(np.argwhere(self.labels == GROUND))
        rays = self.rays(columns, rows)
        ground = self.centre[:2] + rays[..., :2] * (-self.centre[2] / rays[..., 2:])
        return shapely.polygons(ground)

    def pyramids(self, pixels):
        """The ground projections of the 8 corners of each pixel's pyramid (A.2, A.3): (n, 8, 2)."""
        depth = self.depth[pixels[:, 0], pixels[:, 1]].astype(float)
        low, high = self.depth_noise
        near = ((depth - 0.5) * self.depth_step_m / (1 + high))[:, None, None]
        far = ((depth + 0.5) * self.depth_step_m / (1 + low))[:, None, None]
        unit = lambda v: v / np.linalg.norm(v, axis=-1, keepdims=True)
        rays = unit(self.rays(*self.corners(pixels)))
        middle = unit(self.rays(pixels[:, 1] + 0.5, pixels[:, 0] + 0.5))[:, None, :]
        stretch = 1 / (rays * middle).sum(-1, keepdims=True)
        ends = np.concatenate([rays * near, rays * far * stretch], axis=1)
        return self.centre[:2] + ends[..., :2]

    def margins(self):
        """Per Obstacle pixel, the ground within r_s of all that may have lit it."""
        points = self.pyramids(np.argwhere(self.labels == OBSTACLE))
        radius_m = self.obstacle_distance_m
        discs = shapely.buffer(shapely.points(points), radius_m, quad_segs=QUAD_SEGS)
        return functools.reduce(shapely.intersection, discs.T)

    def targets(self):
        """Per detection, the dilated pyramids of the Target pixels in its box."""
        found = []
        for box in self.detections:
            (left, right), (top, bottom) = box["columns"], box["rows"]
            inside = self.labels[top : bottom + 1, left : right + 1] == TARGET
            points = self.pyramids(np.argwhere(inside) + [top, left])
            hulls = shapely.convex_hull(shapely.multipoints(points))
            found.append(shapely.buffer(hulls, self.target_radius_m, quad_segs=QUAD_SEGS))
        return found


def region(shapes):
    """A set as this project writes it."""
    return shapely.union_all([shapely.Polygon(rings[0], rings[1:]) for rings in shapes])


def timed(work):
    start = time.perf_counter()
    result = work()
    return result, time.perf_counter() - start


def compare(frame):
    quadrangles, make_s = timed(frame.quadrangles)
    ground, union_s = timed(lambda: shapely.union_all(quadrangles))
    _, coverage_s = timed(lambda: shapely.coverage_union_all(quadrangles))
    margin, margin_s = timed(lambda: shapely.union_all(frame.margins()))
    targets, targets_s = timed(lambda: [shapely.union_all(hulls) for hulls in frame.targets()])
    first_ms, flying_ms = frame.ours["first_frame_ms"], frame.ours["in_flight_ms"]
    rows = [
        ("Ground quadrangles, `union_all`", union_s),
        ("Ground quadrangles, `coverage_union_all`", coverage_s),
        ("everything: quadrangles, margins, targets, `union_all`",
         make_s + union_s + margin_s + targets_s),
    ]
    counts = [int((frame.labels == label).sum()) for label in (GROUND, OBSTACLE, TARGET)]
    print(f"\n`{frame.name}`: {counts[0]} Ground, {counts[1]} Obstacle and {counts[2]} Target pixels; "
          f"our sensing, all of it: {flying_ms:.2f} ms in flight, {first_ms:.2f} ms if it is the "
          "first frame\n")
    print("| literal method, shapely " + shapely.__version__ + ", GEOS " + shapely.geos_version_string
          + " | s | times our time in flight | times our time on a first frame |")
    print("|---|---:|---:|---:|")
    for name, seconds in rows:
        ratios = (1e3 * seconds / ms for ms in (flying_ms, first_ms))
        print(f"| {name} | {seconds:.2f} | {' | '.join(f'{ratio:.0f}' for ratio in ratios)} |")
    agree(frame, "clear ground", region(frame.ours["clear_ground"]), ground & frame.region)
    agree(frame, "obstacle margin", region(frame.ours["obstacle_margin"]), margin & frame.region)
    for ours, theirs in zip(frame.ours["targets"], targets):
        agree(frame, "the literal set of a target", theirs & frame.region, region(ours))


def agree(frame, name, inner, outer):
    """Ours is the tighter promise: inner sets lie in the literal ones, outer sets contain them."""
    outside_m2 = (inner - outer.buffer(0.01)).area
    print(f"\n{name}: {inner.area:.0f} m² of {outer.area:.0f} m², {outside_m2:.2f} m² outside")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for path in sorted(Path(sys.argv[1]).glob("*.json")):
        compare(Frame(path))
