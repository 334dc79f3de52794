"""trimesh: PLY, OBJ, GLB."""

import os
import sys

try:
    import numpy as np
    import trimesh
except ImportError as error:
    print(f"| trimesh | not installed | | | | | {error} |")
    sys.exit(0)
from truth import FRAMES, SINGLE, Table, Truth

folder = sys.argv[1]
truth, table = Truth(folder), Table("trimesh", trimesh.__version__)
still, frames = os.path.join(folder, "still"), os.path.join(folder, "moving", "frames")
mesh = trimesh.load(os.path.join(still, "garment.ply"), process=False)
table.same("garment.ply", "positions", mesh.vertices, truth.positions)
table.same("garment.ply", "triangles", mesh.faces, truth.triangles)
mesh = trimesh.load(os.path.join(still, "rest.ply"), process=False)
table.same("rest.ply", "flat positions", mesh.vertices, np.column_stack((truth.rest, np.zeros(len(truth.rest)))))
table.same("rest.ply", "triangles", mesh.faces, truth.flat_triangles)
table.same("rest.ply", "sewn vertex of each", mesh.metadata["_ply_raw"]["vertex"]["data"]["particle"], truth.particle_of)
for ending in ("ply", "obj"):
    found = []
    for k in range(FRAMES):
        path = os.path.join(frames, f"garment.{k:05}.{ending}")
        mesh = trimesh.load(path, process=False, force="mesh", **({"maintain_order": True} if ending == "obj" else {}))
        if ending == "obj":
            # trimesh splits vertices at the flat panels; corners of triangles are what remains comparable.
            found.append(mesh.vertices[mesh.faces])
        else:
            found.append(mesh.vertices)
    expected = truth.frames()[:, truth.triangles] if ending == "obj" else truth.frames()
    table.same(f"frames/garment.*.{ending}", "positions of all frames", found, expected)

scene = trimesh.load(os.path.join(still, "garment.glb"), process=False)
worst, coordinates, values = 0.0, 0.0, 0
for k, name in enumerate(truth.names):
    mesh = scene.geometry[name]
    flat = truth.flat_triangles[truth.panels == k]
    points = np.arange(flat.min(), flat.max() + 1)
    worst = max(worst, np.abs(mesh.vertices - truth.positions[truth.particle_of[points]]).max())
    # trimesh turns glTF's v over; the file has it as it is.
    uv = np.column_stack((mesh.visual.uv[:, 0], 1.0 - mesh.visual.uv[:, 1]))
    coordinates = max(coordinates, np.abs(uv - truth.rest[points]).max())
    values += mesh.vertices.size
table.row("garment.glb", "positions of each panel", values, worst, SINGLE)
table.row("garment.glb", "rest coordinates of each panel", values * 2 // 3, coordinates, 2 * SINGLE)
table.end()
