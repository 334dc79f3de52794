#!/usr/bin/env bash
# Writes docs/results.md: the independent judge's table over a corpus of patterns, with machine and commit.
#
#   benches/results.sh JUDGE DATA [RESOLUTION_MM ...]
#
# STARTS may say how many garments with their panels in wrong places (starts.py) are to be fitted besides, at 20 mm.
# JUDGE is the folder with run_corpus.py; DATA has patterns/garmentcode and bodies. PYTHON may name an
# interpreter that has the judge's requirements. Results go to target/results.
set -euo pipefail
cd "$(dirname "$0")/.."
judge=$1 data=$2
shift 2
resolutions=("$@")
[ ${#resolutions[@]} -gt 0 ] || resolutions=(10 5)
python=${PYTHON:-python3}

cargo build --release --locked
commit=$(git rev-parse --short HEAD)
[ -z "$(git status --porcelain -- src data Cargo.toml Cargo.lock)" ] || commit="$commit, with changes"
cpu=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)

page=$(mktemp)
trap 'rm -f "$page"' EXIT
cat > "$page" <<HEAD
# Results

What an independent judge says of every pattern of a corpus of real sewing patterns (GarmentCode), fitted with the
default settings on the bodies that its index names. The judge reads the pattern, the body and \`garment.obj\`, and
nothing else; its hand-off gate asks for complete panels, seams closed within 1 mm, no intersection with the body or of the
cloth with itself, and a stretch of at most 1 % on average and 5 % at the 99th percentile, less what gathers impose.

Machine: $cpu, $(nproc) processors, $(rustc --version | cut -d' ' -f1,2). Commit $commit. The command that wrote this page:
\`${STARTS:+STARTS=$STARTS }benches/results.sh JUDGE DATA ${resolutions[*]}\`. Seconds are from a machine that was shared with other work; trust
processor seconds rather than wall seconds, and both within a factor of 1.5.
HEAD
# The judge's table of the corpus.
corpus() { # NAME MM TITLE [OPTION ...]
    local out=target/results/$1 mm=$2 title=$3
    shift 3
    rm -rf "$out"
    mkdir -p "$out"
    "$python" "$judge/run_corpus.py" target/release/toile "$data/patterns/garmentcode" --bodies "$data/bodies" \
        --out "$out" --resolution-mm "$mm" "$@" | tee "$out/table.txt" || true # not every garment has to pass
    {
        printf '\n## %s\n\n```text\n' "$title"
        # Of a failed verdict the reason is enough.
        sed -E 's/FAIL exit [0-9]+:.*; results in [^;]*; /FAIL /; s/ +static / /; s/ +- +(PASS|FAIL)/  \1/' "$out/table.txt"
        printf '```\n'
    } >> "$page"
}

for mm in "${resolutions[@]}"; do
    corpus "$mm" "$mm" "At $mm mm"
done
corpus auto 10 "At 10 mm, placed by themselves: the patterns' placements unread" --extra "--place auto"
corpus woman 10 "At 10 mm, on a woman of 1.62 m (female_apose)" --body "$data/bodies/female_apose.obj"
corpus man 10 "At 10 mm, on another man (male_apose)" --body "$data/bodies/male_apose.obj"
if [ -n "${STARTS:-}" ]; then
    out=target/results/starts
    rm -rf "$out" "$out.patterns"
    mkdir -p "$out"
    "$python" benches/starts.py "$data/patterns/garmentcode" "$out.patterns" "$STARTS"
    "$python" "$judge/run_corpus.py" target/release/toile "$out.patterns" --bodies "$data/bodies" --out "$out" \
        --resolution-mm 20 --json "$out.json" > /dev/null || true # strain at 20 mm is seldom within the limits
    "$python" benches/starts_summary.py "$out.json" >> "$page"
fi
[ ! -f benches/results.notes.md ] || { printf '\n'; cat benches/results.notes.md; } >> "$page"
cp "$page" docs/results.md
