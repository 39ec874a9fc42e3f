#!/usr/bin/env bash
# The sweeps behind docs/lossy-links.md: the paper's city with coarser images, 200 s.
#
#   bench/lossy-links.sh [FOLDER]        default: sweeps/lossy-links
#   SEEDS=2001..2020 JOBS=8 bench/lossy-links.sh
#   CSAT=target/release/csat bench/lossy-links.sh      without building
#
# Interrupted, it goes on where it was. Each sweep leaves sweep.csv, sweep_means.csv, report.html.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-sweeps/lossy-links}
if [ -z "${CSAT:-}" ]; then
    cargo build --release
    CSAT=${CARGO_TARGET_DIR:-target}/release/csat
fi

sweep() { # NAME SCENARIO VARY...
    local name=$1 scenario=$2
    shift 2
    "$CSAT" sweep "$scenario" "$@" --seeds "${SEEDS:-2001..2005}" ${JOBS:+--jobs "$JOBS"} --resume \
        --out "$out/$name" --set run.duration_s=200 \
        --set camera.columns=240 --set camera.rows=180 --set camera.min_pixels=2
}

planners='guidance.criterion=str3,str4,str5'
# Without radio `circles` divides the region once and for all; nothing is planned.
sweep range city --vary netem.radio.range_m=25,50,100,200,inf --vary "guidance.criterion=str3,str4,str5,circles"
# More seeds, for docs/planner.md.
SEEDS=${SEEDS:-2001..2020} sweep fresh city --vary guidance.criterion=str4,str5 --set netem.radio.range_m=100 --no-baseline
sweep range-fleet city --vary netem.radio.range_m=25,50,100,200 --vary guidance.objective=own,fleet \
    --set guidance.criterion=str4 --no-baseline
sweep range-town helsinki-05 --vary netem.radio.range_m=50,100,200,inf --vary "$planners"
sweep range-8 city --vary netem.radio.range_m=50,100 --vary "$planners" --set agents.count=8 --no-baseline
sweep delay city --vary netem.radio.delay.mean_s=1,3,10 --vary "$planners"
# The same share of messages lost one by one, and in bursts of ten on average.
losses='netem.radio.loss=iid-60:{model="iid",p=0.6},bursts-60:{model="gilbert-elliott",p=0.15,r=0.1},iid-90:{model="iid",p=0.9},bursts-90:{model="gilbert-elliott",p=0.9,r=0.1}'
sweep loss city --vary "$losses" --vary "$planners"
sweep budget city --vary exchange.budget_bytes_s=150,300,1000,3000,inf
sweep budget-range city --vary netem.radio.range_m=50,100,200 --vary exchange.budget_bytes_s=300,1000,3000,inf
modes='exchange.mode=facts,facts+repair,snapshot'
sweep modes-range city --vary netem.radio.range_m=25,100,200 --vary "$modes"
sweep modes-delay city --vary netem.radio.delay.mean_s=1,3,10 --vary "$modes"
sweep modes-loss city --vary "$losses" --vary exchange.mode=facts,facts+repair
