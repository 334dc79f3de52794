#!/bin/sh
# Fits the FreeSewing drafts with the files of seams in examples/drafts, and DXF drawings with seams as they are proposed, and
# writes docs/drafts.md and its pictures.
#
#     PICTURES=python3 benches/drafts.sh DATA OUT [JUDGE PYTHON]
#
# DATA is the folder with patterns/freesewing, patterns/dxf and bodies, OUT a folder for the fits. JUDGE is the folder of the neutral judge and PYTHON an
# interpreter that has what it needs; without them its columns stay empty. The page's text comes from benches/drafts.notes.md.
# PICTURES is a Python 3.11 or newer with Pillow, python3 if it is not set.
set -eu
data=$1 out=$2 judge=${3:-} python=${4:-python3}
here=$(cd "$(dirname "$0")/.." && pwd)
toile=$here/target/release/toile
mkdir -p "$out"
# PATTERN NAME SEAMS BODY
fit() {
    pattern=$1 name=$2 seams=$3 body=$4
    for millimetres in 20 10; do
        fitted=$out/$name-$millimetres
        "$toile" fit "$pattern" --seams "$seams" --body "$data/bodies/$body.obj" --out "$fitted" \
            --resolution "$millimetres mm" --progress none 2> "$out/$name-$millimetres.log" || true
        if [ -n "$judge" ]; then
            "$python" "$here/benches/drafts_judge.py" "$judge" "$data/bodies/$body.obj" "$fitted" \
                --resolution-mm "$millimetres" > "$fitted/judge.json"
        fi
    done
}
# NAME SIZE BODY: a draft with our file of seams.
draft() {
    pattern=$data/patterns/freesewing/${1}_$2.json
    "$toile" seams suggest "$pattern" --out "$out/$1.suggested.toml"
    fit "$pattern" "$1" "$here/examples/drafts/$1.seams.toml" "$3"
}
# NAME BODY: a drawing with the proposals as they are.
drawing() {
    pattern=$data/patterns/dxf/$1.dxf
    "$toile" seams suggest "$pattern" --out "$out/$1.suggested.toml"
    fit "$pattern" "$1" "$out/$1.suggested.toml" "$2"
}
draft teagan cisFemaleAdult34 female_apose
draft penelope cisFemaleAdult34 female_apose
draft titan cisMaleAdult40 male_apose
draft brian cisMaleAdult40 male_apose
draft aaron cisMaleAdult40 male_apose
drawing teagan_aama_accumark_mm female_apose
drawing penelope_astm_accumark_inch female_apose
drawing titan_aama_clo_mm male_apose
drawing brian_aama_accumark_mm male_apose
drawing gc_tee_aama_clo_mm mean_all
"${PICTURES:-python3}" "$here/benches/drafts.py" "$out" "$here"
