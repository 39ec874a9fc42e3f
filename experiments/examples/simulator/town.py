"""What world.py simulates: a town of boxes, a car, a UAV, and what a camera sees of it.

This is the part to replace by a simulator of one's own.
"""

import itertools

import numpy as np

UNKNOWN, GROUND, OBSTACLE, TARGET = 0, 1, 2, 3

# Lower and upper corner of each building, metres east, north and up of the middle of the region.
BUILDINGS = [
    ([-50.0, 25.0, 0.0], [-20.0, 55.0, 12.0]),
    ([5.0, 20.0, 0.0], [40.0, 50.0, 20.0]),
    ([-60.0, -50.0, 0.0], [-25.0, -15.0, 15.0]),
    ([35.0, -45.0, 0.0], [70.0, -10.0, 30.0]),
]

# Half the length and width of the car and its height, metres; it fits into the cylinder of [targets].
CAR_HALF_M, CAR_HEIGHT_M = np.array([2.3, 0.9]), 1.5


def car_at(seconds):
    """The car drives to and fro on a street along y = 4, slower than v_max, more than r_s^to (2.5 m)
    from every wall: the agent relies on both."""
    metres = (0.8 * seconds) % 80
    return np.array([min(metres, 80 - metres) - 30, 4.0])


def bodies(car):
    """All there is: (label, lower corner, upper corner), the car last."""
    town = [(OBSTACLE, np.array(lower), np.array(upper)) for lower, upper in BUILDINGS]
    lower, upper = np.append(car - CAR_HALF_M, 0.0), np.append(car + CAR_HALF_M, CAR_HEIGHT_M)
    return [*town, (TARGET, lower, upper)]


class Uav:
    """Constant speed and altitude; the yaw follows the command as in world/src/uav.rs."""

    DAMPING, SETTLING = 0.7, 2.9

    def __init__(self, model, size_m):
        self.position = np.array([-size_m[0] / 2 - model["start_offset_m"], 0.0, model["altitude_m"]])
        self.yaw = self.rate = self.command = 0.0
        self.speed, self.omega = model["speed_m_s"], self.SETTLING / model["yaw_settling_s"]

    def advance(self, seconds, h=1e-3):
        for _ in range(round(seconds / h)):
            error = self.command - self.yaw
            self.rate += h * self.omega * (self.omega * error - 2 * self.DAMPING * self.rate)
            self.yaw += h * self.rate
            self.position[:2] += h * self.speed * np.array([np.cos(self.yaw), np.sin(self.yaw)])


class Camera:
    """The pinhole camera of proto/src/camera.rs and a renderer that obeys Assumption 4.

    Assumption 4: a pixel is labelled Ground, Obstacle or Target only if *every* ray through it meets
    the ground, one obstacle, or one target first. No number of sampled rays shows that: a corner of a
    roof can poke into a pixel between them. But all bodies here are convex, and so is the cone of
    the rays that meet one. Hence, without sampling: all rays of a pixel meet a body if those of its
    four corners do, and none does if one side of the cone has all four corners on its outside.
    """

    # The sine of an angle that outweighs all rounding.
    MARGIN = 1e-6

    def __init__(self, model):
        self.model, self.columns, self.rows = model, model["columns"], model["rows"]
        self.focal_px = self.columns / (2 * np.tan(np.radians(model["aperture_deg"]) / 2))
        s, c = np.sin(np.radians(model["tilt_deg"])), np.cos(np.radians(model["tilt_deg"]))
        axes = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]])
        self.camera_from_body = axes @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])

    def rays(self, columns, rows, yaw):
        """Unit vectors in `world` through image points. The image is upside down, as on a sensor:
        row 0 looks at the nearest ground, column 0 to the right."""
        column, row = np.meshgrid(columns, rows)
        x, y = (self.columns / 2 - column) / self.focal_px, (self.rows / 2 - row) / self.focal_px
        s, c = np.sin(yaw), np.cos(yaw)
        world_from_body = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        world_from_camera = world_from_body @ self.camera_from_body.T
        rays = np.stack([x, y, np.ones_like(x)], -1) @ world_from_camera.T
        return rays / np.linalg.norm(rays, axis=-1, keepdims=True)

    def frame(self, eye, yaw, bodies, rng):
        """Labels, quantised depths, and the box of pixels of each body, `None` unless it is a target
        that is seen well enough. Bodies must not touch each other nor rise to the camera."""
        corners = self.rays(np.arange(self.columns + 1), np.arange(self.rows + 1), yaw)
        centres = self.rays(np.arange(self.columns) + 0.5, np.arange(self.rows) + 0.5, yaw)
        with np.errstate(divide="ignore", invalid="ignore"):
            ground_m = np.where(corners[..., 2] < 0, -eye[2] / corners[..., 2], np.inf)
        # What stands on the ground is nearer than the ground behind it; noise may add to that.
        d_max_m, noise = self.model["d_max_m"], self.model["depth_noise"]
        is_near = of_pixels(ground_m <= d_max_m / (1 + max(noise[1], 0)))
        sines = [corners @ cone(lower - eye, upper - eye).T for _, lower, upper in bodies]
        covers = [of_pixels((sine < -self.MARGIN).all(-1)) for sine in sines]
        touches = [~of_pixels(sine > self.MARGIN).any(-1) for sine in sines]

        labels = np.where(is_near, GROUND, UNKNOWN).astype(np.uint32)
        labels[np.any(touches, axis=0)] = UNKNOWN
        depth_m, boxes = np.zeros(labels.shape), []
        for index, (label, *box) in enumerate(bodies):
            seen = covers[index] & is_near
            for other, (_, *other_box) in enumerate(bodies):
                if other != index and not is_before(box, other_box, eye):
                    seen &= ~touches[other]
            labels[seen] = label
            # The distance along some ray of the pixel: here the one through its centre.
            with np.errstate(divide="ignore"):
                slabs = np.stack([(corner - eye) / centres[seen] for corner in box])
            depth_m[seen] = slabs.min(0).max(-1)
            is_identified = label == TARGET and seen.sum() >= self.model["min_pixels"]
            boxes.append(box_of(seen) if is_identified else None)
        noisy_m = depth_m * (1 + rng.uniform(*noise, labels.shape))
        return labels, np.rint(noisy_m / (d_max_m / 65535)).astype(np.uint16), boxes


def of_pixels(c):
    """What holds at all four corners of each pixel."""
    return c[:-1, :-1] & c[1:, :-1] & c[:-1, 1:] & c[1:, 1:]


def box_of(pixels):
    """The box around some pixels, bounds inclusive."""
    rows, columns = np.nonzero(pixels)
    return {"columns": [int(columns.min()), int(columns.max())], "rows": [int(rows.min()), int(rows.max())]}


def cone(lower, upper):
    """The outward normals of the sides of the cone of all rays from the origin that meet a box: of
    all planes through two of its corners, those with no corner on the other side."""
    corners = np.array(list(itertools.product(*zip(lower, upper))))
    corners /= np.linalg.norm(corners, axis=1, keepdims=True)
    normals = np.cross(corners[:, None], corners[None]).reshape(-1, 3)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = (normals / np.maximum(lengths, 1e-9))[lengths[:, 0] > 1e-9]
    return normals[(normals @ corners.T <= 1e-9).all(1)]


def is_before(a, b, eye):
    """Whether box `a` comes first on every ray that meets both: it does if a plane is between them
    and the camera on its side."""
    is_below, is_above = a[1] < b[0], a[0] > b[1]
    return bool((is_below & (eye <= b[0]) | is_above & (eye >= b[1])).any())
