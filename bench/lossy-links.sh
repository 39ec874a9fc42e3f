#!/usr/bin/env bash
# The sweeps behind docs/lossy-links.md: the paper's city with coarser images, 200 s.
#
#   bench/lossy-links.sh [FOLDER]        default: sweeps/lossy-links
#   SEEDS=1..10 JOBS=8 bench/lossy-links.sh
#
# Interrupted, it goes on where it was. Each sweep leaves sweep.csv, sweep_means.csv, report.html.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-sweeps/lossy-links}
cargo build --release
csat=${CARGO_TARGET_DIR:-target}/release/csat

sweep() { # NAME VARY...
    local name=$1
    shift
    "$csat" sweep city "$@" --seeds "${SEEDS:-1..3}" ${JOBS:+--jobs "$JOBS"} --resume \
        --out "$out/$name" --set run.duration_s=200 \
        --set camera.columns=240 --set camera.rows=180 --set camera.min_pixels=2
}

modes='exchange.mode=facts,facts+repair,snapshot'
sweep range --vary netem.radio.range_m=25,50,100,200,400,inf --vary "$modes"
# The same share of messages lost one by one, and in bursts of ten on average.
sweep loss --vary 'netem.radio.loss=iid-30:{model="iid",p=0.3},iid-60:{model="iid",p=0.6},iid-90:{model="iid",p=0.9},bursts-30:{model="gilbert-elliott",p=0.042857,r=0.1},bursts-60:{model="gilbert-elliott",p=0.15,r=0.1},bursts-90:{model="gilbert-elliott",p=0.9,r=0.1}' \
    --vary 'exchange.mode=facts,facts+repair'
sweep delay --vary netem.radio.delay.mean_s=0,1,3,10 --vary 'exchange.mode=facts,facts+repair'
sweep budget --vary exchange.budget_bytes_s=150,300,1000,3000,inf
