#!/usr/bin/env bash
# Instructions per spring of one energy with its gradient and one curvature, on one thread, against the figure in
# instructions.txt. Seconds differ from machine to machine and from minute to minute; this count does not.
#
#   benches/instructions.sh           fails where the count is more than a tenth above the figure
#   benches/instructions.sh --renew   writes the figure
set -euo pipefail
cd "$(dirname "$0")/.."
figure=benches/instructions.txt

skip() {
    echo "The instructions of the kernel are not counted: $1."
    exit 0
}
command -v valgrind >/dev/null || skip "there is no valgrind"
# The figure is that of AVX2; other processors run other instructions.
grep -qw avx2 /proc/cpuinfo 2>/dev/null || skip "this processor has no AVX2"

program=$(cargo bench --locked --no-run --bench kernel_instructions 2>&1 | tee -a /dev/stderr \
    | sed -n 's/.*Executable.*(\(.*\))$/\1/p')
[ -x "$program" ] || { echo "cargo named no program to count." >&2; exit 1; }

springs=0
collected=0
count() { # evaluations
    local out
    out=$(mktemp)
    springs=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null "$program" "$1" 2>"$out")
    collected=$(sed -n 's/.*Collected : \([0-9]*\).*/\1/p' "$out")
    rm -f "$out"
    [ -n "$collected" ] || { echo "valgrind counted nothing." >&2; exit 1; }
}
# What happens before the first evaluation is in both.
count 2
few=$collected
count 12
# Of ten evaluations, hence in tenths of an instruction.
now=$(( (collected - few) / springs ))

tenths() { printf '%d.%d' $(($1 / 10)) $(($1 % 10)); }
if [ "${1:-}" = --renew ]; then
    tenths "$now" > "$figure"
    echo >> "$figure"
    echo "$figure is now $(tenths "$now") instructions a spring."
    exit 0
fi
was=$(sed -n '1s/\.//p' "$figure")
echo "Kernel: $(tenths "$now") instructions a spring; the committed figure is $(tenths "$was")."
if [ "$now" -gt $((was + was / 10)) ]; then
    echo "More than a tenth above it. If the kernel has to do more, or a new compiler brought this, say so in the" >&2
    echo "commit that renews the figure: benches/instructions.sh --renew" >&2
    exit 1
fi
