"""How the cost of a mission grows: with the fleet (at constant density, with and without range
limits), the image, the vertices of the sets and the obstacles. Prints Markdown and draws the curves.

Usage: python3 bench/scale.py [--write] [--seconds S]      (needs matplotlib; about 20 minutes, quiet)

--write puts the tables into docs/scale.md and the curves into docs/img/scale-*.svg.
The program is target/release/csat, or $CSAT. Every mission is of its own process, one after the other,
on all cores; times are those of its summary.json.
"""

import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import matplotlib
except ImportError:
    sys.exit("bench/scale.py draws with matplotlib, which this python does not have: pip install matplotlib")

ROOT = Path(__file__).resolve().parent.parent
CSAT = os.environ.get("CSAT", ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "release/csat")
STAGES = ["render", "sense", "estimate", "fuse", "guidance"]
# UAVs and the side of the town, metres: 16 UAVs per km², as in the paper.
FLEETS = [(4, 500), (8, 707), (16, 1000), (32, 1414), (64, 2000)]
RANGES_M = ["inf", 500, 250]


def fly(seconds, **settings):
    """Flies `city` and returns its summary, with its memory and mean vertices."""
    settings = {"run.duration_s": seconds, "netem.trace": "none"} | settings
    with tempfile.TemporaryDirectory() as folder:
        command = [CSAT, "run", "city", "--json", "--out", f"{folder}/run"]
        for key, value in settings.items():
            command += ["--set", f"{key}={value}"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        output = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        if status:
            sys.exit(f"{' '.join(map(str, command))}: exit {os.waitstatus_to_exitcode(status)}")
        summary = json.loads(output)
        with open(f"{folder}/run/metrics.csv") as rows:
            vertices = [int(row["vertices"]) for row in csv.DictReader(rows)]
    summary["memory_mb"] = usage.ru_maxrss / 1024
    summary["cpu_s"] = usage.ru_utime + usage.ru_stime
    summary["vertices"] = sum(vertices) / len(vertices)
    if summary["violations"]:
        sys.exit(f"violations: {' '.join(map(str, command))}")
    return summary


def keyed(**settings):
    return {key.replace("__", "."): value for key, value in settings.items()}


def exponent(points):
    """The slope of the least-squares line through (log x, log y)."""
    logs = [(math.log(x), math.log(y)) for x, y in points]
    mean_x = sum(x for x, _ in logs) / len(logs)
    mean_y = sum(y for _, y in logs) / len(logs)
    slope = sum((x - mean_x) * (y - mean_y) for x, y in logs)
    return slope / sum((x - mean_x) ** 2 for x, _ in logs)


def stage_cells(summary):
    return [f"{summary['timing_ms'][stage]['median']:.2f}" for stage in STAGES]


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---:|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def fleet(seconds):
    """Cost against fleet size, for perfect links and for range limits."""
    text, curves = "", []
    for range_m in RANGES_M:
        label = "perfect links" if range_m == "inf" else f"range {range_m} m"
        rows, points, memory = [], [], []
        for count, side in FLEETS:
            settings = keyed(agents__count=count, map__size_m=f"[{side},{side}]",
                             netem__radio__range_m=range_m)
            s = fly(seconds, **settings)
            points.append((count, s["cpu_s"] / s["sim_s"]))
            memory.append((count, s["memory_mb"]))
            rows.append([str(count), f"{side / 1000:.1f} km", f"{s['cpu_s'] / s['sim_s']:.3f}",
                         f"{s['realtime_factor']:.1f}", *stage_cells(s), f"{s['vertices']:.0f}",
                         f"{s['memory_mb']:.0f}"])
        header = ["UAVs", "side", "CPU s per simulated s", "times real time", *STAGES, "vertices", "MB"]
        per_agent = (memory[-1][1] - memory[0][1]) / (memory[-1][0] - memory[0][0])
        text += f"\n{label}: cost grows with UAVs to the power {exponent(points):.2f}; "
        text += f"{per_agent:.1f} MB per further agent.\n\n" + table(header, rows)
        curves.append((label, points))
    draw("fleet", "UAVs (16 per km²)", "CPU s per simulated s", curves)
    return text


def stages_against(name, label, seconds, variants, measure):
    """Cost of each stage against something that `variants` (label, settings) change."""
    rows, series = [], {stage: [] for stage in STAGES}
    for title, settings in variants:
        s = fly(seconds, **settings)
        x = measure(s, settings)
        rows.append([title, f"{x:.0f}", *stage_cells(s)])
        for stage in STAGES:
            series[stage].append((x, s["timing_ms"][stage]["median"]))
    # What takes next to nothing would only stretch the axis.
    drawn = [(stage, points) for stage, points in series.items() if all(y > 0.02 for _, y in points)]
    draw(name, label, "ms per agent and step, median", drawn)
    slopes = ", ".join(f"{stage} {exponent(points):.2f}" for stage, points in drawn)
    return f"\nExponents: {slopes}.\n\n" + table(["", label, *STAGES], rows)


def images(seconds):
    sizes = [(120, 90), (240, 180), (480, 360), (960, 720)]
    variants = [(f"{c} x {r}", keyed(camera__columns=c, camera__rows=r)) for c, r in sizes]
    pixels = lambda _, settings: settings["camera.columns"] * settings["camera.rows"]
    return stages_against("image", "pixels", seconds, variants, pixels)


def vertices(seconds):
    variants = [(f"simplify_m {m}, {n}-gons", keyed(estimator__simplify_m=m, estimator__disc_vertices=n))
                for m, n in [(1.0, 8), (0.4, 12), (0.15, 16), (0.05, 24), (0.01, 32)]]
    return stages_against("vertices", "vertices of all sets", seconds, variants,
                          lambda s, _: s["vertices"])


def obstacles(seconds):
    shares = [0.0125, 0.025, 0.05, 0.1, 0.2]
    variants = [(f"{100 * share:g} %", keyed(map__built_share=share)) for share in shares]
    return stages_against("obstacles", "built, ‰ of the ground", seconds, variants,
                          lambda _, settings: 1000 * settings["map.built_share"])


def draw(name, x_label, y_label, curves):
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import NullLocator

    plt.rcParams["svg.hashsalt"] = "csat"
    figure, axes = plt.subplots(figsize=(5.2, 3.4))
    for label, points in curves:
        axes.loglog(*zip(*points), marker="o", label=label)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    places = sorted({x for _, points in curves for x, _ in points})
    places = [x for x, before in zip(places, [0, *places]) if x > 1.1 * before]
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticks(places, [f"{x:.3g}" if x < 100 else f"{x:.0f}" for x in places])
    axes.grid(True, which="both", alpha=0.25)
    axes.legend(fontsize="small")
    figure.tight_layout()
    figure.savefig(IMAGES / f"scale-{name}.svg", metadata={"Date": None})
    plt.close(figure)


def replace(document, name, text):
    pattern = rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)"
    result, count = re.subn(pattern, lambda m: m[1] + text + m[2], document, flags=re.S)
    if count != 1:
        sys.exit(f"docs/scale.md has no place for {name}")
    return result


if __name__ == "__main__":
    arguments = sys.argv[1:]
    write = "--write" in arguments
    seconds = int(arguments[arguments.index("--seconds") + 1]) if "--seconds" in arguments else 60
    IMAGES = ROOT / "docs/img" if write else Path(tempfile.mkdtemp(prefix="scale-"))
    parts = {part.__name__: part(seconds) for part in [fleet, images, vertices, obstacles]}
    for name, text in parts.items():
        print(f"\n## {name}\n{text}")
    print(f"\ncurves: {IMAGES}")
    if write:
        page = ROOT / "docs/scale.md"
        document = page.read_text()
        for name, text in parts.items():
            document = replace(document, name, text)
        page.write_text(document)
