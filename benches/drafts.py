"""Writes docs/drafts.md and docs/pictures/drafts_*.png from the fits of benches/drafts.sh.

    drafts.py OUT REPOSITORY
"""
import json
import os
import platform
import subprocess
import sys
import tomllib

GARMENTS = [("teagan", "T-shirt"), ("penelope", "pencil skirt"), ("titan", "trouser block"),
            ("brian", "body block"), ("aaron", "tank top")]
DRAWINGS = [("teagan_aama_accumark_mm", "T-shirt"), ("penelope_astm_accumark_inch", "pencil skirt"),
            ("titan_aama_clo_mm", "trouser block"), ("brian_aama_accumark_mm", "body block"),
            ("gc_tee_aama_clo_mm", "T-shirt of eight panels")]
WIDTH = 600  # of a picture, pixels


def seams(file):
    """Each seam as a pair of sets of edges."""
    with open(file, "rb") as fh:
        tables = tomllib.load(fh).get("seam", [])
    side = lambda s: frozenset([s] if isinstance(s, str) else s)
    return [frozenset(side(s) for s in t["sides"]) for t in tables]


def fits(out, name, what, proposals):
    """The rows of one pattern, one for each resolution."""
    rows = []
    for mm in (20, 10):
        folder = os.path.join(out, "%s-%d" % (name, mm))
        try:
            with open(os.path.join(folder, "report.json")) as fh:
                r = json.load(fh)
        except OSError:
            rows.append("| %s | `%s` | | %s | %d | | no result | | | | |" % (what, name, proposals, mm))
            continue
        a, strain = r["assessment"], r["assessment"]["strain_less_gathers"]
        failed = [c["name"] for c in r["hand_off_checks"] if not c["passed"]]
        judged = ""
        if os.path.exists(os.path.join(folder, "judge.json")):
            with open(os.path.join(folder, "judge.json")) as fh:
                j = json.load(fh)
            pairs = j.get("intersections", {})
            judged = "%s / %s" % (pairs.get("cloth_body_pairs", "?"), pairs.get("cloth_cloth_pairs", "?"))
            judged += ": passed" if j["passed"] else ": " + "; ".join(j["reasons"])
        x = a["intersections"]
        rows.append("| %s | `%s` | %s | %s | %d | %d | %.1f | %.1f / %.1f %% | %d / %d | %s | %s |" % (
            what, name, r["inputs"]["body"]["name"].replace(".obj", ""), proposals, mm,
            r["levels"][-1]["particles"], r["run"]["cpu_seconds"], 100 * strain["stretch_p99"], 100 * strain["stretch_max"],
            x["body_pairs"], x["cloth_pairs"], judged, "ready" if not failed else "not ready: " + ", ".join(failed)))
    return rows


def main():
    out, home = sys.argv[1:3]
    rows, drawings, pictures = [], [], []
    for name, what in DRAWINGS:
        drawings += fits(out, name, what, "%d" % len(seams(os.path.join(out, name + ".suggested.toml"))))
    for name, what in GARMENTS:
        ours = seams(os.path.join(home, "examples/drafts", name + ".seams.toml"))
        proposed = seams(os.path.join(out, name + ".suggested.toml"))
        right = sum(s in proposed for s in ours)
        rows += fits(out, name, what, "%d of %d; %d proposed" % (right, len(ours), len(proposed)))
        preview = os.path.join(out, name + "-10", "preview.png")
        if os.path.exists(preview):
            from PIL import Image

            picture = Image.open(preview).convert("RGB")
            picture = picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.LANCZOS)
            picture.save(os.path.join(home, "docs/pictures/drafts_%s.png" % name), optimize=True)
            pictures.append("### %s: `%s`\n\n![%s on the body, from the front, at three quarters, from the back](pictures/drafts_%s.png)\n" % (
                what.capitalize(), name, what.capitalize(), name))
    commit = subprocess.run(["git", "-C", home, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    cpu = next((l.split(":", 1)[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), platform.machine())
    with open(os.path.join(home, "benches/drafts.notes.md")) as fh:
        notes = fh.read()
    head = ("| garment | draft | body | %s | mm | particles | CPU s | stretch p99 / largest | crossings body / cloth | "
            "judge: crossings, verdict | hand-off |\n|---|---|---|---|---|---|---|---|---|---|---|")
    table = head % "seams proposed rightly" + "\n" + "\n".join(rows)
    straight = head % "seams proposed" + "\n" + "\n".join(drawings)
    run = "Measured on %s, %d threads, commit `%s`." % (cpu, os.cpu_count(), commit)
    text = notes.replace("{TABLE}", table).replace("{DRAWINGS}", straight).replace("{RUN}", run).replace("{PICTURES}", "\n".join(pictures).rstrip() + "\n")
    with open(os.path.join(home, "docs/drafts.md"), "w") as fh:
        fh.write(text)


if __name__ == "__main__":
    main()
