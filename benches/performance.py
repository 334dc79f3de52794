"""Writes performance.md and pictures/growth.svg from what benches/performance.sh has measured.

    python3 benches/performance.py target/performance docs

Needs no packages. Figures are medians over the rounds; a range beside one is from the least to the largest.
"""

import json
import math
import pathlib
import re
import statistics
import sys

# The goals: at least, and ambitious. Wall seconds where no unit is said.
HAND_OFF_MARKS = {"tee-5": (1.0, 0.4), "dress-5": (2.5, 1.0)}
EQUILIBRIUM = {  # what it is, the marks
    "equilibrium-10-1e-3": ("dress, 10 mm, 1e-3 weights", "15 / 3"),
    "equilibrium-5-0.1": ("dress, 5 mm, 0.1 weights", "60 / 5"),
    "equilibrium-5-1e-3": ("dress, 5 mm, 1e-3 weights", "reached / 20"),
}
SPRING_MARKS = (4.0, 2.0)  # ns, two threads
SET_UP_MARKS = (150, 50)  # ms, 30k particles
MEMORY_MARKS = (1.0, 0.6)  # GB, a million particles


class Run:
    """The reports of all rounds of one run."""

    def __init__(self, folder):
        # By number: the tenth comes after the ninth.
        files = sorted(folder.glob("*.json"), key=lambda file: int(file.stem))
        self.reports = [json.loads(file.read_text()) for file in files]
        self.status = int((folder / "status").read_text())
        self.last = self.reports[-1]

    def of_run(self, field):
        values = [report["run"][field] for report in self.reports]
        return statistics.median(values) if None not in values else math.nan

    def spread(self, field):
        """The median, with the range if there are several rounds."""
        values = [report["run"][field] for report in self.reports]
        if None in values or len(values) == 1:
            return f"{self.of_run(field):.2f}"
        return f"{self.of_run(field):.2f} ({min(values):.2f}-{max(values):.2f})"

    def stage(self, name, field):
        stages = [stage for report in self.reports for stage in report["run"]["stages"] if stage["name"] == name]
        values = [stage[field] for stage in stages]
        return statistics.median(values) if values and None not in values else math.nan

    @property
    def particles(self):
        return self.last["levels"][-1]["particles"]

    @property
    def peak(self):
        """MB, of the solve."""
        return self.of_run("solve_peak_memory_bytes") / 1e6

    @property
    def evaluations(self):
        """On the finest level."""
        return self.last["levels"][-1]["evaluations"]

    @property
    def nanoseconds_an_evaluation(self):
        """CPU ns of the finest level for each particle and evaluation."""
        seconds = self.stage(f"level {len(self.last['levels'])}", "cpu_seconds")
        return seconds / self.particles / max(self.evaluations, 1) * 1e9

    @property
    def cpu_a_particle(self):
        """s"""
        return self.of_run("solve_cpu_seconds") / self.particles


def table(head, rows):
    line = lambda cells: "| " + " | ".join(str(cell) for cell in cells) + " |"
    return "\n".join([line(head), "|" + "---|" * len(head), *map(line, rows)])


def millimetres(level):
    return f"{level['resolution_m'] * 1e3:g} mm"


def hand_off(runs):
    rows, stages, evaluations = [], [], []
    names = [name for name in HAND_OFF_MARKS if name in runs]
    for name in names:
        run = runs[name]
        least, ambitious = HAND_OFF_MARKS[name]
        ready = "ready" if run.last["hand_off_ready"] else "a check failed"
        rows.append([name.split("-")[0], run.particles, run.spread("solve_wall_seconds"), f"{least} / {ambitious}",
                     run.spread("solve_cpu_seconds"), f"{run.peak:.0f}", ready])
        levels = ", ".join(f"{level['evaluations']} at {millimetres(level)}" for level in run.last["levels"])
        evaluations.append(f"{name.split('-')[0]}: {run.last['sewing']['evaluations']} for sewing, {levels}")
    first = runs[names[0]].last
    for stage in first["run"]["stages"]:
        label, number = stage["name"], re.fullmatch(r"level (\d+)", stage["name"])
        if number:
            label += f" ({millimetres(first['levels'][int(number[1]) - 1])})"
        cells = [f"{runs[name].stage(stage['name'], field):.3f}" for name in names
                 for field in ("wall_seconds", "cpu_seconds")]
        stages.append([label, *cells])
    garments = [name.split("-")[0] for name in names]
    head = ["stage"] + [f"{garment}, {kind} s" for garment in garments for kind in ("wall", "CPU")]
    return f"""## Flat panels to hand-off, 5 mm

{table(["garment", "particles", "wall s", "marks", "CPU s", "peak MB", "hand-off"], rows)}

Evaluations: {"; ".join(evaluations)}.

Where the time goes. `body` is its checks, its exposed skin and its tree; `start-up` levels, distance field and
arrangement; a level's time includes the prolongation to it.

{table(head, stages)}
"""


