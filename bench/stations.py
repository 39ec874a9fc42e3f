"""What a station behind walls costs: on a roof, in the open and in a courtyard of the same building.

Usage: python3 bench/stations.py [--seconds S] [--seeds N] [--write]           (needs matplotlib)

Flies `city` with coarse images and a radio that walls take 30 dB from, once per seed and place, and once
without walls. The building is the one with the largest courtyard of the seed's town; "open" is the corner of a
square of 10 m around the building that is farthest from other buildings. Prints Markdown; --write puts the table
into docs/lossy-links.md and the curves into docs/img/lossy-station.svg. The program is target/debug/csat, or $CSAT.
"""

import csv
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import matplotlib
except ImportError:
    sys.exit("bench/stations.py draws with matplotlib, which this python does not have: pip install matplotlib")
matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "csat"
import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parent.parent
CSAT = os.environ.get("CSAT", ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "debug/csat")
RADIO = "netem.radio.propagation={obstruction_db=%g,exponent=2.6}"
COARSE = ["camera.columns=160", "camera.rows=120", "camera.min_pixels=1", "netem.trace=none"]
# Seconds from which UAVs are spread out: means are over the second half of a mission.
PLACES = [("roof", 30), ("open", 30), ("courtyard", 30), ("courtyard, walls let through", 0)]
COLOURS = {"roof": "#0072B2", "open": "#009E73", "courtyard": "#D55E00", "courtyard, walls let through": "#CC79A7"}


def fly(folder, seed, sets):
    command = [CSAT, "run", "city", "--seed", str(seed), "--json", "--out", folder]
    for setting in sets:
        command += ["--set", setting]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}: exit {done.returncode}")
    return json.loads(done.stdout)


def middle(ring):
    """The centroid of a ring."""
    area, x, y = 0.0, 0.0, 0.0
    for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1]):
        cross = ax * by - bx * ay
        area, x, y = area + cross / 2, x + (ax + bx) * cross, y + (ay + by) * cross
    return area, (x / (6 * area), y / (6 * area))


def distance(point, buildings):
    """To the nearest wall, metres."""
    best = math.inf
    for rings in (building["rings"] for building in buildings):
        for ring in rings:
            for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1]):
                dx, dy = bx - ax, by - ay
                t = max(0.0, min(1.0, ((point[0] - ax) * dx + (point[1] - ay) * dy) / (dx * dx + dy * dy)))
                best = min(best, math.hypot(point[0] - ax - t * dx, point[1] - ay - t * dy))
    return best


def places(seed):
    """Where the stations of a seed's town are, [x, y, z] by place, and how high the building is."""
    with tempfile.TemporaryDirectory() as folder:
        fly(f"{folder}/run", seed, COARSE + ["run.duration_s=0.5"])
        buildings = json.loads(Path(f"{folder}/run/view.json").read_text())["obstacles"]
    yards = [building for building in buildings if len(building["rings"]) > 1]
    if not yards:
        sys.exit(f"the town of seed {seed} has no courtyard")
    block = max(yards, key=lambda building: abs(middle(building["rings"][1])[0]))
    (_, yard), roof = middle(block["rings"][1]), block["height_m"]
    outer, hole = block["rings"][0][0], block["rings"][1][0]
    wing = [(a + b) / 2 for a, b in zip(outer, hole)]
    xs, ys = zip(*block["rings"][0])
    corners = [(x, y) for x in (min(xs) - 10, max(xs) + 10) for y in (min(ys) - 10, max(ys) + 10)]
    inside = [corner for corner in corners if max(map(abs, corner)) < 250]
    street = max(inside or corners, key=lambda corner: distance(corner, buildings))
    at = {"roof": [*wing, roof + 2], "open": [*street, 2], "courtyard": [*yard, 2]}
    at["courtyard, walls let through"] = at["courtyard"]
    return at, roof


