"""Stone Soup's particle filter on a recording of `agent/bayes/examples/replay.rs`.

Usage: python filter.py FILE [PARTICLES]                       (needs stonesoup; bench/stonesoup.sh makes an environment)
       replay likelihood FILE | python filter.py FILE check     compares the likelihoods

Predictor, updater and resampler are Stone Soup's; the measurement model is csat's likelihood (agent/bayes/src/
likelihood.rs) in numpy, for all particles at once, so that two filters are compared and not two models. Prints a line
of JSON like `replay filter`. An update is what a frame costs: prediction, likelihood and correction. Updates are those
of a second of processor time, mean of three runs over all frames; one more run measures errors.
"""

import csv
import json
import math
import os
import sys
import time
from datetime import datetime, timedelta

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from stonesoup.base import Property
from stonesoup.models.measurement.base import MeasurementModel
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, RandomWalk
from stonesoup.predictor.particle import ParticlePredictor
from stonesoup.resampler.particle import SystematicResampler
from stonesoup.types.array import StateVectors
from stonesoup.types.detection import Detection
from stonesoup.types.hypothesis import SingleHypothesis
from stonesoup.types.state import ParticleState
from stonesoup.updater.particle import ParticleUpdater

PERIOD_S, RUNS = 0.25, 3
SIDE_M = 1000.0
SIGMA = (10.5, 5.5, 5.5, 0.01, 0.05, 0.02)
COLUMNS, ROWS, APERTURE = 640.0, 480.0, math.radians(49.3)
SIZE = np.array([COLUMNS, ROWS])
FOCAL = COLUMNS / (2.0 * math.tan(APERTURE / 2.0))
P_DETECTION, P_FALSE = 0.96, 0.004
DETECTED, MISSED = (60.0, 40.06), (60.0, 62.03)
EDGE_SIGMAS, DETECTION_SIGMAS, ROOM, LEAST = 4.5, 6.0, 1.25, 1e-12
TABLE = 64
NODES = np.array([0.0, 1.355626179974266, -1.355626179974266, 2.856970013872806, -2.856970013872806])
WEIGHTS = np.array([0.5333333333333333, 0.22207592200561264, 0.22207592200561264, 0.01125741132772069,
                    0.01125741132772069])
BODY_TO_CAMERA = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def p_detected(resolution):
    """(6)."""
    exponent = lambda m: (resolution - m[0]) ** 2 / (2.0 * m[1])
    prior = (1.0 - P_DETECTION) / P_DETECTION * math.sqrt(DETECTED[1] / MISSED[1])
    return 1.0 / (1.0 + prior * np.exp(np.minimum(exponent(DETECTED) - exponent(MISSED), 700.0)))


def phi(t):
    return 1.0 / (1.0 + np.exp(np.clip(-t * (1.5976 + 0.070566 * t * t), -700.0, 700.0)))


def turn(yaw, pitch, roll):
    """The rotation from `body` to `world`."""
    (sy, cy), (sp, cp), (sr, cr) = ((math.sin(a), math.cos(a)) for a in (yaw, pitch, roll))
    return (np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
            @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]]))


