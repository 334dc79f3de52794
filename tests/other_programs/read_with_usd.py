"""usd-core: the stage, its mesh, time samples, subsets and rest shape."""

import os
import sys
from importlib.metadata import version

try:
    import numpy as np
    from pxr import Usd, UsdGeom, UsdShade
except ImportError as error:
    print(f"| usd-core | not installed | | | | | {error} |")
    sys.exit(0)
from truth import FRAMES, RATE, SINGLE, Table, Truth

folder = sys.argv[1]
truth, table = Truth(folder), Table("usd-core", version("usd-core"))
stage = Usd.Stage.Open(os.path.join(folder, "moving", "garment.usda"))
assert UsdGeom.GetStageUpAxis(stage) == "Y" and stage.GetDefaultPrim().GetName() == "garment"
table.same("garment.usda", "metres per unit", UsdGeom.GetStageMetersPerUnit(stage), 1.0)
table.same("garment.usda", "frame rate", stage.GetTimeCodesPerSecond(), RATE)
table.same("garment.usda", "first and last time", [stage.GetStartTimeCode(), stage.GetEndTimeCode()], [0, FRAMES - 1])
mesh = UsdGeom.Mesh.Get(stage, "/garment/cloth")
points = np.array([mesh.GetPointsAttr().Get(k) for k in range(FRAMES)])
table.same("garment.usda", "positions of all frames", points, truth.frames(), SINGLE)
table.same("garment.usda", "positions without a time", mesh.GetPointsAttr().Get(), truth.frame(0), SINGLE)
table.same("garment.usda", "triangles", np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3), truth.triangles)
extents = np.array([mesh.GetExtentAttr().Get(k) for k in range(FRAMES)])
boxes = np.stack((truth.frames().min(axis=1), truth.frames().max(axis=1)), axis=1)
table.same("garment.usda", "extents", extents, boxes, SINGLE)
st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
assert st.GetInterpolation() == "faceVarying"
table.same("garment.usda", "rest coordinates by corner", np.array(st.ComputeFlattened()).reshape(-1, 3, 2),
           truth.rest[truth.flat_triangles], SINGLE)
prim = mesh.GetPrim()
rest = np.array(prim.GetAttribute("physics:restShapePoints").Get())
table.same("garment.usda", "restShapePoints", rest[:, :2], truth.rest, SINGLE)
table.same("garment.usda", "restTriVertexIndices", prim.GetAttribute("physics:restTriVertexIndices").Get(),
           truth.flat_triangles)
subsets = UsdGeom.Subset.GetGeomSubsets(mesh, "face", "panel")
assert [s.GetPrim().GetDisplayName() for s in subsets] == truth.names
owner = np.full(len(truth.triangles), -1)
for k, subset in enumerate(subsets):
    owner[np.array(subset.GetIndicesAttr().Get())] = k
table.same("garment.usda", "panels of the triangles", owner, truth.panels)
assert UsdGeom.Subset.ValidateFamily(mesh, "face", "panel")[0]
bound, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
assert bound.GetPath() == "/garment/fabric"
still = Usd.Stage.Open(os.path.join(folder, "still", "garment.usda"))
attribute = UsdGeom.Mesh.Get(still, "/garment/cloth").GetPointsAttr()
assert attribute.GetNumTimeSamples() == 0
table.same("garment.usda (still)", "positions", attribute.Get(), truth.positions, SINGLE)
table.end()
