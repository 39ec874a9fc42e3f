"""Writes the tables of docs/performance.md from what bench/table.sh measured."""

import json
import pathlib
import re
import subprocess
import sys
import time

MOMENTS = ["60s", "150s"]
# stage, criterion's name, callgrind's name, figure to reach (ms), the thesis's figure (ms)
STAGES = [
    ("render a frame", "render", "render", 3, None),
    ("sense", "sense", "sense", None, None),
    ("say a fact", "say", "say", None, None),
    ("hear 3 facts, 6 plans", "hear", "hear", None, None),
    ("estimate: update with the own frame only", "estimate", "estimate", None, None),
    ("sense + estimate", None, None, 3, 2150),
    ("update: own frame and 3 facts at once", "update", "update", None, None),
    ("the same with 3 snapshots", "update-snapshots", "update_snapshots", None, None),
    ("fuse 3 facts apart from a frame", "fuse", "fuse", 2, None),
    ("fuse 3 snapshots apart from a frame", "fuse-snapshots", "fuse_snapshots", 2, None),
    ("guidance, a pass, `str1`", "guidance-str1", "guidance_str1", None, None),
    ("guidance, a pass, `str2`", "guidance-str2", "guidance_str2", None, None),
    ("guidance, a pass, `str3`", "guidance-str3", "guidance_str3", None, None),
    ("guidance, a decision: 2 passes, `str3`", "guidance-decision", "guidance_decision", 10, 1520),
]
SUMS = {"sense + estimate": [("sense", "sense"), ("estimate", "estimate")]}
DOCUMENT = pathlib.Path("docs/performance.md")
BEGIN, END = "<!-- bench/table.sh -->", "<!-- end of bench/table.sh -->"


def command(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def median_ms(criterion, group, name):
    estimates = json.loads((criterion / group / name / "new/estimates.json").read_text())
    return estimates["median"]["point_estimate"] / 1e6


def machine(load):
    cpu = re.search(r"Model name:\s*(.*)", command("lscpu")).group(1)
    cores = command("nproc")
    dirty = ", with uncommitted changes" if command("git", "status", "--porcelain") else ""
    revision = command("git", "rev-parse", "--short=12", "HEAD") + dirty
    return (
        f"{cpu}, {cores} cores, {command('uname', '-sr')}, {command('rustc', '--version')}; "
        f"revision {revision}; {time.strftime('%Y-%m-%d')}. "
        f"Load before the benchmark, after it, after the missions: {', '.join(load)} "
        "(about 0, 1, 1 when nothing else runs)."
    )


def stage_rows(criterion, counts):
    for title, bench, counted, reach, thesis in STAGES:
        parts = SUMS.get(title, [(bench, counted)])
        times = [sum(median_ms(criterion, m, b) for b, _ in parts) for m in MOMENTS]
        instructions = sum(counts[c] for _, c in parts)
        slowest = max(times)
        yield (
            f"| {title} | "
            + " | ".join(f"{t:.2f}" for t in times)
            + f" | {instructions:.2f} | "
            + (f"{reach} ms | {slowest / reach:.2f}" if reach else "| ")
            + " | "
            + (f"{thesis / slowest:.0f} times" if thesis else "")
            + " |"
        )


def mission_rows(out):
    for threads in [1, 2]:
        run = json.loads((out / f"threads{threads}.json").read_text())
        reach = "12 s" if threads == 1 else "20 s"
        yield (
            f"| {threads} | {run['wall_s']:.1f} s | {run['realtime_factor']:.0f} | {reach} | "
            f"{100 * 60 / run['wall_s']:.0f} times | {run['violations']} | `{run['digest']}` |"
        )


def main():
    criterion, out = map(pathlib.Path, sys.argv[1:3])
    rows = re.findall(r"^\| (\w+) \| ([\d.]+) \|", (out / "counts.md").read_text(), re.M)
    counts = {name: float(count) for name, count in rows}
    lines = [
        machine((out / "load").read_text().split()),
        "",
        "| per agent and step | 60 s, ms | 150 s, ms | 60 s, M instructions | reach | of reach "
        "| faster than the thesis |",
        "|---|---:|---:|---:|---:|---:|---:|",
        *stage_rows(criterion, counts),
        "",
        "| `city`, 300 s, threads | wall | times real time | reach | faster than the thesis "
        "| violations | digest |",
        "|---:|---:|---:|---:|---:|---:|---|",
        *mission_rows(out),
        "",
        f"30 s of it with pictures, one process, all cores: "
        f"{median_ms(criterion, 'mission', '30s') / 1e3:.2f} s.",
    ]
    text = "\n".join(lines) + "\n"
    print(text)
    if "--write" in sys.argv[3:]:
        document = DOCUMENT.read_text()
        head, rest = document.split(BEGIN)
        tail = rest.split(END)[1]
        DOCUMENT.write_text(f"{head}{BEGIN}\n{text}{END}{tail}")


main()
