"""Small scenes that the tests of the methods share, and what draws them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.frame import Frame, View
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.solids import box, grid, lattice
from anamorph.gallery.textures import checkerboard
from anamorph.methods import Specification
from anamorph.methods.session import Session
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Mesh, Mirror, Scene, Sky
from anamorph.surfaces.sphere import Sphere

SIZE = (160, 120)
CENTER = np.array([0.0, 0.5, 0.0])
"""Where the small mirrors stand, looking along +z."""

CAMERA = Camera(position=(0.25, 0.65, 0.9), target=(0.0, 0.5, 0.0), field_of_view=32.0)


def spherical_mirror(radius: float = 1.4, count: int = 8, half: tuple[float, float] = (0.2, 0.15)) -> Mesh:
    """A patch of count x count cells on a sphere, which bulges toward +z; a negative radius hollows it."""
    turn = np.diag([1.0, 1.0, 1.0]) if radius > 0 else np.diag([-1.0, 1.0, -1.0])
    sphere = Sphere(CENTER - [0.0, 0.0, radius], abs(radius), turn)
    u, v = (np.linspace(-h / abs(radius), h / abs(radius), count + 1) for h in half)
    uv = np.stack([each.ravel() for each in np.meshgrid(u, v)], axis=-1)
    side = 1.0 if radius > 0 else -1.0
    faces = lattice(count + 1, count + 1)
    return Mesh(
        name="mirror",
        positions=sphere.position(uv).astype(np.float32),
        faces=(faces if radius > 0 else faces[:, ::-1]).astype(np.int32),
        normals=(side * sphere.normal(uv)).astype(np.float32),
        material=Mirror(tint=(1.0, 0.95, 0.9), reflectance=0.8),
        surface=sphere,
        parameters=uv,
    )


def flat_mirror() -> Mesh:
    """Two triangles that look along +z."""
    return plane_mirror("mirror", (-0.2, 0.35, 0.0), (0.4, 0.0, 0.0), (0.0, 0.3, 0.0))


def part_of_mesh(mesh: Mesh, faces: np.ndarray, name: str) -> Mesh:
    """Some faces of a mesh, with the vertices that they need."""
    vertices, corners = np.unique(mesh.faces[faces], return_inverse=True)
    return replace(
        mesh,
        name=name,
        positions=mesh.positions[vertices],
        normals=mesh.normals[vertices],
        parameters=mesh.parameters[vertices],
        faces=corners.reshape(-1, 3).astype(np.int32),
    )


def surroundings() -> tuple[Mesh, ...]:
    """A chequered floor with boxes on it, before the mirror and behind the eye, and two that are seen directly."""
    board = Diffuse(color=(1.0, 1.0, 1.0), texture=checkerboard(64, 2, (220, 210, 200), (60, 70, 80)))
    places = [
        ((-1.2, 0.0, 1.6), (-0.7, 0.9, 2.0), (0.7, 0.1, 0.1)),
        ((-0.2, 0.0, 2.4), (0.3, 1.2, 2.9), (0.1, 0.6, 0.2)),
        ((0.8, 0.0, 1.3), (1.2, 0.6, 1.7), (0.1, 0.2, 0.7)),
        ((-0.15, 0.0, 0.25), (-0.08, 0.4, 0.32), (0.8, 0.7, 0.1)),
        ((0.12, 0.0, -0.5), (0.3, 0.75, -0.4), (0.6, 0.2, 0.6)),
    ]
    boxes = [
        box(low, high).mesh(f"box-{number}", Diffuse(color=color)) for number, (low, high, color) in enumerate(places)
    ]
    floor = grid((-4.0, 0.0, 5.0), (8.0, 0.0, 0.0), (0.0, 0.0, -7.0), (4, 4), (0, 0, 8, 7))
    return (floor.mesh("floor", board), *boxes)


def scene_with(*mirrors: Mesh, camera: Camera = CAMERA, sky: Sky | None = None) -> Scene:
    return Scene("test", (*mirrors, *surroundings()), camera, sky=Sky() if sky is None else sky)


def sky_scene(mirror: Mesh, sky: Sky | None = None, camera: Camera = CAMERA) -> Scene:
    """A mirror alone under the sky."""
    return Scene("sky", (mirror,), camera, sky=Sky() if sky is None else sky)


def open_view(scene: Scene, specification: str, size: tuple[int, int] = SIZE) -> Session:
    return Specification.parse(specification).open(View(scene, scene.camera, size))


def drawn(scene: Scene, specification: str, size: tuple[int, int] = SIZE, camera: Camera | None = None) -> Frame:
    """One frame with its seen buffers."""
    session = open_view(scene if camera is None else replace(scene, camera=camera), specification, size)
    session.draw(camera or scene.camera)
    return session.frame(seen=True)


def pixels_of(camera: Camera, size: tuple[int, int], points: np.ndarray) -> np.ndarray:
    """Image coordinates (..., 2) of world points, by similar triangles, float64."""
    across, up, depth = np.moveaxis((np.asarray(points, float) - camera.position) @ camera.axes().T, -1, 0)
    focal = size[1] / (2.0 * np.tan(np.radians(camera.field_of_view) / 2.0))
    return np.stack([size[0] / 2.0 + focal * across / depth, size[1] / 2.0 - focal * up / depth], axis=-1)


def open_edges(*meshes: Mesh) -> set[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Edges, from place to place, that no triangle of these meshes runs along the other way: borders and cracks."""
    starts, stops = [], []
    for mesh in meshes:
        # Adding zero turns -0 into 0.
        corners = mesh.positions[mesh.faces] + np.float32(0.0)
        starts += map(tuple, corners.reshape(-1, 3).tolist())
        stops += map(tuple, np.roll(corners, -1, axis=1).reshape(-1, 3).tolist())
    edges = set(zip(starts, stops, strict=True))
    return {edge for edge in edges if edge[::-1] not in edges}
