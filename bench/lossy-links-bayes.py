#!/usr/bin/env python3
"""The tables of "The second mission" of docs/lossy-links.md from what bench/lossy-links-bayes.sh flew.

    bench/lossy-links-bayes.py [FOLDER]        default: sweeps/lossy-links-bayes

Errors, deviations and times are medians over the seeds; bounds of shares are those of Clopper and Pearson (95 %).
"""

import csv
import math
import statistics
import sys
from pathlib import Path


def binomial_bounds(hits, n):
    """Clopper and Pearson's interval, by bisection."""

    def tail(p, least):
        return sum(math.comb(n, k) * p**k * (1 - p) ** (n - k) for k in range(least, n + 1))

    def root(least, level):
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if tail(middle, least) < level else (low, middle)
        return low

    return (root(hits, 0.025) if hits else 0.0), (root(hits + 1, 0.975) if hits < n else 1.0)


def row(runs):
    n = len(runs)
    hits = sum(run["in_95_region"] == "true" for run in runs)
    low, high = binomial_bounds(hits, n)

    def median(key):
        return statistics.median(float(run[key]) for run in runs)

    found = sum(run["first_detection_s"] != "" for run in runs)
    each = sum(float(run["bytes_sent"]) / float(run["sim_s"]) / float(run["agents"]) for run in runs) / n
    lost = sum(float(run["localization_error_m"]) > 50 for run in runs)
    return (
        f"{hits} of {n} ({low:.3f} to {high:.3f}) | {median('localization_error_m'):.2f} m | "
        f"{median('sigma_m'):.2f} m | {median('first_detection_restricted_s'):.1f} s | "
        f"{median('factors_held_pct'):.0f} % | {each / 1000:.2f} kB/s | {n - found} | {lost} | "
        f"{statistics.fmean(float(run['first_detection_restricted_s']) for run in runs):.1f} s"
    )


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "sweeps/lossy-links-bayes")
    for sweep in ["perfect", "rough", "fusion", "gauss-markov", "range", "loss", "delay", "budget"]:
        path = folder / sweep / "sweep.csv"
        if not path.exists():
            continue
        with path.open() as file:
            runs = list(csv.DictReader(file))
        columns = list(runs[0])
        keys = columns[1 : columns.index("seed")]
        points = {}
        for run in runs:
            if run["status"] == "flown":
                points.setdefault(tuple(run[key] for key in keys), []).append(run)
        print(f"\n{sweep}, {sum(int(float(run['violations'])) for run in runs if run['violations'])} violations\n")
        print(
            f"| {' | '.join(keys)} | truth in the 95 % region | error | sigma | first detection | factors held | "
            "sent by each | never detected | error above 50 m | mean time |"
        )
        print("|---" * (len(keys) + 9) + "|")
        for point, of in points.items():
            print(f"| {' | '.join(point)} | {row(of)} |")


main()
