"""Makes the garment template (a pickle) that ContourCraft and HOOD load, from contourcraft.npz in this folder.

    python make_contourcraft_template.py garment.pkl [path of the ContourCraft repository]

With the path their own `utils.mesh_creation.add_coarse_edges` adds the coarse edges, as `obj2template` does; without it
they are missing, and their loader has to make them. The dataset `from_any_pose` takes the template as it is: garment and
body in the first pose, no skinning weights. `rest_pos` is the fitted garment, not the panels: these programs take one rest
position for each sewn vertex, and the flat panels have several. Fitted cloth is stretched by little; the report of the fit
says by how much. The flat panels are there as `verts_uv` and `faces_uv`.

Axes are those of toile, metres and y up, as SMPL bodies have them.
"""

import os
import pickle
import sys

import numpy as np


def template(folder, repository=None):
    """The dictionary of the template."""
    with np.load(os.path.join(folder, "contourcraft.npz")) as file:
        garment = {name: file[name] for name in file.files}
    garment["garment_id"] = components(len(garment["rest_pos"]), garment["faces"])
    if repository:
        sys.path.insert(0, repository)
        from utils.mesh_creation import add_coarse_edges

        garment = add_coarse_edges(garment)
    return garment


def components(count, faces):
    """For each vertex the number of the connected part that it belongs to, as (count, 1)."""
    part = np.arange(count)
    while True:
        least = part.copy()
        lowest = part[faces].min(axis=1)
        for corner in range(3):
            np.minimum.at(least, faces[:, corner], lowest)
        least = least[least]
        if np.array_equal(least, part):
            return np.unique(part, return_inverse=True)[1].reshape(-1, 1).astype(np.int64)
        part = least


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    here = os.path.dirname(os.path.abspath(__file__))
    with open(sys.argv[1], "wb") as file:
        pickle.dump(template(here, sys.argv[2] if len(sys.argv) > 2 else None), file)
