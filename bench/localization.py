#!/usr/bin/env python3
"""The localisation error (5.36) of recorded runs, by what it may depend on.

    pip install mcap
    bench/localization.py RUN...

Each RUN is the folder of `csat run --record` (any link but perfect ones would make agents differ: what
agent 0 knows counts). Prints docs/reproduction.md's table: means over t = 150 s to the end.
"""

import json
import math
import pathlib
import statistics
import sys

from mcap.reader import make_reader

FROM_S = 150
AGES_S = [(0, 0.1), (0.1, 5), (5, 10), (10, 20), (20, math.inf)]
SPEEDS = [(0, 0.1), (0.1, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 1.0)]


def barycentre(polygons):
    area = x = y = 0.0
    for ring in (ring for polygon in polygons for ring in polygon):
        for (x0, y0), (x1, y1) in zip(ring, ring[1:]):
            cross = x0 * y1 - x1 * y0
            area, x, y = area + cross, x + (x0 + x1) * cross, y + (y0 + y1) * cross
    return (x / (3 * area), y / (3 * area)) if area > 0 else None


def read(run):
    """By step: where cars are, the sets of agent 0, and whom somebody's frame shows."""
    truth, sets, seen = {}, {}, {}
    with open(pathlib.Path(run) / "recording.mcap", "rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            document = channel.topic.endswith("/targets") and json.loads(message.data)
            if channel.topic == "truth/targets":
                truth[document["step"]] = {t["target"]: t["location"] for t in document["targets"]}
            elif document:
                for feature in document["features"]:
                    properties, polygons = feature["properties"], feature["geometry"]["coordinates"]
                    if properties["detected"]:
                        seen.setdefault(document["step"], set()).add(properties["target"])
                    if channel.topic == "view/0/targets":
                        known = sets.setdefault(document["step"], {})
                        known[properties["target"]] = (polygons, properties["area_m2"])
    return truth, sets, seen


def rows(run):
    """Every set of every recorded instant."""
    truth, sets, seen = read(run)
    steps = sorted(truth)
    period_s = 0.5
    driven = {j: sum(math.dist(truth[a][j], truth[b][j]) for a, b in zip(steps, steps[1:]))
              for j in truth[steps[0]]}
    last = {}
    for step in steps:
        last |= {j: step for j in seen.get(step, ())}
        for j, (polygons, area_m2) in sets.get(step, {}).items():
            centre, car = barycentre(polygons), truth[step][j]
            if step * period_s < FROM_S or centre is None:
                continue
            yield {
                "instant": (run, step),
                "error": math.dist(centre, car),
                "radius": math.sqrt(area_m2 / math.pi),
                "age": (step - last.get(j, step)) * period_s,
                "speed": driven[j] / ((steps[-1] - steps[0]) * period_s),
                "driven": math.dist(truth[last.get(j, step)][j], car),
            }


def line(name, some):
    if some:
        mean = lambda key: statistics.mean(row[key] for row in some)
        print(f"| {name} | {len(some)} | {mean('error'):.2f} | {mean('radius'):.2f} | {mean('driven'):.2f} |")


def main():
    every = [row for run in sys.argv[1:] for row in rows(run)]
    print("| sets | how many | error | radius | driven since seen |\n|---|---|---|---|---|")
    line("all, (5.36)", every)
    for low, high in AGES_S:
        age = f"last seen {low:g} to {high:g} s ago" if low else "seen in this step"
        line(age, [row for row in every if low <= row["age"] < high])
    for low, high in SPEEDS:
        fast = [row for row in every if low <= row["speed"] < high]
        line(f"of cars of {low:g} to {high:g} m/s on average", fast)
    instants = {}
    for row in every:
        instants.setdefault(row["instant"], []).append(row["error"])
    for name, of in (("median", statistics.median), ("least", min)):
        mean = statistics.mean(of(errors) for errors in instants.values())
        print(f"| {name} over the targets instead of the mean | | {mean:.2f} | | |")


main()
