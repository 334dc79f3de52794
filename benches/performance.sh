#!/usr/bin/env bash
# Writes docs/performance.md with its picture: how long fits take, what the kernel takes, how the cost grows.
#
#   benches/performance.sh DATA          on a machine that does nothing else; up to an hour
#   benches/performance.sh DATA quick    one round, nothing finer than 2.5 mm, few evaluations to equilibrium:
#                                        shows in a few minutes that all works, and is no measurement
#
# EQUILIBRIUM_EVALUATIONS may say how many evaluations a run to equilibrium is granted, EQUILIBRIA which are made
# ("10:1e-3 5:0.1": resolution in mm, residual in weights). Each is made once.
#
# DATA has patterns/garmentcode and bodies. Measures and reports stay in target/performance, from which
# benches/performance.py, which needs Python 3 and no packages, writes the page.
set -euo pipefail
cd "$(dirname "$0")/.."
data=$1 mode=${2:-full}
case $mode in
    full) rounds=5 few=3 resolutions=(20 10 5 2.5 1.25 0.8) ;;
    quick) rounds=1 few=1 resolutions=(20 10 5 2.5) ;;
    *) echo "benches/performance.sh DATA [quick]" >&2; exit 2 ;;
esac
# A run that takes longer than this is not repeated, s.
patience=120

work=target/performance
rm -rf "$work"
mkdir -p "$work"
cargo build --release --locked
cargo build --release --locked --example startup

# The names of runs start with what they are for. Reports are kept, results are not.
fit() { # NAME PATTERN MM ROUNDS [OPTION ...]
    local name=$1 pattern=$2 mm=$3 times=$4 round status start
    shift 4
    mkdir -p "$work/runs/$name"
    for round in $(seq "$times"); do
        status=0
        start=$SECONDS
        target/release/toile fit "$data/patterns/garmentcode/$pattern.json" --body "$data/bodies/mean_all.obj" \
            --out "$work/out" --resolution "$mm mm" --threads 2 --progress none "$@" || status=$?
        case $status in
            0 | 4 | 5) mv "$work/out/report.json" "$work/runs/$name/$round.json" ;;
            *) echo "$name: status $status" >&2; exit 1 ;;
        esac
        echo "$name, round $round: status $status, $((SECONDS - start)) s"
        echo "$status" > "$work/runs/$name/status"
        [ $((SECONDS - start)) -le $patience ] || break
    done
    rm -rf "$work/out"
}

for mm in "${resolutions[@]}"; do
    case $mm in
        5) times=$rounds ;;
        1.25 | 0.8) times=1 ;;
        *) times=$few ;;
    esac
    fit "tee-$mm" tee "$mm" "$times"
done
fit dress-5 dress 5 "$rounds"

RAYON_NUM_THREADS=2 target/release/examples/startup "$data/patterns/garmentcode/tee.json" "$data/bodies/mean_all.obj" \
    5 "$rounds" | tee "$work/startup.txt"
CRITERION_HOME=$PWD/$work/criterion cargo bench --locked --bench hot_paths

most=${EQUILIBRIUM_EVALUATIONS:-$([ "$mode" = full ] && echo 20000 || echo 500)}
equilibrium() { # NAME MM RESIDUAL
    printf 'equilibrium_residual = %s\n' "$3" > "$work/$1.toml"
    printf 'equilibrium_evaluations = %s\n' "$most" >> "$work/$1.toml"
    fit "$1" dress "$2" 1 --until equilibrium --settings "$work/$1.toml"
}
for run in ${EQUILIBRIA-$([ "$mode" = full ] && echo 10:1e-3 5:0.1 5:1e-3 || echo 10:1e-3)}; do
    equilibrium "equilibrium-${run/:/-}" "${run%:*}" "${run#*:}"
done

commit=$(git rev-parse --short HEAD)
[ -z "$(git status --porcelain -- src data Cargo.toml Cargo.lock)" ] || commit="$commit, with changes"
cat > "$work/facts" <<FACTS
mode=$mode
options=${EQUILIBRIA+EQUILIBRIA="$EQUILIBRIA" }${EQUILIBRIUM_EVALUATIONS+EQUILIBRIUM_EVALUATIONS=$EQUILIBRIUM_EVALUATIONS }
commit=$commit
cpu=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
processors=$(nproc)
rustc=$(rustc --version | cut -d' ' -f1,2)
load=$(cut -d' ' -f1 /proc/loadavg)
FACTS
python3 benches/performance.py "$work" docs
