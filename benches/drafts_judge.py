"""Has the neutral judge of ../shared/judge look at fits of drafts, whose patterns it cannot read: FreeSewing, DXF.

    drafts_judge.py JUDGE_FOLDER BODY.obj FIT_FOLDER [--resolution-mm 10]

The sewn and placed pattern is taken from FIT_FOLDER/state.toile, in toile's own format (docs/formats.md), and handed to the judge as what
it would have read itself: outlines as polylines, stitches, and placements. All that is judged is measured in FIT_FOLDER/garment.obj.
Prints one JSON object: the judge's figures and its reasons. Needs what the judge needs (its requirements.txt).
"""
import argparse
import json
import os
import struct
import sys

import numpy as np

POINTS = 64  # of each curve


def section(state, tag):
    """The text of a section of a state file."""
    at = 20
    while at < len(state) - 4:
        name, size = state[at:at + 4], struct.unpack("<Q", state[at + 4:at + 12])[0]
        if name == tag:
            return state[at + 12:at + 12 + size].decode()
        at += 12 + size
    raise SystemExit("the state has no section %s" % tag)


def bezier(points):
    t = np.linspace(0, 1, POINTS + 1)[:, None]
    a, b, c, d = (np.array(p, float) for p in points)
    return (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t * t * (1 - t) * c + t ** 3 * d


def polyline(segment, end):
    """A segment of toile's own format as points, m."""
    start, end = np.array(segment["from"], float), np.array(segment.get("to", end), float)
    if "quadratic" in segment:
        q = np.array(segment["quadratic"], float)
        return bezier([start, start + (q - start) * 2 / 3, end + (q - end) * 2 / 3, end])
    if "cubic" in segment:
        return bezier([start, *segment["cubic"], end])
    if "path" in segment:
        controls = [start.tolist(), *segment["path"], end.tolist()]
        parts = [bezier(controls[k:k + 4]) for k in range(0, len(controls) - 3, 3)]
        return np.vstack([part[:-1] for part in parts] + [parts[-1][-1:]])
    if "arc" in segment:
        arc = segment["arc"]
        center = np.array(arc["center"], float)
        angle = np.arctan2(*(start - center)[::-1]) + arc["sweep"] * np.linspace(0, 1, POINTS + 1)
        points = center + arc["radius"] * np.stack([np.cos(angle), np.sin(angle)], 1)
        points[0], points[-1] = start, end
        return points
    return np.stack([start, end])


def read_state(folder, judge_pattern):
    """What the judge's read_pattern returns, from the state of a fit."""
    with open(os.path.join(folder, "state.toile"), "rb") as file:
        pattern = json.loads(section(file.read(), b"PATT"))
    panels = {}
    for panel in pattern["panels"]:
        outline = panel["outline"]
        curves = [judge_pattern.Curve(polyline(s, outline[(k + 1) % len(outline)]["from"])) for k, s in enumerate(outline)]
        loop = np.vstack([c.P[:-1] for c in curves])
        place = panel["placement"]
        panels[panel["name"]] = dict(
            corners=np.array([s["from"] for s in outline], float), curves=curves, outline=loop,
            area=judge_pattern.polygon_area(loop), R=np.array(place["rotation"], float),
            t=np.array(place["translation"], float), label=panel.get("part", ""))
    side = lambda s: (s["panel"], s["segment"])
    stitches = [dict(a=side(s["sides"][0]), b=side(s["sides"][1]), reversed=s.get("sense") != "aligned")
                for s in pattern.get("seams", [])]
    return dict(name=pattern["name"], panels=panels, stitches=stitches)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("judge"), ap.add_argument("body"), ap.add_argument("fit")
    ap.add_argument("--resolution-mm", type=float, default=10.0)
    a = ap.parse_args()
    sys.path.insert(0, a.judge)
    import judge_pattern

    judge_pattern.read_pattern = lambda folder: read_state(folder, judge_pattern)
    r = judge_pattern.judge_pattern(a.fit, a.body, a.fit, a.resolution_mm)
    print(json.dumps(judge_pattern.plain(r)))


if __name__ == "__main__":
    main()
