"""Blender (`bpy`): the import script, its own importers, and both point caches by its modifier."""

import importlib.util
import os
import runpy
import sys

try:
    import bpy
    import numpy as np
except ImportError as error:
    print(f"| Blender (bpy) | not installed | | | | | {error} |")
    sys.exit(0)
from truth import FRAMES, RATE, SINGLE, SUM, Table, Truth

folder = sys.argv[1]
truth, table = Truth(folder), Table("Blender (bpy)", bpy.app.version_string)
moving, still = os.path.join(folder, "moving"), os.path.join(folder, "still")
# y up to z up, then a rotation in single precision.
UPRIGHT = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
TURNED = 4 * SUM


def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def script(path):
    spec = importlib.util.spec_from_file_location("import_into_blender", os.path.join(path, "import_into_blender.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.load(path)


def vertices(thing, frame, world):
    bpy.context.scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    evaluated = thing.evaluated_get(graph)
    mesh = evaluated.to_mesh()
    points = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3).astype(float)
    evaluated.to_mesh_clear()
    if not world:
        return points
    matrix = np.array(evaluated.matrix_world)
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def corners(mesh, name=None):
    layer = mesh.uv_layers[0] if name is None else mesh.uv_layers[name]
    uv = np.empty(2 * len(mesh.loops), dtype=np.float32)
    layer.data.foreach_get("uv", uv)
    return uv.reshape(-1, 3, 2)


def triangles(mesh):
    index = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", index)
    return index.reshape(-1, 3)


# 1. The script that lies beside the files.
empty()
garment = script(moving)
scene = bpy.context.scene
table.same("import_into_blender.py", "frame rate", scene.render.fps / scene.render.fps_base, RATE, 1e-6)
table.same("import_into_blender.py", "frames of the scene", [scene.frame_start, scene.frame_end], [1, FRAMES])
local = [vertices(garment, 1 + k, False) for k in range(FRAMES)]
table.same("garment.pc2", "positions of all frames (modifier)", local, truth.frames(), SINGLE)
world = [vertices(garment, 1 + k, True) for k in range(FRAMES)]
table.same("import_into_blender.py", "positions in the world, z up", world, truth.frames() @ UPRIGHT.T, TURNED)
table.same("import_into_blender.py", "triangles", triangles(garment.data), truth.triangles)
table.same("import_into_blender.py", "rest coordinates (UV)", corners(garment.data), truth.rest[truth.flat_triangles], SINGLE)
assert [material.name for material in garment.data.materials] == truth.names
garment.modifiers["motion"].cache_format = "MDD"
garment.modifiers["motion"].filepath = os.path.join(moving, "garment.mdd")
local = [vertices(garment, 1 + k, False) for k in range(FRAMES)]
table.same("garment.mdd", "positions of all frames (modifier)", local, truth.frames(), SINGLE)
empty()
runpy.run_path(os.path.join(moving, "import_into_blender.py"), run_name="__main__")
assert [thing.name for thing in bpy.context.scene.objects] == ["tee"]
empty()
garment = script(still)
assert not garment.modifiers
table.same("import_into_blender.py (still)", "positions", vertices(garment, 1, False), truth.positions, SINGLE)

# 2. File > Import > Wavefront, forward -Z, up Y, and the modifier by hand.
empty()
bpy.ops.wm.obj_import(filepath=os.path.join(moving, "garment.obj"), forward_axis="NEGATIVE_Z", up_axis="Y")
[garment] = bpy.context.selected_objects
table.same("garment.obj", "positions, order of vertices", vertices(garment, 1, False), truth.frame(0), SINGLE)
table.same("garment.obj", "positions in the world, z up", vertices(garment, 1, True), truth.frame(0) @ UPRIGHT.T, TURNED)
table.same("garment.obj", "triangles", triangles(garment.data), truth.triangles)
table.same("garment.obj", "rest coordinates (UV)", corners(garment.data), truth.rest[truth.flat_triangles], SINGLE)
modifier = garment.modifiers.new("motion", "MESH_CACHE")
modifier.cache_format, modifier.filepath = "PC2", os.path.join(moving, "garment.pc2")
modifier.forward_axis, modifier.up_axis, modifier.frame_start = "POS_Y", "POS_Z", 1
world = [vertices(garment, 1 + k, True) for k in range(FRAMES)]
table.same("garment.obj + garment.pc2", "positions of all frames, z up", world, truth.frames() @ UPRIGHT.T, TURNED)

# 3. glTF: panels as objects, frames as shape keys with an animation.
empty()
scene = bpy.context.scene
scene.render.fps = int(RATE)
bpy.ops.import_scene.gltf(filepath=os.path.join(moving, "garment.glb"), import_shading="SMOOTH", merge_vertices=False)
worst, count = 0.0, 0
for k, name in enumerate(truth.names):
    thing = bpy.data.objects[name]
    flat = truth.flat_triangles[truth.panels == k]
    points = truth.particle_of[flat.min():flat.max() + 1]
    assert len(thing.data.shape_keys.key_blocks) == FRAMES
    for frame in range(FRAMES):
        found = vertices(thing, frame, True)
        worst = max(worst, np.abs(found - truth.frame(frame)[points] @ UPRIGHT.T).max())
        count += found.size
table.row("garment.glb", "positions of all frames, z up (shape keys)", count, worst, TURNED)

# 4. USD, with a cache for its time samples.
empty()
bpy.ops.wm.usd_import(filepath=os.path.join(moving, "garment.usda"))
[garment] = [thing for thing in bpy.context.scene.objects if thing.type == "MESH"]
world = [vertices(garment, k, True) for k in range(FRAMES)]
table.same("garment.usda", "positions of all frames, z up", world, truth.frames() @ UPRIGHT.T, TURNED)
table.same("garment.usda", "rest coordinates (UV)", corners(garment.data, "st"), truth.rest[truth.flat_triangles], SINGLE)

# 5. PLY.
empty()
bpy.ops.wm.ply_import(filepath=os.path.join(still, "garment.ply"), forward_axis="NEGATIVE_Z", up_axis="Y")
[garment] = bpy.context.selected_objects
table.same("garment.ply", "positions in the world, z up", vertices(garment, 1, True), truth.positions @ UPRIGHT.T, TURNED)
table.same("garment.ply", "triangles", triangles(garment.data), truth.triangles)
table.end()
