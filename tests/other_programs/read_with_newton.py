"""Newton: its USD importer, the script for Style3D and VBD, and a first hundredth of a second of each."""

import importlib.util
import os
import sys

try:
    import newton
    import numpy as np
    import warp as wp
except ImportError as error:
    print(f"| Newton | not installed | | | | | {error} |")
    sys.exit(0)
from truth import SINGLE, Table, Truth

wp.config.quiet = True
folder = sys.argv[1]
truth, table = Truth(folder), Table("Newton", newton.__version__)
still = os.path.join(folder, "still")
spec = importlib.util.spec_from_file_location("load_into_newton", os.path.join(still, "load_into_newton.py"))
load_into_newton = importlib.util.module_from_spec(spec)
spec.loader.exec_module(load_into_newton)
DENSITY = 0.120  # kg/m², cotton_shirting
MASS = DENSITY * truth.areas().sum()


def lengths():
    """Of the three sides of every flat triangle, m."""
    corners = truth.rest[truth.flat_triangles]
    return np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)


def sides(builder):
    """The same from the inverse rest matrices that Newton keeps."""
    edges = np.linalg.inv(np.array(builder.tri_poses))
    u, v = edges[:, :, 0], edges[:, :, 1]
    return np.stack([np.linalg.norm(side, axis=1) for side in (u, v - u, v)], axis=1)


def compare(name, builder):
    table.same(name, "positions of the particles", builder.particle_q, truth.positions, SINGLE)
    table.same(name, "triangles", builder.tri_indices, truth.triangles)
    table.same(name, "flat sides of the triangles, m", sides(builder), lengths(), 4 * SINGLE)
    table.same(name, "flat areas, m²", builder.tri_areas, truth.areas(), SINGLE)
    table.same(name, "mass, kg", np.sum(builder.particle_mass), MASS, 1e-6)


def run(name, builder, solver_of):
    """Neither gravity nor body: what they held back moves a little, and nothing bursts."""
    builder.color()
    model = builder.finalize(device="cpu")
    model.set_gravity((0.0, 0.0, 0.0))
    solver = solver_of(model)
    now, then, control = model.state(), model.state(), model.control()
    pipeline = newton.CollisionPipeline(model)
    contacts = pipeline.contacts()
    for _ in range(10):
        now.clear_forces()
        pipeline.collide(now, contacts)
        solver.step(now, then, control, contacts, 1e-3)
        now, then = then, now
    moved = np.linalg.norm(now.particle_q.numpy() - truth.positions, axis=1)
    table.row(name, "largest move in 10 ms without gravity, m", len(moved), moved.max(), 0.02)


builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
builder.add_usd(os.path.join(still, "garment.usda"))
compare("garment.usda", builder)
table.same("garment.usda", "rest angles of the hinges", builder.edge_rest_angle, np.zeros(builder.edge_count))

builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
newton.solvers.SolverStyle3D.register_custom_attributes(builder)
load_into_newton.add_style3d(builder)
compare("newton.npz (Style3D)", builder)
run("newton.npz (Style3D)", builder, lambda model: newton.solvers.SolverStyle3D(model=model))

builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
load_into_newton.add_cloth(builder)
compare("newton.npz (VBD)", builder)
run("newton.npz (VBD)", builder, lambda model: newton.solvers.SolverVBD(model=model, iterations=10))
table.end()
