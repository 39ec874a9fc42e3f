"""The table of bench/stonesoup.sh, from files with a line of JSON per filter."""

import json
import math
import statistics
import sys

import stonesoup

NAMES = {
    "particles-6400": "csat, 6400 particles",
    "grid-12.5": "csat, grid of 12.5 m",
    "grid-0.67": "csat, grid of 0.67 m",
    "adaptive": "csat, adaptive",
    "stonesoup-6400": f"Stone Soup {stonesoup.__version__}, 6400 particles",
}


def main():
    flights = []
    for file in sys.argv[1:]:
        with open(file) as lines:
            flights.append({result["filter"]: result for result in map(json.loads, lines)})
    theirs = [flight["stonesoup-6400"] for flight in flights]
    print(f"{len(flights)} flights of {theirs[0]['frames']} frames, "
          f"{statistics.mean(result['detections'] for result in theirs):.0f} detections each")
    print()
    print("| filter | updates per second | times Stone Soup | error at the end, m | σ, m | RMSE since the first detection, m |")
    print("|---|---:|---:|---:|---:|---:|")
    for key, name in NAMES.items():
        results = [flight[key] for flight in flights]
        of = lambda field: [result[field] for result in results]
        ratios = [ours / other["updates_per_s"] for ours, other in zip(of("updates_per_s"), theirs)]
        mean = lambda field: math.sqrt(statistics.mean(x * x for x in of(field)))
        print(f"| {name} | {statistics.median(of('updates_per_s')):.0f} | {statistics.median(ratios):.2g} "
              f"| {statistics.mean(of('error_m')):.2f} | {statistics.mean(of('sigma_m')):.2f} | {mean('rmse_m'):.1f} |")


main()