def equilibrium(runs):
    rows = []
    for name, (words, marks) in EQUILIBRIUM.items():
        if name not in runs:
            rows.append([words, "not run", marks, "", "", "", ""])
            continue
        run = runs[name]
        finest = run.last["levels"][-1]
        rms = finest["residual_weights"]["rms"]
        if run.last["termination"] == "converged":
            ended = "reached"
        else:
            ended = {"budget": "budget spent", "stalled": "stalled"}.get(run.last["termination"], "?")
        rows.append([words, run.spread("solve_wall_seconds"), marks, run.spread("solve_cpu_seconds"),
                     finest["evaluations"], "none" if rms is None else f"{rms:.2g}", f"{ended} (status {run.status})"])
    head = ["run", "wall s", "marks", "CPU s", "evaluations, finest level", "rms residual, weights", "how it ended"]
    return f"## To the equilibrium\n\n{table(head, rows)}\n"


def set_up(work, kernel):
    if not (work / "startup.txt").exists():
        return "## Set-up\n\nNot measured.\n"
    parsed = re.findall(r"^(\w+) +([\d.]+) ms of processor time, +([\d.]+) ms$",
                        (work / "startup.txt").read_text(), re.M)
    particles = re.search(r"^(\d+) particles", (work / "startup.txt").read_text(), re.M)[1]
    words = {"body": "body: checks, skin, tree", "field": "distance field", "garment": "levels, correspondences",
             "arrange": "arrangement"}
    rows = [[words.get(name, name), wall, cpu] for name, cpu, wall in parsed]
    springs = kernel.get(("energy", "set-up"))
    if springs:
        rows.append(["springs of the finest level (5 mm, embedded tee)", f"{springs[0] / 1e6:.1f}", ""])
    marks = "{} / {} ms".format(*SET_UP_MARKS)
    return f"""## Set-up

Tee at 5 mm, {particles} particles in all; the least of the rounds. The marks, {marks}, are for levels, correspondences
and springs together.

{table(["what", "wall ms", "CPU ms"], rows)}
"""


def criterion(work):
    """(group, function[, value]) -> (ns, elements or bytes an iteration), medians."""
    measured = {}
    for file in (work / "criterion").glob("**/new/benchmark.json"):
        about = json.loads(file.read_text())
        nanoseconds = json.loads((file.parent / "estimates.json").read_text())["median"]["point_estimate"]
        key = tuple(part for part in (about["group_id"], about["function_id"], about["value_str"]) if part)
        throughput = about["throughput"]
        measured[key] = (nanoseconds, next(iter(throughput.values())) if throughput else None)
    return measured


def the_kernel(kernel):
    if not kernel:
        return "## The kernel\n\nNot measured.\n"
    rows = []
    for function in ("energy and gradient", "curvature"):
        for model in ("", " of the paper's springs"):
            one, two = (kernel.get(("energy", function + model, threads)) for threads in "12")
            if one and two:
                rows.append([function + model, *(f"{ns / springs:.2f}" for ns, springs in (one, two))])
    bound = kernel.get(("energy", "bound: root and quotient"))
    if bound:
        rows.append(["bound: a root and a quotient for each edge of each triangle", f"{bound[0] / bound[1]:.2f}", ""])
    triad = [kernel.get(("memory", "triad", threads)) for threads in "12"]
    triad = [f"{count / ns:.1f}" for ns, count in filter(None, triad)]
    springs = next((count for key, (_, count) in kernel.items() if key[0] == "energy" and count), 0)
    special = ("energy", "memory")
    other = [[": ".join(key), f"{ns / 1e6:.3g}"] for key, (ns, _) in sorted(kernel.items()) if key[0] not in special]
    return f"""## The kernel

The embedded tee at 5 mm, {springs} springs (edges and hinges), medians of `cargo bench --bench hot_paths`. Marks on two
threads: {SPRING_MARKS[0]:g} / {SPRING_MARKS[1]:g} ns a spring. The triad (`a = b + 3c`, three arrays of 34 MB) moves {" and ".join(triad)} GB/s on one and
two threads.

{table(["ns a spring", "one thread", "two threads"], rows)}

Everything else that is timed there, each alone, on all threads:

{table(["what", "ms"], other)}
"""


