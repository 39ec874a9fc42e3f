#!/usr/bin/env bash
# The sweeps behind "The second mission" of docs/lossy-links.md: `tisdale`, 300 s.
#
#   bench/lossy-links-bayes.sh [FOLDER]        default: sweeps/lossy-links-bayes
#   SEEDS=1..50 CALIBRATION=1..200 JOBS=8 bench/lossy-links-bayes.sh
#
# Interrupted, it goes on where it was. Each sweep leaves a report.html with every number, run and 95 % band.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-sweeps/lossy-links-bayes}
if [ -z "${CSAT:-}" ]; then
    cargo build --release
    CSAT=${CARGO_TARGET_DIR:-target}/release/csat
fi

sweep() { # NAME SEEDS OPTIONS...
    local name=$1 seeds=$2
    shift 2
    "$CSAT" sweep tisdale "$@" --seeds "$seeds" ${JOBS:+--jobs "$JOBS"} --resume --no-baseline \
        --out "$out/$name" --set run.duration_s=300 --set netem.trace=none
}

bursts() { # SHARE: a Gilbert-Elliott model that loses this share in bursts of ten on average
    awk -v s="$1" 'BEGIN { printf "{model=\"gilbert-elliott\",p=%.6f,r=0.1}", 0.1 * s / (1 - s) }'
}

calibration() {
    local seeds=${CALIBRATION:-1..200} rough
    rough=(--set netem.radio.range_m=300 --set "netem.radio.loss=$(bursts 0.3)")
    sweep perfect "$seeds" --vary exchange.mode=none,facts+repair
    sweep rough "$seeds" "${rough[@]}" --vary exchange.mode=facts,facts+repair
    sweep fusion "$seeds" --set exchange.mode=snapshot --vary exchange.fusion=chernoff,product
    sweep gauss-markov "$seeds" --set pose.noise=gauss-markov --vary exchange.mode=facts+repair
}

curves() {
    local seeds=${SEEDS:-1..20} modes='exchange.mode=facts,facts+repair'
    sweep range "$seeds" --vary netem.radio.range_m=100,200,400,inf --vary "$modes,snapshot"
    sweep delay "$seeds" --vary netem.radio.delay.mean_s=0,3,30 --vary "$modes"
    sweep loss "$seeds" --vary "netem.radio.loss=iid-60:{model=\"iid\",p=0.6},bursts-60:$(bursts 0.6),bursts-90:$(bursts 0.9)" \
        --vary "$modes"
    sweep budget "$seeds" --vary exchange.budget_bytes_s=50,200,inf --vary 'exchange.mode=facts+repair,snapshot'
}

case ${PART:-all} in
    all) calibration; curves ;;
    calibration | curves) "$PART" ;;
    *) echo "PART is calibration or curves" >&2; exit 2 ;;
esac
