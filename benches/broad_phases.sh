#!/usr/bin/env bash
# Writes docs/broad_phases.md: ways to look for the nearest skin, by single questions and in whole simulations.
#
#     benches/broad_phases.sh DATA OUT
#
# DATA is the folder with patterns/garmentcode, bodies and animation, OUT a folder for the results; what is in it already is
# not computed again. The notes come from benches/broad_phases.notes.md.
set -euo pipefail
cd "$(dirname "$0")/.."
data=$1 out=$2
toile=target/release/toile
cargo build --release --locked
program=$(cargo bench --locked --no-run --bench broad_phases 2>&1 | tee /dev/stderr | sed -n 's/.*Executable.*(\(.*\))$/\1/p')
[ -x "$program" ] || { echo "cargo named no program to run." >&2; exit 1; }
mkdir -p "$out"
commit=$(git rev-parse --short HEAD)
[ -z "$(git status --porcelain -- src data benches Cargo.toml Cargo.lock)" ] || commit="$commit, with changes"
cpu=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
body=$data/bodies/female_apose.obj walk=$data/animation/walking_female.glb
frames=24
# Simulations of each kind: of the largest garment, which takes minutes, one.
takes() { [ "$1" = dress-10 ] && echo 1 || echo 3; }

garments=()
for garment in tee dress; do
    for mm in 20 10; do
        name=$garment-$mm
        [ -f "$out/$name/state.toile" ] || "$toile" fit "$data/patterns/garmentcode/$garment.json" --body "$body" \
            --out "$out/$name" --resolution "$mm mm" --progress none || true
        # The kinds take turns, so that what else the machine does meets all of them.
        for take in $(seq "$(takes "$name")"); do
            for kind in tree aligned-boxes oriented-boxes spheres maps; do
                for where in standing walking; do
                    folder=$out/$name-$where-$kind-$take
                    [ "$where $kind" != "walking maps" ] || continue
                    [ ! -f "$folder/simulation.json" ] || continue
                    moving=$body
                    [ $where = standing ] || moving=$walk
                    "$toile" simulate "$out/$name" --body "$moving" --out "$folder" --frames $frames --broad-phase $kind \
                        --measure-every $frames --draw-every 0 --threads 1 --progress none
                done
            done
        done
        garments+=("\`$garment\`, $mm mm=$out/$name,$out/$name-walking-tree-1")
    done
done

{
    cat <<HEAD
# How the nearest skin is looked for

What \`toile simulate --broad-phase\` chooses among: a tree of boxes over all triangles; one box, oriented box or sphere around each patch of
a hundred triangles or two (Kaynar Kabul 2004); depth maps from the front and from behind, with the tree where they are not sure (Vassilev,
Spanlang and Chrysanthou 2001, section 4.2). [theory.md](theory.md#dynamics) tells how. Machine: $cpu, one thread, $(rustc --version | cut -d' ' -f1,2). Commit
$commit. Written by \`benches/broad_phases.sh DATA OUT\`; processor seconds, on a machine that was shared with other work, medians of
five rounds, and of three simulations that took turns (\`dress\` at 10 mm: one).

## Single questions

HEAD
    "$program" "$body" "$walk" "${garments[@]}"
    cat <<HEAD

## Whole simulations

$frames frames at 24 a second on \`female_apose\`, which stands still, and along \`walking_female.glb\`: processor seconds a frame, of which most are spent on the
cloth itself. At the end, by exact tests: the deepest particle inside the body, and triangles of the cloth that cross the body. *Same* says whether all
positions of all frames are, byte by byte, those of the tree.

| garment | | standing, s a frame | at the end | same | walking, s a frame | at the end | same |
|---|---|---|---|---|---|---|---|
HEAD
    python3 - "$out" <<'ROWS'
import json, pathlib, statistics, sys
out = pathlib.Path(sys.argv[1])
def cells(name, where, kind):
    folders = sorted(out.glob(f"{name}-{where}-{kind}-[0-9]"))
    reports = [json.loads((folder / "simulation.json").read_text()) for folder in folders]
    seconds = statistics.median(report["run"]["cpu_seconds_per_frame"] for report in reports)
    last = reports[0]["frames"][-1]["measured"]
    motions = [(folder / "motion.toile").read_bytes() for folder in [*folders, out / f"{name}-{where}-tree-1"]]
    same = "yes" if all(motion == motions[-1] for motion in motions) else "no"
    return f"{seconds:.3f} | {last['deepest_mm']:.2f} mm, {last['body_intersections']} | {same}"
for garment in ["tee", "dress"]:
    for mm in [20, 10]:
        for kind in ["tree", "aligned-boxes", "oriented-boxes", "spheres", "maps"]:
            name = f"{garment}-{mm}"
            walking = "- | - | -" if kind == "maps" else cells(name, "walking", kind)
            print(f"| `{garment}`, {mm} mm | `{kind}` | {cells(name, 'standing', kind)} | {walking} |")
ROWS
    [ ! -f benches/broad_phases.notes.md ] || { printf '\n'; cat benches/broad_phases.notes.md; }
} > docs/broad_phases.md.new
mv docs/broad_phases.md.new docs/broad_phases.md
