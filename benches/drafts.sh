#!/bin/sh
# Fits the FreeSewing drafts with the files of seams in examples/drafts and writes docs/drafts.md and its pictures.
#
#     PICTURES=python3 benches/drafts.sh DATA OUT [JUDGE PYTHON]
#
# DATA is the folder with patterns/freesewing and bodies, OUT a folder for the fits. JUDGE is the folder of the neutral judge and PYTHON an
# interpreter that has what it needs; without them its columns stay empty. The page's text comes from benches/drafts.notes.md.
# PICTURES is a Python 3.11 or newer with Pillow, python3 if it is not set.
set -eu
data=$1 out=$2 judge=${3:-} python=${4:-python3}
here=$(cd "$(dirname "$0")/.." && pwd)
toile=$here/target/release/toile
mkdir -p "$out"
fit() {
    name=$1 size=$2 body=$3 fabric=$4
    pattern=$data/patterns/freesewing/${name}_$size.json seams=$here/examples/drafts/$name.seams.toml
    "$toile" seams suggest "$pattern" --out "$out/$name.suggested.toml"
    for millimetres in 20 10; do
        fitted=$out/$name-$millimetres
        "$toile" fit "$pattern" --seams "$seams" --body "$data/bodies/$body.obj" --out "$fitted" \
            --resolution "$millimetres mm" --fabric "$fabric" --progress none 2> "$out/$name-$millimetres.log" || true
        if [ -n "$judge" ]; then
            "$python" "$here/benches/drafts_judge.py" "$judge" "$data/bodies/$body.obj" "$fitted" \
                --resolution-mm "$millimetres" > "$fitted/judge.json"
        fi
    done
}
fit teagan cisFemaleAdult34 female_apose neutral
fit penelope cisFemaleAdult34 female_apose neutral
fit titan cisMaleAdult40 male_apose neutral
fit brian cisMaleAdult40 male_apose neutral
fit aaron cisMaleAdult40 male_apose neutral
"${PICTURES:-python3}" "$here/benches/drafts.py" "$out" "$here"
