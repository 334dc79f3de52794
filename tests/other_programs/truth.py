"""What the exported files have to hold, by independent means: garment.obj of the fit, and the sway of motion.py."""

import os
import sys

import numpy as np

FRAMES = 9
RATE = 24.0


class Truth:
    """The garment as toile wrote it; positions in f64."""

    def __init__(self, folder):
        positions, rest, faces, panels, names = [], [], [], [], []
        with open(os.path.join(folder, "fit", "garment.obj"), encoding="utf-8") as lines:
            for line in lines:
                key, _, value = line.rstrip("\n").partition(" ")
                if key == "v":
                    positions.append([float(x) for x in value.split()])
                elif key == "vt":
                    rest.append([float(x) for x in value.split()])
                elif key == "o":
                    names.append(value)
                elif key == "f":
                    faces.append([[int(n) - 1 for n in corner.split("/")] for corner in value.split()])
                    panels.append(len(names) - 1)
        self.positions, self.rest, self.panels = np.array(positions), np.array(rest), np.array(panels)
        faces = np.array(faces)
        self.triangles, self.flat_triangles, self.names = faces[:, :, 0], faces[:, :, 1], names
        self.particle_of = np.empty(len(rest), dtype=int)
        self.particle_of[self.flat_triangles.ravel()] = self.triangles.ravel()

    def frame(self, k):
        return sway(self.positions, k)

    def frames(self):
        return np.array([self.frame(k) for k in range(FRAMES)])

    def areas(self):
        a, b, c = (self.rest[self.flat_triangles[:, k]] for k in range(3))
        u, v = b - a, c - a
        return 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def sway(positions, k):
    """Frame k of a motion: nothing happens in the first."""
    phase = 0.4 * k
    moved = positions.copy()
    moved[:, 0] += 0.05 * np.sin(phase) * positions[:, 1]
    moved[:, 2] += 0.02 * np.sin(phase) * np.cos(9.0 * positions[:, 0])
    return moved


class Table:
    """Rows for the table that `run` prints."""

    def __init__(self, program, version):
        self.program, self.version, self.failed = program, version, False

    def row(self, file, compared, values, difference, limit):
        passed = bool(np.isfinite(difference) and difference <= limit)
        self.failed |= not passed
        shown = "0" if difference == 0 else f"{difference:.1e}"
        verdict = "ok" if passed else f"**more than {limit:.0e}**"
        print(f"| {self.program} | {self.version} | {file} | {compared} | {values} | {shown} | {verdict} |", flush=True)

    def same(self, file, compared, found, expected, limit=0.0):
        found, expected = np.asarray(found), np.asarray(expected)
        if found.shape != expected.shape:
            print(f"{file}, {compared}: shape {found.shape} instead of {expected.shape}", file=sys.stderr)
            self.row(file, compared, expected.size, np.inf, limit)
            return
        difference = np.max(np.abs(found.astype(float) - expected.astype(float)), initial=0.0)
        self.row(file, compared, expected.size, difference, limit)

    def end(self):
        sys.exit(1 if self.failed else 0)


def missing(program, error):
    print(f"| {program} | not installed | | | | | {type(error).__name__} |")
    sys.exit(0)


# Coordinates are below 2 m: f32 rounds them by up to 6e-8, sums of two f32 by twice that.
SINGLE = 6.0e-8 * 2
SUM = 2 * SINGLE
