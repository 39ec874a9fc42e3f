#!/usr/bin/env python3
"""Charts of the report of a sweep as one picture, two in a row: how those of docs/lossy-links.md are made.

    bench/charts.py SWEEP/report.html PICTURE.png TITLE...           (needs rsvg-convert)

A TITLE is that of a chart, such as "Localisation error at the end". The charts are taken as they are.
"""

import math
import re
import subprocess
import sys
from pathlib import Path

ZOOM = 1.5
COLUMNS = 2
GAP = 14


def charts(page):
    """(width, height, what is inside) by title, the first chart of each."""
    found = {}
    pattern = r'<svg [^>]*viewBox="0 0 ([\d.]+) ([\d.]+)"[^>]*>\s*<title>(.*?)</title>(.*?)</svg>'
    for width, height, title, inside in re.findall(pattern, page, re.DOTALL):
        found.setdefault(title, (float(width), float(height), inside))
    return found


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    report, picture, titles = Path(sys.argv[1]), sys.argv[2], sys.argv[3:]
    page = report.read_text()
    found = charts(page)
    if missing := [title for title in titles if title not in found]:
        sys.exit(f"{report} has no chart {', '.join(missing)}; it has {', '.join(found)}")
    style = re.search(r"<style>(.*?)</style>", page, re.DOTALL).group(1)
    # A picture is on white, whatever the reader prefers.
    style = re.sub(r"@media[^{]*\{(?:[^{}]*\{[^{}]*\})*[^{}]*\}", "", style).replace("system-ui", "DejaVu Sans")
    style = re.sub(r"svg \{[^}]*\}|:root \{[^}]*\}|body \{[^}]*\}", "", style)
    chosen = [found[title] for title in titles]
    cell = [max(chart[side] for chart in chosen) + GAP for side in (0, 1)]
    parts = [
        f'<g transform="translate({i % COLUMNS * cell[0]} {i // COLUMNS * cell[1]})">{inside}</g>'
        for i, (_, _, inside) in enumerate(chosen)
    ]
    width = min(COLUMNS, len(chosen)) * cell[0] - GAP
    height = math.ceil(len(chosen) / COLUMNS) * cell[1] - GAP
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
        f'<style>{style}</style><rect width="100%" height="100%" fill="#ffffff"/><g color="#222222">{"".join(parts)}</g></svg>'
    )
    subprocess.run(["rsvg-convert", "-z", str(ZOOM), "-o", picture], input=svg.encode(), check=True)


main()
