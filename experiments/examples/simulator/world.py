#!/usr/bin/env python3
"""A simulator that is not csat's plays the world for one UAV: docs/simulator.md in Python.

    pip install eclipse-zenoh==1.10.2 numpy          # Python 3.11 or newer
    python3 world.py --steps 120 &
    csat agent --id 0

Time is lockstep; the town and the camera are in town.py.
"""

import argparse
import json
import queue
import secrets
import sys
import time
import tomllib

import numpy as np
import town
import zenoh

PROTOCOL = 4
JSON = zenoh.Encoding.APPLICATION_JSON

# What it does not say is as in csat's `city`. Any scenario.resolved.toml with one UAV will do as well.
SCENARIO = """
seed = 7
run = { period_s = 0.5 }
map = { size_m = [200.0, 200.0] }
targets = { count = 1, v_max_m_s = 1.0, obstacle_distance_m = 2.5 }
agents = { count = 1, speed_m_s = 5.0, altitude_m = 52.0, start_offset_m = 10.0, yaw_settling_s = 1.2 }

[camera]
columns = 160
rows = 120
aperture_deg = 45.0
tilt_deg = 30.0
d_max_m = 300.0
depth_noise = [-0.01, 0.01]
min_pixels = 2
"""


class Trouble(Exception):
    """Why the flight cannot go on."""


class Wire:
    """All that is said and heard. Callbacks only queue; one loop reads."""

    def __init__(self, endpoint, welcome, patience_s):
        self.welcome, self.patience_s, self.process = welcome, patience_s, None
        self.mirrors, self.inbox = [], queue.SimpleQueue()
        config = zenoh.Config()
        config.insert_json5("mode", '"peer"')
        config.insert_json5("listen/endpoints", json.dumps([endpoint]))
        config.insert_json5("scouting/multicast/enabled", "false")
        self.session = zenoh.open(config)
        # First subscribe, then answer `join`: whoever comes finds everything in place.
        names = ["uav/0/ready", "uav/0/command", "uav/0/report", "view/0/targets", "view/0/unexplored"]
        self.declared = [self.session.declare_subscriber(self.key(name), self.hearing(name)) for name in names]
        liveliness = self.session.liveliness()
        self.declared += [
            liveliness.declare_subscriber(self.key("alive/0"), self.presence),
            liveliness.declare_token(self.key("alive/world")),
            self.session.declare_queryable(self.key("join/*"), lambda query: self.inbox.put(("join", query))),
        ]

    def key(self, name):
        return f"csat/{self.welcome['run']}/{name}"

    def hearing(self, name):
        return lambda sample: self.inbox.put((name, sample.payload.to_bytes()))

    def presence(self, sample):
        if sample.kind == zenoh.SampleKind.DELETE:
            self.inbox.put(("gone", b""))

    def put(self, name, payload, **more):
        block = zenoh.CongestionControl.BLOCK
        self.session.put(self.key(name), payload, congestion_control=block, express=True, **more)

    def order(self, order, **members):
        self.put("clock", json.dumps({"world": self.welcome["world"], "order": order, **members}), encoding=JSON)

    def wait(self, name, what, fits=lambda told: True, limit_s=None):
        """The next `name` that fits. Whatever else comes meanwhile is seen to."""
        limit_s = limit_s or self.patience_s
        until = time.monotonic() + limit_s
        while True:
            try:
                got, told = self.inbox.get(timeout=max(0.0, until - time.monotonic()))
            except queue.Empty:
                raise Trouble(f"waited {limit_s} s for UAV 0 to {what}") from None
            if got == "join":
                self.answer(told)
            elif got.startswith("view/"):
                self.mirrors.append((got, json.loads(told)))
            elif got == "gone" != name:
                raise Trouble(f"the process of UAV 0 ended; it was to {what}")
            elif got == name:
                # Reports are csat's own: that one came is all there is to know.
                told = json.loads(told) if got in ("uav/0/ready", "uav/0/command") else told
                if fits(told):
                    return told

    def answer(self, query):
        """A process wants to take part."""
        with query:
            try:
                join = json.loads(query.payload.to_bytes())
                protocol, agent, process = join["protocol"], join["agent"], join["process"]
            except (AttributeError, ValueError, KeyError, TypeError) as error:
                return query.reply_err(f"not understood: {error!r}")
            if protocol != PROTOCOL:
                return query.reply_err(f"this world speaks version {PROTOCOL} of the protocol, not {protocol}")
            if agent != 0:
                return query.reply_err(f"there is no UAV {agent} here, only 0")
            if self.process not in (None, process):
                return query.reply_err("UAV 0 is flown by another process")
            self.process = process
            query.reply(self.key("join/0"), json.dumps(self.welcome), encoding=JSON)

    def done(self, step, turn, what):
        """What the agent answers to a frame (turn 0) or a turn."""
        expected = (self.process, step, turn)
        fits = lambda done: (done["process"], done["step"], done["round"]) == expected
        return self.wait("uav/0/command", f"{what} of step {step}", fits)


