"""A scene from arrays: a convex mirror, which knows its exact shape, before a pyramid on a floor."""

import numpy as np

import anamorph as an


def flat(name, corners, material):
    """A mesh of triangles (F, 3, 3), each with the normal of its own plane."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return an.Mesh(
        name=name,
        positions=corners.reshape(-1, 3).astype(np.float32),
        faces=np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3),
        normals=np.repeat(normals, 3, axis=0).astype(np.float32),
        material=material,
    )


def convex_mirror(radius=2.0, half_width=0.25, half_height=0.16, columns=10, rows=7):
    """A cap of a sphere that bulges along +z, its middle at (0, 1, 0)."""
    sphere = an.Sphere(center=np.array([0.0, 1.0, -radius]), radius=radius)
    u = np.linspace(-half_width, half_width, columns)
    v = np.linspace(-half_height, half_height, rows)
    parameters = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1, 1)
    faces = (corner + np.array([0, 1, columns + 1, 0, columns + 1, columns])).reshape(-1, 3)
    return an.Mesh(
        name="mirror",
        positions=sphere.position(parameters).astype(np.float32),
        faces=faces.astype(np.int32),
        normals=sphere.normal(parameters).astype(np.float32),
        material=an.Mirror(reflectance=0.95),
        surface=sphere,
        parameters=parameters,
    )


base = np.array([[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]])
top = np.array([0.0, 0.9, 0.0])
sides = np.array([[base[i], base[(i + 1) % 4], top] for i in range(4)]) + np.array([-0.8, 0.0, 2.2])
ground = 8.0 * np.array([[base[0], base[1], base[2]], [base[0], base[2], base[3]]])

scene = an.Scene(
    name="pyramid",
    meshes=(
        convex_mirror(),
        flat("pyramid", sides, an.Diffuse((0.8, 0.3, 0.1))),
        flat("floor", ground, an.Diffuse((0.5, 0.5, 0.45))),
    ),
    camera=an.Camera(position=(0.9, 1.2, 2.4), target=(0.0, 1.0, 0.0), field_of_view=22.0),
)
an.render(scene, size=(640, 480), antialias=4).save("pyramid.png")
