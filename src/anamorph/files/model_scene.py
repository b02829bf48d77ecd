"""A model without a scene: stood on a chequered ground before a convex mirror, seen by an eye beside it.

One that has mirrors or glass of its own needs neither: an eye looks at it.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector
from anamorph.gallery.solids import lattice
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Mesh, Mirror, Scene, Texture
from anamorph.scene.pose import WORLD_UP, upright_axes
from anamorph.scene.triangles import doubled_areas
from anamorph.surfaces.sphere import Sphere

# All lengths are in units of the radius of the model's bounding sphere, so that any unit of length will do.
MODEL_DISTANCE = 2.6
EYE_DISTANCE = 5.0
MIRROR_RADIUS = 5.0
MIRROR_HALF_SIZE = (0.7, 0.56)
BORDER = 0.04
MIRROR_STEPS = (16, 12)
MIRROR_AZIMUTH = 30.0
EYE_AZIMUTH = 34.0
GROUND_HALF_SIZE = 30.0
SQUARE = 0.5
FIELD_OF_VIEW = 40.0
MARGIN = 1.1
ASIDE = 25.0


def stand_before_mirror(meshes: tuple[Mesh, ...], name: str) -> Scene:
    """The model in its own coordinates, y up, with ground, mirror and eye around it.

    With f half the mirror's radius, E the eye's and D the model's distance from the mirror, a length r at the model
    covers r f E / (E (D + f) + f D) of the mirror (the mirror equation, and similar triangles from the eye): 0.39 r
    here, so that the model's bounding sphere fills 70 percent of the mirror's height, and most models half of it.
    The mirror faces half-way between eye and model, which puts the model's middle into the mirror's.
    """
    middle, unit, low = _extent(meshes, name)
    height = max(middle[1] + 0.15 * unit, low[1] + 1.1 * MIRROR_HALF_SIZE[1] * unit)
    center = middle + MODEL_DISTANCE * unit * _level(MIRROR_AZIMUTH)
    center[1] = height
    eye = center + EYE_DISTANCE * unit * _level(MIRROR_AZIMUTH + 180.0 + EYE_AZIMUTH)
    eye[1] = height + 0.25 * unit
    outward = _unit(_unit(eye - center) + _unit(middle - center))
    ground = _ground(np.array([middle[0], low[1], middle[2]]), unit)
    aside = 0.25 * unit * _unit(np.cross([0.0, 1.0, 0.0], center - eye))
    target = center + aside * np.sign(np.dot(aside, middle - center))
    return Scene(
        name=name,
        meshes=(*_mirror(center, outward, unit), ground, *meshes),
        camera=Camera(_tuple(eye), _tuple(target), field_of_view=24.0),
    )


def seen_as_itself(meshes: tuple[Mesh, ...], name: str) -> Scene:
    """The model and nothing else, all of it in the image, from the side to which most of its mirrors and lenses face.

    Where they face all ways, or straight up or down, it is the side of +z. The eye stands a little to the right of
    that, and above: a flat mirror seen squarely would show no more than what is behind the eye.
    """
    middle, unit, _ = _extent(meshes, name)
    facing = sum((_facing(mesh) for mesh in meshes if mesh.specular), start=np.zeros(3))
    azimuth = np.degrees(np.arctan2(facing[0], facing[2])) if np.hypot(facing[0], facing[2]) > 0.1 else 0.0
    away = _unit(_level(azimuth + ASIDE) + np.array([0.0, np.sin(np.radians(ASIDE)), 0.0]))
    eye = middle + MARGIN * unit / np.sin(np.radians(FIELD_OF_VIEW / 2.0)) * away
    return Scene(name, meshes, Camera(_tuple(eye), _tuple(middle), field_of_view=FIELD_OF_VIEW))


def _facing(mesh: Mesh) -> np.ndarray:
    """The way that a mesh faces, (3,): a unit vector for a flat one, 0 for a closed one."""
    areas = doubled_areas(mesh.positions, mesh.faces)
    return areas.sum(axis=0) / np.linalg.norm(areas, axis=1).sum()


def _extent(meshes: tuple[Mesh, ...], name: str) -> tuple[np.ndarray, float, np.ndarray]:
    """The middle of a model's box, the greatest distance from it, and the box's lowest corner."""
    points = np.concatenate([mesh.positions for mesh in meshes]).astype(float)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2.0
    unit = float(np.linalg.norm(points - middle, axis=1).max())
    if not (np.isfinite(unit) and unit > 0):
        raise AnamorphError(f"{name}: has no extent; give a model that is more than a point")
    return middle, unit, low


def _level(azimuth: float) -> np.ndarray:
    """The horizontal unit vector at `azimuth` degrees from +z toward +x."""
    return np.array([np.sin(np.radians(azimuth)), 0.0, np.cos(np.radians(azimuth))])


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def _tuple(vector: np.ndarray) -> Vector:
    return (float(vector[0]), float(vector[1]), float(vector[2]))


def _mirror(center: np.ndarray, outward: np.ndarray, unit: float) -> tuple[Mesh, Mesh]:
    """A mirror that is a cap of a sphere, bulging along `outward` at `center`, and the dark plate that it is set in."""
    radius = MIRROR_RADIUS * unit
    middle, axes = center - radius * outward, upright_axes(outward, WORLD_UP)
    width, height = MIRROR_HALF_SIZE
    plate = Sphere(middle, radius - BORDER / 2.0 * unit, axes)
    return (
        _cap("mirror", Sphere(middle, radius, axes), (width, height), Mirror()),
        _cap("mirror-plate", plate, (width + BORDER, height + BORDER), Diffuse((0.02, 0.02, 0.025))),
    )


def _cap(name: str, sphere: Sphere, half_size: tuple[float, float], material: Mirror | Diffuse) -> Mesh:
    """The part of a sphere around its outward axis, `half_size` model radii to the side and up."""
    spans = np.arcsin(np.array(half_size) / MIRROR_RADIUS)
    columns, rows = (np.linspace(-span, span, steps + 1) for span, steps in zip(spans, MIRROR_STEPS, strict=True))
    parameters = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    return Mesh.exact(name, sphere, parameters, lattice(len(rows), len(columns)), material)


def _ground(center: np.ndarray, unit: float) -> Mesh:
    squares = np.kron(np.indices((2, 2)).sum(axis=0) % 2, np.ones((64, 64), int))
    pixels = np.array([[108, 112, 116, 255], [176, 176, 170, 255]], np.uint8)[squares]
    corners = np.array([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]])
    texcoords = corners[:, [0, 2]] * GROUND_HALF_SIZE / (2.0 * SQUARE)
    return Mesh(
        name="ground",
        positions=(center + GROUND_HALF_SIZE * unit * corners).astype(np.float32),
        faces=np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        normals=np.tile(np.array([0.0, 1.0, 0.0], np.float32), (4, 1)),
        material=Diffuse((1.0, 1.0, 1.0), Texture(pixels)),
        texcoords=texcoords.astype(np.float32),
    )
