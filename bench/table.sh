#!/bin/sh
# Measures everything in the tables of docs/performance.md and prints them as Markdown; takes about
# ten minutes on a quiet machine. Needs python3 and valgrind.
#
# Usage: bench/table.sh [--write]         --write puts them into docs/performance.md
set -eu
cd "$(dirname "$0")/.."
target="${CARGO_TARGET_DIR:-target}"
case "$target" in /*) ;; *) target="$PWD/$target" ;; esac
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT

load() { cut -d' ' -f1 /proc/loadavg; }

cargo build --release --quiet --locked
cargo build --release --quiet --locked -p csat-experiments --example stage
cargo bench --quiet --locked -p csat-experiments --bench stages --no-run
load >"$out/load"
cargo bench --quiet --locked -p csat-experiments --bench stages >"$out/bench.log" 2>&1 ||
    { cat "$out/bench.log" >&2; exit 1; }
load >>"$out/load"
for threads in 1 2; do
    "$target/release/csat" run --threads "$threads" --json --out "$out/run$threads" \
        >"$out/threads$threads.json"
done
load >>"$out/load"
bench/callgrind.sh 60 >"$out/counts.md"
python3 bench/table.py "$target/criterion" "$out" "$@"
