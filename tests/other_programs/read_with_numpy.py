"""NumPy: the archives, and point caches by their descriptions."""

import json
import os
import pickle
import subprocess
import sys

try:
    import numpy as np
except ImportError as error:
    print(f"| numpy | not installed | | | | | {error} |")
    sys.exit(0)
from truth import FRAMES, RATE, SINGLE, Table, Truth

folder = sys.argv[1]
truth, table = Truth(folder), Table("numpy", np.__version__)
moving = os.path.join(folder, "moving")
with np.load(os.path.join(moving, "garment.npz")) as a:
    table.same("garment.npz", "positions of all frames", a["positions"], truth.frames())
    table.same("garment.npz", "rest coordinates", a["rest"], truth.rest)
    table.same("garment.npz", "sewn from flat", a["particle_of_point"][np.unique(truth.flat_triangles)],
               truth.particle_of[np.unique(truth.flat_triangles)])
    table.same("garment.npz", "triangles", a["triangle_particles"], truth.triangles)
    table.same("garment.npz", "frame rate", a["frame_rate"], RATE)
    assert a["panel_names"].tolist() == truth.names
with np.load(os.path.join(folder, "still", "rest.npz")) as a:
    table.same("rest.npz", "triangles of the flat panels", a["triangle_points"], truth.flat_triangles)

with open(os.path.join(moving, "garment.pc2"), "rb") as file:
    head = np.frombuffer(file.read(32), dtype=[("magic", "S12"), ("version", "<i4"), ("points", "<i4"),
                                               ("start", "<f4"), ("rate", "<f4"), ("samples", "<i4")])[0]
    assert head["magic"] == b"POINTCACHE2" and head["version"] == 1
    points = np.frombuffer(file.read(), "<f4").reshape(head["samples"], head["points"], 3)
table.same("garment.pc2", "positions of all frames", points, truth.frames(), SINGLE)
with open(os.path.join(moving, "garment.mdd"), "rb") as file:
    count, size = np.frombuffer(file.read(8), ">i4")
    times = np.frombuffer(file.read(4 * count), ">f4")
    points = np.frombuffer(file.read(), ">f4").reshape(count, size, 3)
table.same("garment.mdd", "positions of all frames", points, truth.frames(), SINGLE)
table.same("garment.mdd", "times", times, np.arange(FRAMES) / RATE, SINGLE)

pickled = os.path.join(folder, "template.pkl")
subprocess.run([sys.executable, os.path.join(folder, "still", "make_contourcraft_template.py"), pickled], check=True)
with open(pickled, "rb") as file:
    template = pickle.load(file)
table.same("ContourCraft template", "rest_pos", template["rest_pos"], truth.positions, SINGLE)
table.same("ContourCraft template", "faces", template["faces"], truth.triangles)
table.same("ContourCraft template", "verts_uv", template["verts_uv"], truth.rest, SINGLE)
table.same("ContourCraft template", "faces_uv", template["faces_uv"], truth.flat_triangles)
assert template["garment_id"].shape == template["node_type"].shape == (len(truth.positions), 1)

for name in ("still", "moving"):
    with open(os.path.join(folder, name, "manifest.json"), encoding="utf-8") as file:
        manifest = json.load(file)
    sizes = [os.path.getsize(os.path.join(folder, name, part["name"])) for part in manifest["files"]]
    table.same(f"manifest.json ({name})", "sizes of the files", sizes, [part["bytes"] for part in manifest["files"]])
table.end()