class Flight:
    """The mission, in lockstep."""

    def __init__(self, wire, scenario):
        self.wire, self.period_s = wire, scenario["run"]["period_s"]
        self.uav = town.Uav(scenario["agents"], scenario["map"]["size_m"])
        self.camera = town.Camera(scenario["camera"])
        self.rng = np.random.default_rng(scenario["seed"])
        self.said, self.monitor = [], Monitor()

    def fly(self, steps):
        # In a fleet, each would have to say that it hears all others and their processes.
        self.wire.wait("uav/0/ready", "join", lambda ready: ready["process"] == self.wire.process)
        for step in range(steps):
            self.step(step)
        self.wire.order("end", reason="the mission is over")
        # The end of this process must not overtake the order.
        self.wire.wait("gone", "end", limit_s=5)
        print(f"flown {steps} steps; {self.monitor.verdict()}")

    def step(self, step):
        now, until = (round(k * self.period_s * 1e6) for k in (step, step + 1))
        car = town.car_at(now * 1e-6)
        position, yaw = self.uav.position, self.uav.yaw
        labels, depth, boxes = self.camera.frame(position, yaw, town.bodies(car), self.rng)
        pose = {"p_world": position.tolist(), "yaw_rad": yaw, "pitch_rad": 0.0, "roll_rad": 0.0}
        detections = [{"target": 0, "pixels": boxes[-1]}] if boxes[-1] else []
        header = {"world": self.wire.welcome["world"], "step": step, "time": now, "next": until, "pose": pose,
                  "incarnation": 0, "detections": detections, "said": self.said}
        self.wire.put("uav/0/frame", pack(labels, depth), attachment=json.dumps(header))
        done = self.wire.done(step, 0, "look at the frame")
        commands, turn, heard = done["commands"], 0, []
        while True:
            self.said = [done["said"]]
            if self.said == heard:
                # Everybody knows all that was said: on to what is due next, if it is in this step.
                if done["due"] is None or done["due"] >= until:
                    break
                now = max(now, done["due"])
            turn, heard = turn + 1, self.said
            self.wire.order("turn", step=step, round=turn, now=now, said=self.said)
            done = self.wire.done(step, turn, f"finish turn {turn}")
            commands += done["commands"]
        self.wire.order("close", step=step, full=False)
        self.wire.wait("uav/0/report", f"report on step {step}")
        self.monitor.look(step, car, self.wire.mirrors)
        degrees = [round(float(np.degrees(command["yaw_rad"]))) for command in commands]
        ground_pct, car_px = 100 * (labels == town.GROUND).mean(), (labels == town.TARGET).sum()
        print(f"step {step}: UAV at {position.round(1)} m heading {np.degrees(yaw):.0f} deg, {turn} turns, "
              f"commands {degrees}, {ground_pct:.0f} % ground, {car_px} px of the car", flush=True)
        for command in commands:
            self.uav.command = command["yaw_rad"]
        self.uav.advance(self.period_s)


