#!/usr/bin/env bash
# Writes docs/comparison.md: the schedule of levels against single-resolution rivals on several garments.
#
#   benches/compare.sh DATA OUT NAME ...
#
# DATA has patterns/garmentcode with its index beside it, and bodies; OUT receives a folder for each NAME, a garment of
# the index. COMPARE holds options for `toile compare`, such as "--resolution '5 mm' --cap 8000"; PYTHON may name an
# interpreter. FINER may hold names of garments for a second part of the page at 5 mm, and BALANCED for a third, all the
# way to equilibrium at 20 mm. A folder in OUT that has a comparison already is not made again, so that an interrupted
# run goes on.
set -euo pipefail
cd "$(dirname "$0")/.."
data=$1 out=$2
shift 2
[ $# -gt 0 ] || { echo "name at least one garment of $data/patterns/garmentcode.index.json" >&2; exit 2; }
python=${PYTHON:-python3}

cargo build --release --locked
commit=$(git rev-parse --short HEAD)
[ -z "$(git status --porcelain -- src data Cargo.toml Cargo.lock)" ] || commit="$commit, with changes"
cpu=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
page=$(mktemp)
trap 'rm -f "$page"' EXIT

# TITLE FOLDER OPTIONS NAME ...: a part of the page, with its runs where they are missing.
part() {
    local title=$1 folder=$2 options name body
    eval "options=($3)"
    shift 3
    for name in "$@"; do
        [ ! -f "$folder/$name/comparison.json" ] || continue
        body=$("$python" -c 'import json, sys; print(json.load(open(sys.argv[1]))[sys.argv[2]]["body"])' \
            "$data/patterns/garmentcode.index.json" "$name")
        echo "== $name on $body"
        # 4 and 5 say that the schedule did not reach its line, which is a result.
        target/release/toile compare "$data/patterns/garmentcode/$name.json" --body "$data/bodies/$body" \
            --out "$folder/$name" "${options[@]}" || [ $? -eq 4 ] || [ $? -eq 5 ]
    done
    printf '\n## %s\n' "$title" >> "$page"
    "$python" benches/compare_summary.py "$folder" "$@" >> "$page"
    for name in "$@"; do
        { printf '\n'; sed 's/^# /### /' "$folder/$name/comparison.md"; } >> "$page"
    done
}

cat > "$page" <<HEAD
# Comparison

The schedule of levels against single-resolution rivals: the same pattern, body, fabric and settings, to the same finish
lines, from flat panels. [The guide](guide.md#comparing-minimizers) tells how it is measured, what each line says, and what
it cannot tell.

Machine: $cpu, $(nproc) processors, $(rustc --version | cut -d' ' -f1,2). Commit $commit. The command that wrote this page:
\`${COMPARE:+COMPARE=\"$COMPARE\" }${FINER:+FINER=\"$FINER\" }${BALANCED:+BALANCED=\"$BALANCED\" }benches/compare.sh DATA OUT $*\`.
Trust evaluations exactly, and processor seconds within a factor of 1.5: the machine may have been shared with other work.
HEAD
part "All garments" "$out" "${COMPARE:-}" "$@"
# Unquoted: they are lists.
[ -z "${FINER:-}" ] || part "At 5 mm" "$out/finer" "--resolution '5 mm' --cap 4000" $FINER
balanced="--until equilibrium --resolution '20 mm' --cap 20000 --rivals newton,conjugate-gradient,lbfgs,dynamic-relaxation"
[ -z "${BALANCED:-}" ] || part "Equilibrium at 20 mm" "$out/balanced" "$balanced" $BALANCED
cp "$page" docs/comparison.md
