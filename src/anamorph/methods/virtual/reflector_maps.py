"""Cube maps of a reflector's positions and normals around its middle: all that the paper's search knows of it.

Source: Estalella et al. 2005, section 4.1. Deviation: a texel holds the exact surface in its own direction, and not
what is interpolated between vertices that are drawn there; each face has a border of one texel, so that lookups need
no other face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Mesh, Scene
from anamorph.surfaces.intersection import intersect
from anamorph.surfaces.sphere import Sphere

BORDER = 1
"""Texels around a face that look beyond it."""

FLAT = 0.02
"""How far, as a share of its size, a body may reach over its tangent planes and still be convex: meshes have facets."""

LEVEL = 1e-6
"""How far, as a share of its size, a plane's vertices may be off it, and the ends of its normals apart."""

COMPARED = 500
"""Vertices whose tangent planes are compared with all others."""

REMEDY = "leave search=cubemap out"


@dataclass(frozen=True, eq=False)
class ReflectorMaps:
    """What is known of a reflector, by directions from its middle.

    Parameters
    ----------
    center : (3,) float64
        Metres.
    positions : (6, n + 2, n + 2, 3) float64
        Less the centre, metres. Faces are +x, -x, +y, -y, +z, -z; rows go along the second axis after the face's own,
        columns along the first, as x, y, z and x again.
    normals : (6, n + 2, n + 2, 3) float64
        Unit, on the side that reflects.
    outside : bool
        Whether that is the outside of the body.
    """

    center: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    outside: bool

    @property
    def size(self) -> int:
        """Texels along each side of a face."""
        return self.positions.shape[1] - 2 * BORDER

    @property
    def reach(self) -> float:
        """How far the reflector is from its middle at most, metres."""
        return float(np.linalg.norm(self.positions, axis=-1).max())


@dataclass(frozen=True, eq=False)
class FlatReflector:
    """A plane, which needs no maps: a point's virtual one is its mirror image.

    Parameters
    ----------
    center, normal : (3,) float64
        A point of it, metres; unit, on the side that reflects.
    """

    center: np.ndarray
    normal: np.ndarray


def texel_directions(size: int) -> np.ndarray:
    """Directions of all texels with their borders, (6, size + 2, size + 2, 3): on the cube, not unit."""
    places = (np.arange(-BORDER, size + BORDER) + 0.5) / size * 2.0 - 1.0
    directions = np.empty((6, len(places), len(places), 3))
    for face in range(6):
        axis = face // 2
        directions[face, ..., axis] = 1.0 - 2.0 * (face % 2)
        directions[face, ..., (axis + 1) % 3] = places
        directions[face, ..., (axis + 2) % 3] = places[:, None]
    return directions


def reflector_maps(meshes: tuple[Mesh, ...], size: int) -> ReflectorMaps | FlatReflector:
    """The maps of a body of mirrors, or that it is a plane.

    Parameters
    ----------
    meshes : tuple of Mesh
        Closed together. Part of a sphere stands for all of it.
    size : int
        Texels along each side of a face.

    Raises
    ------
    AnamorphError
        The body is open, is not seen whole from its middle, or is neither convex nor concave.
    """
    name = meshes[0].name
    vertices, normals = (
        np.concatenate([np.asarray(getattr(mesh, each), float) for mesh in meshes]) for each in ("positions", "normals")
    )
    if (
        np.abs((vertices - vertices[0]) @ normals.T).max() <= LEVEL * np.ptp(vertices, axis=0).max()
        and np.ptp(normals, axis=0).max() <= LEVEL
    ):
        return FlatReflector(vertices[0], normals[0] / np.linalg.norm(normals[0]))
    directions = texel_directions(size)
    units = (directions / np.linalg.norm(directions, axis=-1, keepdims=True)).reshape(-1, 3)
    surface = meshes[0].surface
    if len(meshes) == 1 and isinstance(surface, Sphere) and meshes[0].parameters is not None:
        center = np.asarray(surface.center, float)
        positions, outward = surface.radius * units, units
        sides = np.sign(np.einsum("vi,vi->v", normals, vertices - center))
    else:
        center, positions, normals = _around(name, meshes, units)
        outward = normals * np.sign(np.einsum("ni,ni->n", normals, units))[:, None]
        sides = np.sign(np.einsum("ni,ni->n", normals, units))
    if not (sides == sides[0]).all():
        raise AnamorphError(f"mirror '{name}': its front is inside and outside of one body; {REMEDY}")
    _check_convex(name, positions, outward)
    shape = directions.shape
    return ReflectorMaps(center, positions.reshape(shape), (sides[0] * outward).reshape(shape), bool(sides[0] > 0.0))


def _around(name: str, meshes: tuple[Mesh, ...], units: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The middle of a body, and positions from there and front normals in the given directions."""
    geometry = flatten(Scene("body", meshes, Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))))
    points = np.asarray(geometry.positions, float)[np.unique(geometry.faces)]
    center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    caster, starts = Caster(geometry), np.broadcast_to(center, units.shape)
    hits = caster.cast(starts, units)
    if (hits.triangle < 0).any():
        raise AnamorphError(f"mirror '{name}': is open, or its middle is not inside; close it, or {REMEDY}")
    if (caster.cast(starts, units, near=hits.distance * (1.0 + 1e-3)).triangle >= 0).any():
        raise AnamorphError(f"mirror '{name}': not all of it is seen from its middle; {REMEDY}")
    corners = geometry.faces[hits.triangle]
    weights = np.column_stack([1.0 - hits.barycentric.sum(axis=1), hits.barycentric])
    normals = np.einsum("nk,nki->ni", weights, np.asarray(geometry.normals, float)[corners])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    positions = hits.distance[:, None] * units
    owners = geometry.face_object[hits.triangle].astype(int)
    for number, mesh in enumerate(meshes, start=1):
        own = np.flatnonzero(owners == number)
        if mesh.surface is None or mesh.parameters is None or not len(own):
            continue
        first = geometry.first_vertex[number - 1]
        starting = np.einsum("nk,nki->ni", weights[own], np.asarray(mesh.parameters, float)[corners[own] - first])
        exact, direction, ok = intersect(mesh.surface, starts[own], units[own], starting)
        positions[own[ok]] = exact[ok] - center
        turned = np.sign(np.einsum("ni,ni->n", direction, normals[own]))
        normals[own[ok]] = (turned[:, None] * direction)[ok]
    return center, positions, normals


def _check_convex(name: str, positions: np.ndarray, outward: np.ndarray) -> None:
    chosen = np.linspace(0, len(positions) - 1, min(len(positions), COMPARED)).astype(int)
    heights = positions @ outward[chosen].T - np.einsum("ni,ni->n", positions[chosen], outward[chosen])
    if heights.max() > FLAT * np.abs(positions).max():
        raise AnamorphError(f"mirror '{name}': is neither convex nor concave; {REMEDY}")
