"""Adds the garment of this folder to a newton.ModelBuilder.

    import newton, load_into_newton
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
    newton.solvers.SolverStyle3D.register_custom_attributes(builder)
    load_into_newton.add_style3d(builder)     # for SolverStyle3D
    load_into_newton.add_cloth(builder)       # for SolverVBD and others, on a builder of its own

Written for Newton 1.8. Files are in metres, kilograms, seconds, y up; for a world with z up give
`rot=wp.quat_from_axis_angle(wp.vec3(1, 0, 0), math.pi / 2)`.

Damping, air drag, and stiffness of contact are no figures of the fabric and keep the builder's defaults. Self-contact
distances belong to the solver: twice `particle_radius` is what the fit has kept.
"""

import os

import numpy as np
import warp as wp

HERE = os.path.dirname(os.path.abspath(__file__))


def arrays(folder=HERE):
    """What newton.npz holds, by name."""
    with np.load(os.path.join(folder, "newton.npz")) as file:
        return {name: file[name] for name in file.files}


def add_style3d(builder, folder=HERE, pos=(0.0, 0.0, 0.0), rot=None, label=None):
    """For SolverStyle3D: anisotropic cloth whose rest shape are the flat panels."""
    from newton.solvers import style3d

    a = arrays(folder)
    style3d.add_cloth_mesh(
        builder,
        pos=wp.vec3(*pos),
        rot=wp.quat_identity() if rot is None else rot,
        vel=wp.vec3(0.0, 0.0, 0.0),
        vertices=a["vertices"].tolist(),
        indices=a["indices"].tolist(),
        panel_verts=a["panel_verts"].tolist(),
        panel_indices=a["panel_indices"].tolist(),
        density=float(a["density"]),
        tri_aniso_ke=wp.vec3(*a["tri_aniso_ke"].tolist()),
        edge_aniso_ke=wp.vec3(*a["edge_aniso_ke"].tolist()),
        particle_radius=float(a["particle_radius"]),
        label=label,
    )


def add_cloth(builder, folder=HERE, pos=(0.0, 0.0, 0.0), rot=None, label=None):
    """For SolverVBD and others: isotropic cloth. The builder takes the pose for the rest shape; here the flat panels
    take its place: in the triangles, their areas, the masses, the lengths and angles of the hinges."""
    a = arrays(folder)
    first_particle, first_triangle, first_edge = builder.particle_count, builder.tri_count, builder.edge_count
    builder.add_cloth_mesh(
        pos=wp.vec3(*pos),
        rot=wp.quat_identity() if rot is None else rot,
        scale=1.0,
        vel=wp.vec3(0.0, 0.0, 0.0),
        vertices=a["vertices"].tolist(),
        indices=a["indices"].tolist(),
        density=0.0,
        tri_ke=float(a["tri_ke"]),
        tri_ka=float(a["tri_ka"]),
        edge_ke=float(np.mean(a["hinge_ke"])),
        particle_radius=float(a["particle_radius"]),
        label=label,
    )
    triangles = a["indices"].reshape(-1, 3)
    if builder.tri_count - first_triangle != len(triangles):
        raise ValueError("Newton dropped triangles without area; fit the garment again.")
    corners = a["panel_verts"][a["panel_indices"].reshape(-1, 3)]
    edges = np.stack((corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)
    areas = 0.5 * np.linalg.det(edges)
    builder.tri_poses[first_triangle:] = np.linalg.inv(edges).tolist()
    builder.tri_areas[first_triangle:] = areas.tolist()
    masses = np.bincount(triangles.ravel(), np.repeat(float(a["density"]) * areas / 3.0, 3), len(a["vertices"]))
    builder.particle_mass[first_particle:] = masses.tolist()
    hinges = {
        tuple(sorted(ends)): k for k, ends in enumerate((a["hinges"][:, 2:] + first_particle).tolist())
    }
    for edge in range(first_edge, builder.edge_count):
        tip, other, *ends = builder.edge_indices[edge]
        if tip < 0 or other < 0:
            continue
        hinge = hinges[tuple(sorted(int(end) for end in ends))]
        builder.edge_rest_angle[edge] = 0.0
        builder.edge_rest_length[edge] = float(a["hinge_lengths"][hinge])
        damping = builder.edge_bending_properties[edge][1]
        builder.edge_bending_properties[edge] = (float(a["hinge_ke"][hinge]), damping)
