#!/usr/bin/env python3
"""Writes patterns whose panels start in the wrong places: each moved, turned, and nearer to or farther from the others.

    benches/starts.py PATTERNS OUT [COUNT] [SEED]

PATTERNS is a folder of GarmentCode patterns with its index, PATTERNS.index.json, beside it; OUT receives COUNT patterns
(200), in turns of all in the index, and its own index. The same SEED (1) gives the same files. Panels are moved by at most
3 cm along each axis, turned by at most 15 degrees about an axis of any direction through their middle, and the distances
of their middles from that of the garment are multiplied by 0.97 to 1.05, one factor a garment.
"""
import json
import math
import random
import sys
from pathlib import Path

FARTHEST = 0.03  # m
LARGEST_TURN = math.radians(15.0)
SCALES = (0.97, 1.05)


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def times(m, v):
    return [sum(m[i][k] * v[k] for k in range(3)) for i in range(3)]


def about(axis, angle):
    """Rodrigues' formula, about an axis of length one."""
    x, y, z = axis
    s, c = math.sin(angle), math.cos(angle)
    skew = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    squared = product(skew, skew)
    return [[(i == j) + s * skew[i][j] + (1 - c) * squared[i][j] for j in range(3)] for i in range(3)]


def of_degrees(angles):
    """About x, then y, then z, all of them fixed: the convention of the format."""
    x, y, z = (about([float(k == axis) for k in range(3)], math.radians(a)) for axis, a in enumerate(angles))
    return product(z, product(y, x))


def to_degrees(r):
    y = math.asin(max(-1.0, min(1.0, -r[2][0])))
    if abs(r[2][0]) < 1 - 1e-12:
        x, z = math.atan2(r[2][1], r[2][2]), math.atan2(r[1][0], r[0][0])
    else:
        x, z = 0.0, math.atan2(-r[0][1], r[1][1])
    return [math.degrees(a) for a in (x, y, z)]


def disturb(document, rng):
    panels = document["pattern"]["panels"]
    unit = document["properties"]["units_in_meter"]
    scale = rng.uniform(*SCALES)
    middles = {}
    for name, panel in panels.items():
        mean = [sum(v[k] for v in panel["vertices"]) / len(panel["vertices"]) for k in range(2)] + [0.0]
        placed = times(of_degrees(panel["rotation"]), mean)
        middles[name] = (mean, [placed[k] + panel["translation"][k] for k in range(3)])
    center = [sum(m[k] for _, m in middles.values()) / len(middles) for k in range(3)]
    for name, panel in panels.items():
        mean, middle = middles[name]
        axis = [rng.gauss(0, 1) for _ in range(3)]
        length = math.sqrt(sum(a * a for a in axis))
        turn = about([a / length for a in axis], rng.uniform(-LARGEST_TURN, LARGEST_TURN))
        rotation = product(turn, of_degrees(panel["rotation"]))
        shift = [rng.uniform(-FARTHEST, FARTHEST) * unit for _ in range(3)]
        moved = times(rotation, mean)
        panel["translation"] = [center[k] + scale * (middle[k] - center[k]) + shift[k] - moved[k] for k in range(3)]
        panel["rotation"] = to_degrees(rotation)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    patterns, out = Path(sys.argv[1]), Path(sys.argv[2])
    count, seed = ([int(a) for a in sys.argv[3:5]] + [200, 1][len(sys.argv) - 3:])[:2]
    index = json.loads(patterns.with_name(patterns.name + ".index.json").read_text())
    out.mkdir(parents=True, exist_ok=True)
    bodies = {}
    for k in range(count):
        name = list(index)[k % len(index)]
        document = json.loads((patterns / f"{name}.json").read_text())
        disturb(document, random.Random(f"{seed} {k}"))
        bodies[f"{name}_{k:03}"] = {"body": index[name]["body"]}
        (out / f"{name}_{k:03}.json").write_text(json.dumps(document))
    out.with_name(out.name + ".index.json").write_text(json.dumps(bodies, indent=1))


if __name__ == "__main__":
    main()
