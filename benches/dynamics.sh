#!/usr/bin/env bash
# Writes docs/dynamics.md: garments that walk, and how long a simulator takes to come to rest from a fit and from others' starts.
#
#     benches/dynamics.sh DATA OUT
#
# DATA is the folder with patterns/garmentcode, bodies and animation, OUT a folder for the results; what is in it already is
# not computed again. The notes come from benches/dynamics.notes.md.
set -euo pipefail
cd "$(dirname "$0")/.."
data=$1 out=$2
toile=target/release/toile
cargo build --release --locked
mkdir -p "$out"
commit=$(git rev-parse --short HEAD)
[ -z "$(git status --porcelain -- src data Cargo.toml Cargo.lock)" ] || commit="$commit, with changes"
cpu=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
body=$data/bodies/female_apose.obj

for garment in tee dress pants jumpsuit pencil_skirt circle_skirt upstream_shirt lapel_vest; do
    for mm in 10 20; do
        walk=$out/$garment-$mm-walk
        [ ! -f "$walk/simulation.json" ] || continue
        "$toile" fit "$data/patterns/garmentcode/$garment.json" --body "$body" --out "$out/$garment-$mm" \
            --resolution "$mm mm" --progress none || true
        "$toile" simulate "$out/$garment-$mm" --body "$data/animation/walking_female.glb" --out "$walk" --progress none
    done
done
for garment in tee dress circle_skirt pencil_skirt upstream_shirt lapel_vest; do
    [ ! -f "$out/$garment-rest/dynamics.md" ] || continue
    # It ends with status 5 where the schedule's garment does not come to rest.
    "$toile" compare "$data/patterns/garmentcode/$garment.json" --body "$body" --dynamics --out "$out/$garment-rest" \
        --resolution "20 mm" > /dev/null || true
done

{
    cat <<HEAD
# Dynamics

What the hand-off is worth to an explicit simulator. Machine: $cpu, $(nproc) processors, $(rustc --version | cut -d' ' -f1,2). Commit
$commit. Written by \`benches/dynamics.sh DATA OUT\`. Processor seconds are those of a machine that was shared with other work.

## A walk

\`walking_female.glb\`, 72 frames at 24 a second, with the default settings of \`toile simulate\`; the fabric is \`neutral\`, which bears 5 %. Penetration and
crossings are by exact tests at the end of every frame, and of the worst one.

Cloth that skin leaves no room between is let be (theory, equation 30): the first depth is of the others, the second of all.

| garment | particles | deepest inside, mm | most without room | largest stretch | crossings with the body / of the cloth | while it settled, m/s | steps a frame | CPU s a frame |
|---|---|---|---|---|---|---|---|---|
HEAD
    python3 - "$out" <<'ROWS'
import json, pathlib, sys
for garment in ["tee", "dress", "pants", "jumpsuit", "pencil_skirt", "circle_skirt", "upstream_shirt", "lapel_vest"]:
    for mm in [10, 20]:
        report = json.loads((pathlib.Path(sys.argv[1]) / f"{garment}-{mm}-walk" / "simulation.json").read_text())
        fit = json.loads((pathlib.Path(sys.argv[1]) / f"{garment}-{mm}" / "report.json").read_text())
        totals, run = report["totals"], report["run"]
        print(f"| `{garment}`, {mm} mm | {fit['levels'][-1]['particles']} | {totals['deepest_with_room_mm']:.2f} / {totals['deepest_mm']:.2f} "
              f"| {totals['most_particles_pinched']} | {100 * totals['largest_stretch']:.1f} % "
              f"| {totals['most_body_intersections']} / {totals['most_cloth_intersections']} | {report['settled']['largest_speed']:.2f} "
              f"| {totals['steps'] / totals['frames']:.0f} | {run['cpu_seconds_per_frame']:.2f} |")
ROWS
    cat <<HEAD

## Coming to rest

Steps until all speeds stay below 1 mm/s rms, on a body that stands still, at 20 mm, drag 2 a second: from a fit on all levels, from the same
carried on to equilibrium (0.1 weights), from a fit on the finest level alone by the same minimizer and by mass-scaled dynamic relaxation, and from
the panels as they are placed, which the simulator then has to sew itself. Speeds are the largest of any particle.
HEAD
    for garment in tee dress circle_skirt pencil_skirt upstream_shirt lapel_vest; do
        printf '\n'
        cat "$out/$garment-rest/dynamics.md"
    done
    [ ! -f benches/dynamics.notes.md ] || { printf '\n'; cat benches/dynamics.notes.md; }
} > docs/dynamics.md.new
mv docs/dynamics.md.new docs/dynamics.md