def growth(runs, out):
    sizes = sorted((run for name, run in runs.items() if name.startswith("tee-")), key=lambda run: run.particles)
    rows = [[millimetres(run.last["levels"][-1]), run.particles, run.spread("solve_wall_seconds"),
             run.spread("solve_cpu_seconds"), f"{run.cpu_a_particle * 1e6:.0f}", f"{run.peak:.0f}",
             f"{run.peak * 1e3 / run.particles:.2f}", run.evaluations, f"{run.nanoseconds_an_evaluation:.0f}"] for run in sizes]
    (out / "pictures").mkdir(exist_ok=True)
    (out / "pictures/growth.svg").write_text(picture(sizes))
    # From the size that is nearest to ten thousand particles on.
    start = min(sizes, key=lambda run: abs(math.log(run.particles / 1e4)))
    ratio = sizes[-1].cpu_a_particle / start.cpu_a_particle
    head = ["resolution", "particles", "wall s", "CPU s", "CPU µs a particle", "peak MB", "kB a particle",
            "evaluations, finest level", "ns a particle and evaluation there"]
    return f"""## Growth

The tee to hand-off. From {start.particles} to {sizes[-1].particles} particles the processor time a particle changes by a factor of {ratio:.2f} (marks: at most
2 / 1). Coarse levels cost each garment much the same, and coarser finest levels are granted more evaluations: the last
column tells whether the work itself grows faster than the garment. Memory at a million particles: at most {MEMORY_MARKS[0]:g} / {MEMORY_MARKS[1]:g} GB.

{table(head, rows)}

![Processor time a particle and peak memory against the number of particles](pictures/growth.svg)
"""


def picture(sizes):
    """Two diagrams, one above the other, both axes logarithmic."""
    width, height, left, right = 900, 340, 90, 870
    particles = [run.particles for run in sizes]
    low, high = math.log10(min(particles)) - 0.15, math.log10(max(particles)) + 0.15
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {2 * height}" font-family="sans-serif" '
             'font-size="16" fill="#33332f">', f'<rect width="{width}" height="{2 * height}" fill="#fff"/>']
    diagrams = [("CPU µs a particle", [run.cpu_a_particle * 1e6 for run in sizes], "#0072b2"),
                ("peak memory, MB", [run.peak for run in sizes], "#d55e00")]
    for number, (title, values, color) in enumerate(diagrams):
        drawn = [(p, v) for p, v in zip(particles, values) if v > 0]
        if not drawn:
            continue
        top, bottom = number * height + 50, (number + 1) * height - 50
        least = math.floor(math.log10(min(v for _, v in drawn)))
        most = max(math.ceil(math.log10(max(v for _, v in drawn))), least + 1)
        x = lambda p: left + (right - left) * (math.log10(p) - low) / (high - low)
        y = lambda v: bottom - (bottom - top) * (math.log10(v) - least) / (most - least)
        parts.append(f'<text x="{left}" y="{top - 18}" font-size="19">{title}</text>')
        for decade in range(math.ceil(low), math.floor(high) + 1):
            parts.append(f'<path d="M{x(10**decade):.1f} {top}V{bottom}" stroke="#e4e4e2"/>'
                         f'<text x="{x(10**decade):.1f}" y="{bottom + 22}" text-anchor="middle">{10**decade:,}</text>')
        for decade in range(least, most + 1):
            parts.append(f'<path d="M{left} {y(10.0**decade):.1f}H{right}" stroke="#e4e4e2"/><text x="{left - 8}" '
                         f'y="{y(10.0**decade) + 5:.1f}" text-anchor="end">{10.0**decade:g}</text>')
        line = " ".join(f"{x(p):.1f},{y(v):.1f}" for p, v in drawn)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="2.5"/>')
        parts.extend(f'<circle cx="{x(p):.1f}" cy="{y(v):.1f}" r="4" fill="{color}"/><text x="{x(p):.1f}" '
                     f'y="{y(v) - 10:.1f}" text-anchor="middle" font-size="14">{v:.0f}</text>' for p, v in drawn)
    parts.append(f'<text x="{right}" y="{2 * height - 8}" text-anchor="end">particles</text>')
    return "\n".join(parts + ["</svg>"]) + "\n"


def main():
    work, out = map(pathlib.Path, sys.argv[1:3])
    facts = dict(line.split("=", 1) for line in (work / "facts").read_text().splitlines())
    runs = {folder.name: Run(folder) for folder in (work / "runs").iterdir()}
    kernel = criterion(work)
    quick = facts["mode"] == "quick"
    command = facts.get("options", "") + "benches/performance.sh DATA" + (" quick" if quick else "")
    caution = ("\n**This page is from a quick run, one round on a machine that had other work to do: it shows that the "
               "command works, and is no measurement. What is \"not run\" or \"not measured\" was left out.**\n") if quick else ""
    head = f"""# Performance

How long fits take, where the time goes, and how it grows. Seconds are those of the *solve*: from the parsed pattern and
the parsed mesh of the body to the outcome, so all but reading and writing files and drawing pictures. Peak memory is
that of the solve as well, the files that were read included. Figures are medians (with the range) on two threads. Marks
are the goals, *at least / ambitious*.
{caution}
Machine: {facts["cpu"]}, {facts["processors"]} processors, {facts["rustc"]}; load after the last measurement {facts["load"]}. Commit {facts["commit"]}. The
command that wrote this page: `{command}`.
"""
    parts = [head, hand_off(runs), equilibrium(runs), set_up(work, kernel), the_kernel(kernel), growth(runs, out)]
    notes = pathlib.Path(__file__).with_name("performance.notes.md")
    if notes.exists():
        parts.append(notes.read_text())
    (out / "performance.md").write_text("\n".join(parts))


main()
