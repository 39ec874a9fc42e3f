#!/bin/sh
# Our sensing against the thesis's literal method on the same frames, in one run: prints Markdown.
# Needs python3; makes an environment with numpy and shapely in the build folder if there is none.
set -eu
cd "$(dirname "$0")/.."
target="${CARGO_TARGET_DIR:-target}"
python="${CSAT_PYTHON:-$target/literal-python/bin/python}"
if ! "$python" -c 'import numpy, shapely' 2>/dev/null; then
    python3 -m venv "$target/literal-python"
    python="$target/literal-python/bin/python"
    "$python" -m pip install --quiet numpy shapely
fi
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT
cargo build --release --quiet --locked -p csat-experiments --example literal
"$target/release/examples/literal" "$out"
"$python" bench/literal.py "$out"
