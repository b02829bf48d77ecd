"""Mirrors of another curvature: the outline stays, and what lies rearmost; the exact surface bends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.lenses.lens import drop
from anamorph.scene.model import Mesh, Mirror
from anamorph.scene.pose import WORLD_UP, box_middle, mean_normal, upright_axes
from anamorph.scene.subdivision import subdivided
from anamorph.surfaces.base import Surface
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sag import SagSurface
from anamorph.surfaces.similarity import Similarity
from anamorph.surfaces.sphere import Sphere, round_surface

COMFORTABLE = 0.5
"""A control bends a mirror until its slope at the outline is that of a sphere whose radius is twice the reach."""

STEEPEST = 0.95
"""The greatest reach of a sphere's outline from its middle, in radii."""

LEAST_FACING = 0.05
"""The least cosine between a bent mirror's middle normal and any other."""

LEAST_TRIANGLES = 128
"""What a flat mirror is divided into before it is bent."""

SWELLING = 2.0
"""A control shrinks and swells a ball by this factor."""


@dataclass(frozen=True)
class Bend:
    """How a mirror is curved, and may be.

    Parameters
    ----------
    curvatures : tuple of float
        One over the radius, 1/m, positive where the mirror bulges outward; of a toroid those of both sections.
    limits : (low, high)
        What either may sensibly be bent to, 1/m.
    """

    curvatures: tuple[float, ...]
    limits: tuple[float, float]


def bend_of(mesh: Mesh) -> Bend | None:
    """How `mesh` is curved; None where it cannot be bent."""
    curvatures = own_curvatures(mesh.surface)
    if not isinstance(mesh.material, Mirror) or mesh.parameters is None or not curvatures:
        return None
    side = mesh.side
    signed = tuple(side * curvature for curvature in curvatures)
    if isinstance(mesh.surface, SagSurface):
        reach = float(np.linalg.norm(mesh.parameters, axis=1).max())
        if isinstance(mesh.surface, EvenAsphere):
            reach *= np.sqrt(max(1.0 + mesh.surface.conic, 1.0))
    else:
        middle = _middle(mesh)
        if middle is None:
            low, high = sorted((signed[0] / SWELLING, signed[0] * SWELLING))
            return Bend(signed, (low, high)) if signed[0] else None
        apex, axes = middle
        reach = float(np.linalg.norm((mesh.exact_positions() - apex) @ axes[:2].T, axis=1).max())
    most = max(map(abs, signed))
    limit = max(min(max(COMFORTABLE / reach, 1.25 * most), STEEPEST / reach), most)
    return Bend(signed, (-limit, limit))


def bent(mesh: Mesh, curvature: float | None = None, cross_curvature: float | None = None) -> Mesh:
    """A mirror bent to another curvature, with its exact surface.

    It keeps its outline: each vertex stays where it was as seen along the middle's normal, and of a toroid or an
    asphere, which keep their other numbers, along their axis. As a blank before a board it sinks nowhere behind what
    it hangs in: its rearmost vertex stays as deep as it was, on the rim of a convex mirror, in the middle of a concave
    one. A flat mirror becomes a part of a sphere, with more vertices. A ball swells or shrinks about its centre.

    Parameters
    ----------
    mesh : Mesh
    curvature : float, optional
        1/m, positive where the mirror bulges outward; of a toroid that of the circle of turning, of an asphere that
        at its apex.
    cross_curvature : float, optional
        Of a toroid, that of the turned arc.

    Returns
    -------
    Mesh
        The very same where it has this curvature already.
    """
    bend = bend_of(mesh)
    if bend is None:
        raise AnamorphError(
            f"part '{mesh.name}': cannot be bent; give a mirror of one exact plane, sphere, toroid or asphere"
        )
    if cross_curvature is not None and len(bend.curvatures) < 2:
        raise AnamorphError(f"part '{mesh.name}': has no cross_curvature, it is no toroid; give curvature")
    given = (curvature, cross_curvature)[: len(bend.curvatures)]
    wanted = tuple(old if new is None else new for old, new in zip(bend.curvatures, given, strict=True))
    if np.allclose(wanted, bend.curvatures, rtol=1e-12, atol=0.0):
        return mesh
    try:
        if isinstance(mesh.surface, Sphere) and _middle(mesh) is None:
            return _swollen(mesh, wanted[0])
        return _rounded(mesh, wanted[0]) if isinstance(mesh.surface, Plane | Sphere) else _sagged(mesh, wanted)
    except AnamorphError as error:
        raise AnamorphError(
            f"part '{mesh.name}': curvature {', '.join(f'{each:g}' for each in wanted)}: {error}"
        ) from None


