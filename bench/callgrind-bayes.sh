#!/bin/sh
# Instructions per update of each representation of the Bayesian search's belief, as a Markdown table: numbers that
# hold on a busy machine. Needs valgrind. See docs/performance.md.
#
# Usage: bench/callgrind-bayes.sh [FUNCTIONS]     also the FUNCTIONS that take most, per representation
set -eu
cd "$(dirname "$0")/.."
target="${CARGO_TARGET_DIR:-target}"
cargo build --release --quiet --locked -p csat-bayes --example replay
replay="$target/release/examples/replay"
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT
frames=100
"$replay" fly 1 "$frames" "$out/flight.csv"
echo "| belief | million instructions per update |"
echo "|---|---:|"
for name in grid-12.5 grid-0.67 adaptive particles-6400; do
    valgrind --tool=callgrind --toggle-collect='*stage_update*' --callgrind-out-file="$out/counts" \
        --log-file="$out/log" "$replay" repeat "$out/flight.csv" "$name" > /dev/null || { cat "$out/log" >&2; exit 1; }
    callgrind_annotate --auto=no --threshold=99 "$out/counts" > "$out/table"
    awk -v name="$name" -v frames="$frames" '/PROGRAM TOTALS/ {
        gsub(",", "", $1)
        printf "| %s | %.2f |\n", name, $1 / frames / 1e6
    }' "$out/table"
    if [ "${1:-0}" -gt 0 ]; then
        grep -E '^ *[0-9,]+ \(' "$out/table" | grep -v TOTALS | head -n "$1" | sed "s|\[.*||; s|^|    |" >&2
    fi
done