class Frame(MeasurementModel):
    """The likelihood of a frame: that of `csat_bayes::likelihood::Likelihood`."""
    pose: tuple = Property(doc="x, y, z; yaw, pitch, roll, as reported")
    sighting: tuple = Property(default=None, doc="Image point of the detection, or None")

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        x, y, z, yaw, pitch, roll = self.pose
        self.position, self.height = np.array([x, y, z]), z
        to_camera = BODY_TO_CAMERA @ turn(yaw, pitch, roll).T
        self.to_world = to_camera.T
        self.axes = to_camera @ -self.position, to_camera[:, 0], to_camera[:, 1]
        ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        left = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
        up = np.array([0.0, 0.0, 1.0])
        nose = turn(yaw, pitch, 0.0)[:, 0]
        self.shifts = [to_camera @ axis * s for axis, s in zip((ahead, left, up), SIGMA)]
        self.turns = [to_camera @ axis * s for axis, s in zip((up, left, nose), SIGMA[3:])]
        self.make_table()
        if self.sighting is None:
            self.bounds = self.ground_box(np.zeros(2), SIZE, EDGE_SIGMAS)
        else:
            self.sighting = np.asarray(self.sighting, dtype=float)
            self.gain = self.table_at(self.inverse_depth(self.sighting)) * COLUMNS * ROWS / P_FALSE
            self.bounds = self.ground_box(self.sighting, self.sighting, DETECTION_SIGMAS)

    @property
    def ndim_meas(self):
        return 2

    def function(self, state, noise=False, **kwargs):
        raise NotImplementedError

    def rvs(self, num_samples=1, **kwargs):
        raise NotImplementedError

    def pdf(self, state1, state2, **kwargs):
        return np.exp(self.logpdf(state1, state2, **kwargs))

    def logpdf(self, state1, state2, **kwargs):
        """ln p(z | x), less its constant elsewhere, of every particle; 0 outside of a rectangle."""
        points = np.asarray(state2.state_vector)
        low, high = self.bounds
        x, y = points
        inside = np.flatnonzero((x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1]))
        result = np.zeros(points.shape[1])
        if not len(inside):
            return result
        mean, covariance, inverse_depth = self.see(x[inside], y[inside])
        cc, cr, rr = covariance
        if self.sighting is None:
            inside_image = self.p_along(mean[0], cc, COLUMNS) * self.p_along(mean[1], rr, ROWS)
            p = inside_image * self.table_at(inverse_depth)
            result[inside] = np.log(np.maximum(1.0 - p / (1.0 - P_FALSE), LEAST))
        else:
            c, r = self.sighting[0] - mean[0], self.sighting[1] - mean[1]
            determinant = cc * rr - cr * cr
            distance = (rr * c * c - 2.0 * cr * c * r + cc * r * r) / determinant
            density = np.exp(-0.5 * distance) / (2.0 * math.pi * np.sqrt(determinant))
            result[inside] = np.log1p(density * self.gain)
        return result

    @staticmethod
    def p_along(mean, variance, size):
        inverse = 1.0 / np.maximum(np.sqrt(variance), 1e-3)
        return np.maximum(phi((size - mean) * inverse) - phi(-mean * inverse), 0.0)

    def see(self, x, y):
        """Mean and covariance of the image of ground points, and 1/z. No point here is behind the camera."""
        (ox, oy, oz), (ex, ey, ez), (nx, ny, nz) = self.axes
        px, py, pz = ox + x * ex + y * nx, oy + x * ey + y * ny, oz + x * ez + y * nz
        inverse_depth = 1.0 / pz
        scale = FOCAL * inverse_depth
        u, v = px * inverse_depth, py * inverse_depth
        cc = cr = rr = 0.0
        for dx, dy, dz in self.shifts:
            dc, dr = dx - u * dz, dy - v * dz
            cc, cr, rr = cc + dc * dc, cr + dc * dr, rr + dr * dr
        for ax, ay, az in self.turns:
            dz = ax * py - ay * px
            dc, dr = ay * pz - az * py - u * dz, az * px - ax * pz - v * dz
            cc, cr, rr = cc + dc * dc, cr + dc * dr, rr + dr * dr
        square = scale * scale
        return (COLUMNS / 2.0 - FOCAL * u, ROWS / 2.0 - FOCAL * v), (cc * square, cr * square, rr * square), inverse_depth

    def ray(self, point):
        c, r = point
        return self.to_world @ np.array([(COLUMNS / 2.0 - c) / FOCAL, (ROWS / 2.0 - r) / FOCAL, 1.0])

    def inverse_depth(self, point):
        return -self.ray(point)[2] / self.height

    def make_table(self):
        """p(D | V, r) over the inverse depth, the errors of the pose averaged out."""
        corners = [(-0.5, -0.5), (1.5, -0.5), (1.5, 1.5), (-0.5, 1.5)]
        depths = [max(self.inverse_depth((i * COLUMNS, j * ROWS)), 1e-6) for i, j in corners]
        self.first = min(depths)
        step = (max(max(depths), self.first + 1e-9) - self.first) / (TABLE - 1)
        centre = self.inverse_depth(SIZE / 2.0)
        sigma = 0.0
        if centre > 0.0:
            p = np.array([0.0, 0.0, 1.0 / centre])
            derivatives = self.shifts + [np.cross(axis, p) for axis in self.turns]
            of_height = [np.linalg.norm(d) / self.height if i == 2 else 0.0 for i, d in enumerate(derivatives)]
            sigma = math.sqrt(sum((h + 3.0 * d[2] * centre) ** 2 for h, d in zip(of_height, derivatives)))
        inverse = self.first + np.arange(TABLE) * step
        resolution = FOCAL ** 2 * self.height * inverse ** 3
        self.values = WEIGHTS @ p_detected(resolution * np.exp(sigma * NODES)[:, None])
        self.inverses = inverse

    def table_at(self, inverse_depth):
        return np.interp(inverse_depth, self.inverses, self.values)

    def ground_box(self, low, high, sigmas):
        everywhere = np.array([-SIDE_M / 2.0] * 2), np.array([SIDE_M / 2.0] * 2)

        def corners(low, high):
            points = (low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])
            rays = [self.ray(point) for point in points]
            if any(ray[2] > -1e-12 for ray in rays):
                return None
            return np.array([self.position[:2] - self.height / ray[2] * ray[:2] for ray in rays])

        ground = corners(low, high)
        if ground is None:
            return everywhere
        (_, (cc, _, rr), _) = self.see(*ground.T)
        margin = sigmas * ROOM * np.array([math.sqrt(cc.max()), math.sqrt(rr.max())])
        ground = corners(low - margin, high + margin)
        return everywhere if ground is None else (ground.min(axis=0), ground.max(axis=0))