def curve(folder):
    """Of the station and of the UAVs: [(time_s, unexplored_pct)]."""
    fleet, station = {}, []
    with open(f"{folder}/metrics.csv") as rows:
        for row in csv.DictReader(rows):
            value = (float(row["time_s"]), float(row["unexplored_pct"]))
            if row["role"] == "station":
                station.append(value)
            else:
                fleet.setdefault(value[0], []).append(value[1])
    return station, [(time_s, sum(all) / len(all)) for time_s, all in fleet.items()]


def mean(values):
    values = [value for value in values if value is not None]
    return sum(values) / len(values) if values else None


def main():
    arguments = sys.argv[1:]
    option = lambda name, default: int(arguments[arguments.index(name) + 1]) if name in arguments else default
    seconds, seeds = option("--seconds", 120), range(1, option("--seeds", 3) + 1)
    summaries, curves = {name: [] for name, _ in PLACES}, {name: [] for name, _ in PLACES}
    fleets = []
    for seed in seeds:
        at, roof = places(seed)
        print(f"seed {seed}: a building of {roof:.0f} m; " + "; ".join(
            f"{name} ({p[0]:.0f}, {p[1]:.0f}, {p[2]:.0f}) m" for name, p in at.items()), file=sys.stderr)
        for name, obstruction_db in PLACES:
            x, y, z = at[name]
            with tempfile.TemporaryDirectory() as folder:
                summary = fly(f"{folder}/run", seed, COARSE + [
                    f"run.duration_s={seconds}", RADIO % obstruction_db,
                    f"stations=[{{x_m={x!r},y_m={y!r},z_m={float(z)!r}}}]"])
                station, fleet = curve(f"{folder}/run")
            if summary["violations"]:
                sys.exit(f"violations: seed {seed}, {name}")
            summaries[name].append(summary)
            curves[name].append(station)
            fleets.append(fleet)
    table = ["| station | messages that reached it | unexplored to it | to the UAVs, mean | news of UAVs | cars it knows at the end |",
             "|---|---|---|---|---|---|"]
    for name, _ in PLACES:
        own = [summary["stations"][0] for summary in summaries[name]]
        share = 100 * sum(s["delivered_to"] for s in own) / sum(s["sent_to"] for s in own)
        table.append(
            f"| {name} | {share:.0f} % | {mean([s['unexplored_pct'] for s in own]):.1f} % "
            f"| {mean([s['unexplored_pct'] for s in summaries[name]]):.1f} % "
            f"| {mean([s['news_age_s'] for s in own]):.1f} s old "
            f"| {mean([s['final']['identified'] for s in own]):.1f} of {summaries[name][0]['targets']} |")
    print("\n".join(table))
    draw(curves, fleets, seconds, len(seeds))
    if "--write" in arguments:
        page = ROOT / "docs/lossy-links.md"
        text = page.read_text()
        begin, end = "<!-- bench/stations.py -->\n", "\n<!-- end -->"
        head, rest = text.split(begin)
        page.write_text(head + begin + "\n".join(table) + end + rest.split(end, 1)[1])


def draw(curves, fleets, seconds, seeds):
    figure, axes = plt.subplots(figsize=(8, 4.2))
    of_step = lambda runs: [(run[0][0], mean([point[1] for point in run])) for run in zip(*runs)]
    for name, runs in curves.items():
        style = "--" if "through" in name else "-"
        for run in runs:
            axes.plot(*zip(*run), color=COLOURS[name], alpha=0.18, linewidth=0.8, linestyle=style)
        axes.plot(*zip(*of_step(runs)), color=COLOURS[name], label=f"station: {name}", linewidth=2, linestyle=style)
    axes.plot(*zip(*of_step(fleets)), color="#222222", label="UAVs, mean", linewidth=2, linestyle=":")
    axes.set(xlim=(0, seconds), ylim=(0, 100), xlabel="time, s", ylabel="unexplored ground, %",
             title=f"What a ground station knows, mean of {seeds} towns (thin: each)")
    axes.grid(alpha=0.25)
    axes.legend(frameon=False)
    figure.tight_layout()
    figure.savefig(ROOT / "docs/img/lossy-station.svg", metadata={"Date": None})


main()
