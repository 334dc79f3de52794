"""The tables over several garments of benches/compare.sh: OUT NAME ... -> Markdown on the standard output.

For each finish line, and for evaluations and processor seconds: a rival's cost over that of the schedule, the first run of
each comparison. Where a rival did not reach the line its cost is at least what it spent, and the ratio is marked with ">".
A run that could not go on to the cap, for instance because its seams never closed, "failed": it has no part in the means,
which are then marked too. A garment whose schedule did not reach the line has no ratios and no part in the means.
"""

import json
import math
import pathlib
import sys

LINES = {"strain": "to little strain", "settled": "until settled", "equilibrium": "to equilibrium"}


def cost(run, times, line, cap):
    """Fine-equivalent evaluations, processor seconds, whether the line was reached, and whether it never can be."""
    reached = run["reached"][line]
    evaluations = (reached or run)["fine_equivalent"]
    seconds = (times["reached"][line] or times["total"])["cpu_seconds"]
    failed = reached is None and run["levels"][-1]["evaluations"] < cap
    return evaluations, seconds, reached is not None, failed


def mean(ratios):
    return math.exp(sum(math.log(r) for r in ratios) / len(ratios))


def told(ratio, exact):
    return "failed" if ratio is None else f"{'' if exact else '> '}{ratio:.1f}"


def table(garments, rivals, unit):
    """Garments are names with the costs of the schedule and of each rival; the unit is 0 or 1, as in `cost`."""
    print("| garment | schedule | " + " | ".join(rivals) + " | best |")
    print("|---" * (len(rivals) + 3) + "|")
    columns = {rival: [] for rival in [*rivals, "best"]}
    for name, schedule, runs in garments:
        ratios = {r: (None if runs[r][3] else runs[r][unit] / schedule[unit], runs[r][2]) for r in rivals}
        # Of those that reached the line; if none did, the least that is known of any.
        ratios["best"] = min(ratios.values(), key=lambda r: (not r[1], r[0] is None, r[0]))
        own = f"{schedule[unit]:.{2 * unit}f}"
        if not schedule[2]:
            print(f"| {name} | {own}, not reached |" + " – |" * (len(rivals) + 1))
            continue
        for rival, ratio in ratios.items():
            columns[rival].append(ratio)
        print(f"| {name} | {own} | " + " | ".join(told(*ratios[r]) for r in [*rivals, "best"]) + " |")
    if columns["best"]:
        known = {r: [x for x, _ in c if x is not None] for r, c in columns.items()}
        means = {r: (mean(known[r]) if known[r] else None, all(e for _, e in c)) for r, c in columns.items()}
        print("| geometric mean | | " + " | ".join(told(*means[r]) for r in [*rivals, "best"]) + " |")


def main(out, names):
    read = {name: json.loads((pathlib.Path(out) / name / "comparison.json").read_text()) for name in names}
    rivals = [run["name"] for run in read[names[0]]["runs"][1:]]
    rivals = [r for r in rivals if all(r in [run["name"] for run in made["runs"]] for made in read.values())]
    if not rivals:
        sys.exit("the comparisons have no rival in common")
    until = read[names[0]]["finish_line"]["until"]
    for line in ["equilibrium"] if until == "equilibrium" else ["strain", "settled"]:
        garments = []
        for name, made in read.items():
            runs = {run["name"]: cost(run, times, line, made["cap"]) for run, times in zip(made["runs"], made["times"]["runs"])}
            garments.append((name, next(iter(runs.values())), runs))
        for unit, title in enumerate(["Fine-equivalent evaluations", "Processor seconds"]):
            print(f"\n### {title} {LINES[line]}, over those of the schedule\n")
            table(garments, rivals, unit)


main(sys.argv[1], sys.argv[2:])