def own_curvatures(surface: Surface | None) -> tuple[float, ...]:
    """One over the radii at the apex, 1/m, positive where the surface bulges to the side of its own normals."""
    match surface:
        case Plane():
            return (0.0,)
        case Sphere(radius=radius):
            return (1.0 / radius,)
        case SagSurface():
            return surface.apex_curvatures
    return ()


def recurved(surface: SagSurface, curvatures: tuple[float, ...], point: np.ndarray) -> SagSurface:
    """The surface with other `own_curvatures`, that goes through the same point below `point` (3,)."""
    at = surface.parameters(point[None])
    other = surface.with_apex_curvatures(curvatures)
    higher = other.sag(at)[0] - surface.sag(at)[0]
    return other.moved(Similarity.shift(higher * np.asarray(surface.axes, float)[2]))


def rise(before: np.ndarray, after: np.ndarray) -> float:
    """How far a bent mirror is lifted, metres, so that none of it is further back than its rearmost vertex was.

    Both (V,): the vertices' heights along its outward axis.
    """
    return float(before.min() - after.min())


def on_surface(mesh: Mesh, surface: Surface, parameters: np.ndarray, toward: np.ndarray) -> Mesh:
    """The mesh with its vertices at `parameters` (V, 2) of another surface, its normals `toward` (3,)."""
    return replace(
        mesh,
        positions=surface.position(parameters).astype(np.float32),
        normals=surface.normals_toward(parameters, toward[None]).astype(np.float32),
        surface=surface,
        parameters=parameters,
    )


def _middle(mesh: Mesh) -> tuple[np.ndarray, np.ndarray] | None:
    """The point of a plane or sphere in the middle of a mesh, (3,), and the axes there; None for one that closes."""
    outward = mean_normal((mesh,))
    if outward is None or not isinstance(mesh.surface, Plane | Sphere):
        return None
    center = box_middle((mesh,), upright_axes(outward, WORLD_UP))
    at = drop(mesh.surface, center[None], outward)
    normal = mesh.surface.normals_toward(at, outward[None])[0]
    if (np.asarray(mesh.normals, float) @ normal).min() < LEAST_FACING:
        return None
    return mesh.surface.position(at)[0], upright_axes(normal, WORLD_UP)


def _rounded(mesh: Mesh, curvature: float) -> Mesh:
    """A mesh of a plane or a sphere on another one."""
    middle = _middle(mesh)
    assert middle is not None
    apex, axes = middle
    if isinstance(mesh.surface, Plane):
        while len(mesh.faces) < LEAST_TRIANGLES:
            mesh = subdivided(mesh, 1)
    across = (mesh.exact_positions() - apex) @ axes[:2].T
    reach = float(np.linalg.norm(across, axis=1).max())
    if abs(curvature) * reach > STEEPEST:
        raise AnamorphError(
            f"its outline is out of reach; give a number from {-STEEPEST / reach:.3g} to {STEEPEST / reach:.3g}"
        )
    square = np.sum(across**2, axis=1)
    sag = curvature * square / (1.0 + np.sqrt(1.0 - curvature**2 * square))
    before = (mesh.exact_positions() - apex) @ axes[2]
    apex = apex + rise(before, -sag) * axes[2]
    surface: Surface = round_surface(apex, axes, curvature)
    points = apex + np.column_stack([across, -sag]) @ axes
    return on_surface(mesh, surface, surface.parameters(points), axes[2])


def _sagged(mesh: Mesh, curvatures: tuple[float, ...]) -> Mesh:
    """A mesh of a toroid, an asphere or the like with other curvatures."""
    surface, parameters = mesh.surface, mesh.parameters
    assert isinstance(surface, SagSurface) and parameters is not None
    side = mesh.side
    other = surface.with_apex_curvatures(tuple(side * curvature for curvature in curvatures))
    outward = side * np.asarray(surface.axes, float)[2]
    before, after = (-side * each.sag(parameters)[0] for each in (surface, other))
    lifted = other.moved(Similarity.shift(rise(before, after) * outward))
    return on_surface(mesh, lifted, parameters, outward)


def _swollen(mesh: Mesh, curvature: float) -> Mesh:
    """A ball of another radius about the same centre, or a piece of one that looks more than half around."""
    assert isinstance(mesh.surface, Sphere) and mesh.parameters is not None
    side = mesh.side
    if curvature * side <= 0.0:
        raise AnamorphError(f"it is a ball; give a {'positive' if side > 0.0 else 'negative'} number")
    surface = replace(mesh.surface, radius=1.0 / abs(curvature))
    return replace(mesh, positions=surface.position(mesh.parameters).astype(np.float32), surface=surface)
