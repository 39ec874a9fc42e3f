#!/bin/sh
# Instructions per call of every stage of an agent-step, as a Markdown table: numbers that hold on a
# busy machine. Needs valgrind. See docs/performance.md.
#
# Usage: bench/callgrind.sh [SECONDS]     the moment of the `city` mission to record (60)
#
# The mission up to that moment runs under valgrind too, which takes minutes, but only what happens
# inside functions named `stage_*` is counted. One run counts them all: hence no gungraun, which
# would fly the mission once per stage.
set -eu
cd "$(dirname "$0")/.."
seconds="${1:-60}"
target="${CARGO_TARGET_DIR:-target}"
cargo build --release --quiet --locked --example stage
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT
calls="$(RAYON_NUM_THREADS=1 valgrind --tool=callgrind --toggle-collect='*stage_*' \
    --callgrind-out-file="$out/counts" --log-file="$out/log" \
    "$target/release/examples/stage" "$seconds")" || { cat "$out/log" >&2; exit 1; }
echo "| stage at $seconds s | million instructions |"
echo "|---|---:|"
callgrind_annotate --inclusive=yes --auto=no --threshold=100 "$out/counts" | awk -v calls="$calls" '
    match($0, /recorded::stages::stage_[a-z0-9_]+/) {
        name = substr($0, RSTART + 24, RLENGTH - 24)
        count = $1
        gsub(",", "", count)
        if (!(name in seen)) printf "| %s | %.2f |\n", name, count / calls / 1e6
        seen[name] = 1
    }' | LC_ALL=C sort
