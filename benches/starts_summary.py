#!/usr/bin/env python3
"""Prints what the judge says of starts in wrong places, from the JSON of its corpus runner: which results are not clean.

    benches/starts_summary.py CORPUS.json
"""
import json
import re
import sys


def main():
    corpus = json.load(open(sys.argv[1]))
    ours = re.compile(r"^exit 4: |^triangle stretch ")  # the program's own word for the same, and strain
    unclean = []
    for garment in corpus["garments"]:
        reasons = [r for r in garment["reasons"] if not ours.search(r)]
        if reasons:
            unclean.append((garment["name"], garment["cpu_s"], reasons))
    count = len(corpus["garments"])
    cpu = sorted(g["cpu_s"] for g in corpus["garments"])
    print(f"""
## Starts in wrong places, at {corpus["resolution_mm"]:g} mm

The same patterns with each panel moved by up to 3 cm along each axis and turned by up to 15 degrees about any axis, and all of
them nearer to each other or farther apart (0.97 to 1.05): `benches/starts.py`, {count} garments. Strain aside, which needs finer cloth
than this, {count - len(unclean)} of {count} pass the gate: complete, sewn, without an intersection. Processor time: median {cpu[count // 2]:.1f} s, at most
{cpu[-1]:.1f} s, pictures included.{" The others:" if unclean else ""}
""")
    if unclean:
        print("| garment | CPU s | what the judge says |\n|---|---|---|")
    for name, seconds, reasons in unclean:
        print(f"| {name} | {seconds:.1f} | {'; '.join(reasons)} |")


if __name__ == "__main__":
    main()