def pack(labels, depth):
    """The payload of a frame: runs of labels, then depths where the label is Obstacle or Target, row
    by row, little-endian."""
    labels, depth = labels.ravel(), depth.ravel()
    starts = np.append(0, np.flatnonzero(np.diff(labels)) + 1)
    runs = np.diff(starts, append=labels.size) << 8 | labels[starts]
    measured = depth[labels >= town.OBSTACLE]
    return len(runs).to_bytes(4, "little") + runs.astype("<u4").tobytes() + measured.astype("<u2").tobytes()


class Monitor:
    """Compares what the agent shows people (docs/topics.md), if it does, with the truth."""

    def __init__(self):
        self.truth, self.shown, self.checked, self.known = {}, {}, 0, 0

    def look(self, step, car, mirrors):
        self.truth[step] = car
        while mirrors:
            key, shown = mirrors.pop()
            self.shown.setdefault(shown["step"], {})[key.split("/")[-1]] = shown["features"]
        for step in [k for k, sets in self.shown.items() if len(sets) == 2 and k in self.truth]:
            sets, car = self.shown.pop(step), self.truth.pop(step)
            own = [feature for feature in sets["targets"] if feature["properties"]["target"] == 0]
            if not any(contains(feature["geometry"], car) for feature in own or sets["unexplored"]):
                raise Trouble(f"at step {step} the car is at {car}: outside of the set that is to contain it")
            self.checked, self.known = self.checked + 1, self.known + bool(own)

    def verdict(self):
        if self.checked == 0:
            return "the agent showed no sets"
        return f"in all {self.checked} steps shown the car was in its set, identified in {self.known}"


def contains(geometry, point):
    """Whether a MultiPolygon contains a point: a ray to the east crosses its rings oddly often."""
    crossings = 0
    for ring in (np.array(ring)[:, :2] - point for polygon in geometry["coordinates"] for ring in polygon):
        (x0, y0), (x1, y1) = ring[:-1].T, ring[1:].T
        crosses = (y0 > 0) != (y1 > 0)
        slope = (x1 - x0) / np.where(crosses, y1 - y0, 1)
        crossings += np.sum(crosses & (x0 - y0 * slope > 0))
    return crossings % 2 == 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--listen", default="tcp/127.0.0.1:7447", metavar="ENDPOINT")
    parser.add_argument("--scenario", metavar="FILE", help="a scenario.resolved.toml with one UAV")
    parser.add_argument("--steps", type=int, default=120)
    parser.add_argument("--patience", type=float, default=30.0, metavar="SECONDS")
    arguments = parser.parse_args()
    text = open(arguments.scenario, encoding="utf-8").read() if arguments.scenario else SCENARIO
    scenario = tomllib.loads(text)
    if scenario["agents"]["count"] != 1 or min(scenario["map"]["size_m"]) < 200:
        return "world.py: expected agents.count = 1 and map.size_m of 200 or more, where the town fits in"
    welcome = {"protocol": PROTOCOL, "run": scenario["seed"], "world": secrets.randbits(53), "name": "boxes",
               "scenario": text, "map": None, "pace": "lockstep"}
    try:
        wire = Wire(arguments.listen, welcome, arguments.patience)
    except zenoh.ZError as error:
        return f"world.py: cannot listen on {arguments.listen}: {error}"
    try:
        Flight(wire, scenario).fly(arguments.steps)
    except (Trouble, KeyboardInterrupt) as error:
        reason = str(error) or "ended by the user"
        wire.order("end", reason=reason)
        return f"world.py: {reason}"
    finally:
        # Without this, Zenoh's threads keep the process alive.
        wire.session.close()


if __name__ == "__main__":
    sys.exit(main())
