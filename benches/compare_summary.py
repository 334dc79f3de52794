"""The table over several garments of benches/compare.sh: OUT NAME ... -> Markdown on the standard output.

A ratio is a rival's cost to the finish line over that of the schedule, the first run of each comparison. Where a rival
did not reach the line its cost is at least what it spent, and the ratio is marked with ">". A garment whose schedule did
not reach it has no ratios and no part in the means.
"""

import json
import math
import pathlib
import sys


def cost(run, times):
    """Fine-equivalent evaluations, processor seconds, and whether the line was reached."""
    reached = run["reached"]
    evaluations = (reached or run)["fine_equivalent"]
    seconds = (times["reached"] or times["total"])["cpu_seconds"]
    return evaluations, seconds, reached is not None


def mean(ratios):
    return math.exp(sum(math.log(r) for r in ratios) / len(ratios))


def told(ratio, exact):
    return f"{'' if exact else '> '}{ratio:.1f}"


def main(out, names):
    garments = []
    for name in names:
        read = json.loads((pathlib.Path(out) / name / "comparison.json").read_text())
        runs = {run["name"]: cost(run, times) for run, times in zip(read["runs"], read["times"]["runs"])}
        garments.append((name, next(iter(runs.values())), dict(list(runs.items())[1:])))
    rivals = [rival for rival in garments[0][2] if all(rival in runs for _, _, runs in garments)]
    if not rivals:
        sys.exit("the comparisons have no rival in common")
    for unit, title in enumerate(["Fine-equivalent evaluations", "Processor seconds"]):
        print(f"\n## {title} to the finish line, over those of the schedule\n")
        print("| garment | schedule | " + " | ".join(rivals) + " | best |")
        print("|---" * (len(rivals) + 3) + "|")
        columns = {rival: [] for rival in [*rivals, "best"]}
        for name, schedule, runs in garments:
            ratios = {rival: (runs[rival][unit] / schedule[unit], runs[rival][2]) for rival in rivals}
            # Of those that reached the line, if any did.
            ratios["best"] = min(ratios.values(), key=lambda r: (not r[1], r[0]))
            own = f"{schedule[unit]:.{2 * unit}f}"
            if not schedule[2]:
                print(f"| {name} | {own}, not reached |" + " – |" * (len(rivals) + 1))
                continue
            for rival, ratio in ratios.items():
                columns[rival].append(ratio)
            print(f"| {name} | {own} | " + " | ".join(told(*ratios[r]) for r in [*rivals, "best"]) + " |")
        if not columns["best"]:
            continue
        means = {r: (mean([x for x, _ in c]), all(e for _, e in c)) for r, c in columns.items()}
        print("| geometric mean | | " + " | ".join(told(*means[r]) for r in [*rivals, "best"]) + " |")


main(sys.argv[1], sys.argv[2:])
