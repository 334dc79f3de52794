#!/usr/bin/env bash
# Fits every pattern of a corpus several times, on one thread and on two by turns, and tells how many different
# garments come of it: one, if the same input gives the same bytes.
#
#   benches/repeats.sh DATA [RUNS] [RESOLUTION_MM]
#
# DATA has patterns/garmentcode, its index beside it, and bodies.
set -euo pipefail
cd "$(dirname "$0")/.."
data=$1 runs=${2:-10} mm=${3:-10}
cargo build --release --locked --quiet
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
different=0
for pattern in "$data"/patterns/garmentcode/*.json; do
    name=$(basename "$pattern" .json)
    body=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))[sys.argv[2]]["body"])' \
        "$data/patterns/garmentcode.index.json" "$name")
    : > "$out/digests"
    for ((run = 0; run < runs; run++)); do
        # Status 4, a gate failed, writes its files all the same.
        target/release/toile fit "$pattern" --body "$data/bodies/$body" --out "$out/fit" --resolution "$mm mm" \
            --threads $((run % 2 + 1)) --progress none || [ $? -eq 4 ]
        sha256sum < "$out/fit/garment.obj" >> "$out/digests"
    done
    count=$(sort -u "$out/digests" | wc -l)
    printf '%-28s %2d runs, %d different\n' "$name" "$runs" "$count"
    [ "$count" -eq 1 ] || different=$((different + 1))
done
echo "patterns with more than one result: $different"
[ "$different" -eq 0 ]
