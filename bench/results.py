#!/usr/bin/env python3
"""Flies the missions behind docs/results.md and prints its tables.

    bench/results.py CSAT FOLDER [JOBS]

CSAT is the release binary, FOLDER keeps one summary per mission: what is there is not flown again.
"""

import json
import os
import statistics
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

CRITERIA = [("str1", 1), ("str2-no-hidden", 1), ("str2", 1), ("str3", 0), ("str3", 1)]
# Thesis tables 5.3-5.6 (means over t = 150..300 s of ten runs).
THESIS = {
    ("str1", 1): (42.06, 26.88, 88.64, 30.24, 18.73, 1.43, 18.29),
    ("str2-no-hidden", 1): (29.56, 17.70, 90.14, 30.13, 19.38, 1.28, 16.06),
    ("str2", 1): (26.34, 17.20, 90.12, 28.34, 19.06, 1.10, 13.57),
    ("str3", 0): (23.14, 14.10, 91.15, 28.66, 21.63, 0.92, 11.71),
    ("str3", 1): (22.06, 13.18, 91.14, 28.46, 21.04, 0.95, 13.77),
}
METRICS = [
    "unexplored_pct", "hidden_pct", "explored_pct", "footprint_pct", "ground_seen_pct",
    "localization_error_m", "target_radius_m",
]


def fly(csat, folder, job):
    scenario, criterion, kappa, seed = job
    name = f"{scenario}-{criterion}-{kappa}-{seed}"
    path = os.path.join(folder, name + ".json")
    if not os.path.exists(path) or os.path.getsize(path) == 0:
        command = [csat, "run", scenario, "--seed", str(seed), "--threads", "1", "--json",
                   "--set", f"guidance.criterion={criterion}", "--set", f"guidance.kappa={kappa}",
                   "--out", os.path.join(folder, name)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode not in (0, 3):
            sys.exit(f"{name}: {done.stderr}")
        with open(path, "w") as file:
            file.write(done.stdout)
    with open(path) as file:
        return job, json.load(file)


def spread(values):
    values = [v for v in values if v is not None]
    return f"{statistics.mean(values):.2f} ± {statistics.stdev(values):.2f}"


def main():
    csat, folder = sys.argv[1:3]
    os.makedirs(folder, exist_ok=True)
    jobs = [("city", "str3", 1, s) for s in range(1, 21)]
    jobs += [(h, "str3", 1, s) for h in ("helsinki-05", "helsinki-17") for s in range(1, 11)]
    jobs += [("city", c, k, s) for c, k in reversed(CRITERIA[:-1]) for s in range(1, 11)]
    with ThreadPoolExecutor(int(sys.argv[3]) if len(sys.argv) > 3 else os.cpu_count()) as pool:
        runs = dict(pool.map(lambda job: fly(csat, folder, job), jobs))

    print("| criterion | " + " | ".join(METRICS) + " |")
    print("|---|" + "---|" * len(METRICS))
    for c, k in CRITERIA:
        rows = [runs[("city", c, k, s)] for s in range(1, 11)]
        name = f"`{c}`" + (f", κ = {k}" if c == "str3" else "")
        print(f"| {name} | " + " | ".join(spread([r[m] for r in rows]) for m in METRICS) + " |")
        print("| *thesis* | " + " | ".join(f"*{v}*" for v in THESIS[(c, k)]) + " |")
    print("\n| scenario | seeds | violations | inconsistencies | identified | " + " | ".join(METRICS[:3]) + " |")
    print("|---|---|---|---|---|---|---|---|")
    for scenario, last in (("city", 20), ("helsinki-05", 10), ("helsinki-17", 10)):
        rows = [runs[(scenario, "str3", 1, s)] for s in range(1, last + 1)]
        total = [sum(r[m] for r in rows) for m in ("violations", "inconsistencies")]
        found = f"{sum(r['identified'] for r in rows)} of {sum(r['targets'] for r in rows)}"
        means = " | ".join(spread([r[m] for r in rows]) for m in METRICS[:3])
        print(f"| `{scenario}` | 1-{last} | {total[0]} | {total[1]} | {found} | {means} |")
    everything = runs.values()
    print(f"\n{len(runs)} missions: {sum(r['violations'] for r in everything)} violations, "
          f"{sum(r['inconsistencies'] for r in everything)} inconsistencies")


main()