def read(file):
    with open(file) as rows:
        rows = list(csv.DictReader(rows))
    single = lambda row, *keys: tuple(float(np.float32(row[key])) for key in keys)
    frames = [(int(row["step"]), single(row, "x_m", "y_m", "z_m", "yaw_rad", "pitch_rad", "roll_rad"),
               single(row, "c_px", "r_px") if row["c_px"] else None) for row in rows]
    target = np.array([float(rows[0]["target_x_m"]), float(rows[0]["target_y_m"])])
    return frames, target, [row["detected"] == "1" for row in rows]


def run(frames, particles, after=lambda state: None):
    """All frames through Stone Soup's filter."""
    begin = datetime(2026, 1, 1)
    # 1 m² per step, like csat.
    walk = CombinedLinearGaussianTransitionModel([RandomWalk(1.0 / PERIOD_S), RandomWalk(1.0 / PERIOD_S)])
    predictor = ParticlePredictor(walk)
    updater = ParticleUpdater(None, resampler=SystematicResampler())
    points = np.random.uniform(-SIDE_M / 2.0, SIDE_M / 2.0, (2, particles))
    state = ParticleState(StateVectors(points), weight=np.full(particles, 1.0 / particles), timestamp=begin)
    for step, pose, sighting in frames:
        now = begin + timedelta(seconds=step * PERIOD_S)
        prediction = predictor.predict(state, timestamp=now)
        model = Frame(2, (0, 1), pose, sighting)
        detection = Detection(np.zeros((2, 1)), timestamp=now, measurement_model=model)
        state = updater.update(SingleHypothesis(prediction, detection))
        after(state)
    return state


def check(frames, target):
    """csat's likelihoods come from the standard input."""
    offsets = 20.0 * np.arange(5) - 40.0
    points = np.array([(target[0] + i, target[1] + j) for j in offsets for i in offsets]).T
    worst = 0.0
    for (_, pose, sighting), line in zip(frames, sys.stdin, strict=True):
        ours = Frame(2, (0, 1), pose, sighting).logpdf(None, ParticleState(StateVectors(points)))
        theirs = np.array([float(value) for value in line.split(",")])
        worst = max(worst, float(np.abs(ours - theirs).max()))
    print(f"greatest difference of ln of a likelihood: {worst:.1e}", file=sys.stderr)
    if not worst < 1e-6:
        sys.exit("the likelihoods differ")


def main():
    file, particles = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "6400"
    frames, target, detected = read(file)
    if particles == "check":
        return check(frames, target)
    particles = int(particles)
    np.random.seed(1)
    start = time.process_time()
    for _ in range(RUNS):
        run(frames, particles)
    seconds = (time.process_time() - start) / RUNS
    errors, sigmas = [], []

    def measure(state):
        # After resampling all weights are equal.
        points = np.asarray(state.state_vector)
        errors.append(np.hypot(*(points.mean(axis=1) - target)))
        sigmas.append(math.sqrt(points.var(axis=1).sum()))

    run(frames, particles, measure)
    after = np.array(errors[detected.index(True):])
    print(json.dumps({
        "filter": f"stonesoup-{particles}", "frames": len(frames), "detections": sum(detected),
        "updates_per_s": round(len(frames) / seconds, 1), "error_m": round(float(errors[-1]), 3),
        "sigma_m": round(sigmas[-1], 3), "rmse_m": round(float(np.sqrt((after ** 2).mean())), 3)}))


if __name__ == "__main__":
    main()
