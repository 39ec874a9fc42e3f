#!/bin/sh
# csat's filters of the Bayesian search beside Stone Soup's particle filter, on the same recorded flights with the same
# likelihoods: a table in Markdown, with ratios. See docs/performance.md.
#
# Usage: bench/stonesoup.sh [FLIGHTS] [FRAMES]     default: 10 flights of 400 frames
#
# Needs python3; makes an environment with stonesoup in the build folder if there is none ($STONESOUP_PYTHON: another
# one). For each flight csat and Stone Soup run one after the other, each on one core.
set -eu
cd "$(dirname "$0")/.."
target="${CARGO_TARGET_DIR:-target}"
python="${STONESOUP_PYTHON:-$target/stonesoup-python/bin/python}"
if ! "$python" -c 'import stonesoup' 2>/dev/null; then
    python3 -m venv "$target/stonesoup-python"
    python="$target/stonesoup-python/bin/python"
    "$python" -m pip install --quiet 'stonesoup==1.9.1'
fi
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT
cargo build --release --quiet --locked -p csat-bayes --example replay
replay="$target/release/examples/replay"
for seed in $(seq "${1:-10}"); do
    "$replay" fly "$seed" "${2:-400}" "$out/$seed.csv"
    "$replay" likelihood "$out/$seed.csv" | "$python" bench/stonesoup/filter.py "$out/$seed.csv" check
    "$replay" filter "$out/$seed.csv" > "$out/$seed.json"
    "$python" bench/stonesoup/filter.py "$out/$seed.csv" >> "$out/$seed.json"
    echo "flight $seed" >&2
done
"$python" bench/stonesoup/table.py "$out"/*.json
