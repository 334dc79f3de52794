"""Loads the garment of this folder into Blender: mesh, flat panels as UV map, motion.

In Blender: Scripting > Open > this file > Run. Or:

    blender --python import_into_blender.py

Works with Blender 4.2 and newer. Files are in metres with y up; Blender's z is up. The object is turned by 90° about x, so
that its vertices keep the numbers of the files and the garment stands upright.

By hand it is: File > Import > Wavefront (.obj) with forward -Z and up Y; the modifier Mesh Cache with garment.pc2, format
PC2, forward Y, up Z, start frame 1; and the frame rate of manifest.json in the output properties.
"""

import json
import math
import os

import bpy


def vertices_and_faces(path):
    """Of the OBJ file: sewn vertices, flat ones, and for each triangle its panel and both indices of its corners."""
    vertices, flat, triangles, panels = [], [], [], []
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            key, _, rest = line.rstrip("\n").partition(" ")
            if key == "v":
                vertices.append(tuple(map(float, rest.split())))
            elif key == "vt":
                flat.append(tuple(map(float, rest.split())))
            elif key == "g":
                panels.append(rest)
            elif key == "f":
                corners = [tuple(int(n) - 1 for n in corner.split("/")) for corner in rest.split()]
                triangles.append((len(panels) - 1, corners))
    return vertices, flat, triangles, panels


def load(folder):
    """Makes the object, and returns it."""
    with open(os.path.join(folder, "manifest.json"), encoding="utf-8") as file:
        manifest = json.load(file)
    vertices, flat, triangles, panels = vertices_and_faces(os.path.join(folder, "garment.obj"))
    name = manifest["from"]["pattern"]["name"]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], [[v for v, _ in corners] for _, corners in triangles])
    uv = mesh.uv_layers.new(name="panels (metres)")
    uv.data.foreach_set("uv", [n for _, corners in triangles for _, vt in corners for n in flat[vt]])
    for panel in panels:
        mesh.materials.append(bpy.data.materials.new(panel))
    mesh.polygons.foreach_set("material_index", [panel for panel, _ in triangles])
    mesh.polygons.foreach_set("use_smooth", [True] * len(triangles))
    mesh.update()
    garment = bpy.data.objects.new(name, mesh)
    garment.rotation_euler = (math.radians(90), 0, 0)
    bpy.context.scene.collection.objects.link(garment)
    frames = manifest["frames"]
    if frames["count"] > 1:
        play(garment, os.path.join(folder, "garment.pc2"), frames)
    return garment


def play(garment, cache, frames):
    """Moves the vertices by the point cache: its first frame is frame 1 of the scene."""
    modifier = garment.modifiers.new("motion", "MESH_CACHE")
    modifier.cache_format = "PC2"
    modifier.filepath = cache
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
    modifier.frame_start = 1
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames["count"]
    whole = max(1, round(frames["rate"]))
    scene.render.fps, scene.render.fps_base = whole, whole / frames["rate"]


def own_folder():
    """Where this file is. Blender's text editor does not tell by __file__, but knows the text."""
    text = getattr(bpy.context.space_data, "text", None)
    path = bpy.path.abspath(text.filepath) if text and text.filepath else __file__
    return os.path.dirname(os.path.abspath(path))


if __name__ == "__main__":
    load(own_folder())
