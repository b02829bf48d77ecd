"""Random ray meshes and random triangles that they see: the data of section 8.1.1.

The thesis has "random points and normals" at the vertices of a mesh that is regular on the screen, and disconnected
triangles of which some must be seen. It does not tell their distributions. Ours: points in a cube and unit directions
without preference, as the numbers of its table C look. Neighbouring rays then have nothing in common, and every ray
triangle sees most of the scene. Mirrors and lenses do not do that: `roughness` takes the mesh from that (1) to parallel
rays from a plane (0).
"""

from __future__ import annotations

import numpy as np

from anamorph.cameras.grid import from_grid
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, Mesh, Scene, Sky

RADIUS = 0.35
"""Of a triangle, about its middle; the cube of the ray mesh reaches from -1 to 1."""
MOST_OF_ALL_SIZE = 640
"""So many are as large as this; more are smaller, so that all together stay as large. It is the thesis's most."""
NEAR, FAR = 0.2, 2.0
"""Where a triangle's middle is on its ray."""

_BLACK = (0.0, 0.0, 0.0)
LIGHTS = (AmbientLight((1.0, 1.0, 1.0), (1.0, 1.0, 1.0)),)
"""No lighting: what is seen are the vertex colours."""


def random_ray_mesh(quads: int, size: tuple[int, int], seed: int = 0, roughness: float = 1.0) -> RayMesh:
    """2 quads^2 ray triangles that fill an image of `size` (width, height) pixels."""
    generator = np.random.default_rng([seed, quads])
    steps = np.linspace(-1.0, 1.0, quads + 1)
    regular = np.stack([*np.meshgrid(steps, -steps), np.ones((quads + 1, quads + 1))], axis=-1)
    points = generator.uniform(-1.0, 1.0, regular.shape)
    directions = generator.normal(size=regular.shape)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    ahead = np.array([0.0, 0.0, -1.0])
    mixed = (1.0 - roughness) * ahead + roughness * directions
    return from_grid(
        (1.0 - roughness) * regular + roughness * points,
        mixed / np.linalg.norm(mixed, axis=-1, keepdims=True),
        size,
    )


def random_triangles(count: int, rays: RayMesh, seed: int = 0) -> Scene:
    """A scene of `count` triangles with vertex colours; the middle of each is on a ray of `rays`."""
    generator = np.random.default_rng([seed, count])
    corners = rays.faces[generator.integers(len(rays.faces), size=count)]
    weights = generator.dirichlet(np.ones(3), count)
    origins, directions = (np.einsum("nk,nkc->nc", weights, part[corners]) for part in (rays.origins, rays.directions))
    middles = origins + generator.uniform(NEAR, FAR, (count, 1)) * directions
    offsets = generator.normal(size=(count, 3, 3))
    offsets -= offsets.mean(axis=1, keepdims=True)
    offsets /= np.linalg.norm(offsets, axis=2, keepdims=True).max(axis=1, keepdims=True)
    radius = RADIUS * np.sqrt(min(1.0, MOST_OF_ALL_SIZE / count))
    return loose_triangles(
        "random-triangles", middles[:, None] + radius * offsets, generator.uniform(size=(count, 3, 3))
    )


def loose_triangles(name: str, corners: np.ndarray, colors: np.ndarray) -> Scene:
    """A scene of triangles with corners and colours (N, 3, 3) in one mesh, before black and without lighting."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mesh = Mesh(
        name="triangles",
        positions=corners.reshape(-1, 3).astype(np.float32),
        faces=np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3),
        normals=np.repeat(normals, 3, axis=0).astype(np.float32),
        material=Diffuse((1.0, 1.0, 1.0)),
        colors=colors.reshape(-1, 3).astype(np.float32),
    )
    return Scene(name, (mesh,), Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0)), LIGHTS, Sky(_BLACK, _BLACK, _BLACK))
