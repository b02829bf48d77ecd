"""Mirrors of free shape bent further: curvature added to what is there, on patches and CAD surfaces, exactly.

Heights along the mirror's middle axis become z - c (x^2 + y^2) / 2, a paraboloid's sag more. Of a rational surface of
degree p this makes a rational surface of degree 2p, so that the bent mirror is a NURBS surface again, without error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.editing.bending import COMFORTABLE, LEAST_FACING, LEAST_TRIANGLES, on_surface, rise
from anamorph.scene.model import Mesh, Mirror
from anamorph.scene.pose import WORLD_UP, Pose, box_middle, mean_normal, upright_axes
from anamorph.scene.subdivision import subdivided
from anamorph.surfaces.base import Surface
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.bsplines import basis
from anamorph.surfaces.nurbs import NurbsSurface

CLAMPED = np.repeat([0.0, 1.0], 4)
"""The knots of a Bezier patch."""


@dataclass(frozen=True, eq=False)
class Arch:
    """What can be bent further, and how far.

    Parameters
    ----------
    pose : Pose
        The middle of the mirror, and its axes.
    limit : float
        What may sensibly be added to the curvature, to both sides, 1/m.
    """

    pose: Pose
    limit: float


def arch_of(meshes: Sequence[Mesh]) -> Arch | None:
    """How the faces of one mirror can be bent further; None where they are no patches, or look all ways."""
    if not meshes or not all(_free(mesh) for mesh in meshes):
        return None
    outward = mean_normal(meshes)
    if outward is None or min((np.asarray(mesh.normals, float) @ outward).min() for mesh in meshes) < LEAST_FACING:
        return None
    axes = upright_axes(outward, WORLD_UP)
    pose = Pose(box_middle(meshes, axes), axes)
    reach = max(float(np.linalg.norm(_local(mesh, pose)[:, :2], axis=1).max()) for mesh in meshes)
    return Arch(pose, COMFORTABLE / reach)


def arched(meshes: tuple[Mesh, ...], curvature: float) -> tuple[Mesh, ...]:
    """The faces of one mirror with `curvature` (1/m, positive toward its outside) added to their own.

    Each point stays where it was as seen along the middle axis, and the rearmost vertex as deep as it was.
    Without curvature the meshes are the very same.
    """
    arch = arch_of(meshes)
    if arch is None:
        raise AnamorphError(
            f"part '{meshes[0].name}': cannot be bent further; give a mirror of patches or CAD faces that look one way"
        )
    if curvature == 0.0:
        return meshes
    while sum(len(mesh.faces) for mesh in meshes) < LEAST_TRIANGLES:
        meshes = tuple(subdivided(mesh, 1) for mesh in meshes)
    pose, outward = arch.pose, arch.pose.axes[2]
    x, y, before = np.concatenate([_local(mesh, pose) for mesh in meshes]).T
    lifted = pose.center + rise(before, before - curvature * (x**2 + y**2) / 2.0) * outward
    changed = []
    for mesh in meshes:
        assert isinstance(mesh.surface, BezierPatch | NurbsSurface) and mesh.parameters is not None
        surface = arched_surface(mesh.surface, pose, curvature)
        surface = replace(surface, poles=surface.poles + (lifted - pose.center))
        changed.append(on_surface(mesh, surface, mesh.parameters, outward))
    return tuple(changed)


def arched_surface(surface: BezierPatch | NurbsSurface, pose: Pose, curvature: float) -> NurbsSurface:
    """The surface whose points are z - curvature (x^2 + y^2) / 2 high in `pose`, by the same parameters."""
    if isinstance(surface, BezierPatch):
        surface = NurbsSurface(np.asarray(surface.control, float), np.ones((4, 4)), CLAMPED, CLAMPED, 3, 3)
    local = (surface.poles - pose.center) @ pose.axes.T
    values = np.concatenate([local * surface.weights[..., None], surface.weights[..., None]], axis=-1)
    knots, solved = [], []
    for own, degree in ((surface.knots_u, surface.degree_u), (surface.knots_v, surface.degree_v)):
        doubled = _doubled(own, degree)
        # Where a spline of the new degree is told by its values: the averages of neighbouring knots.
        at = np.convolve(doubled, np.ones(2 * degree) / (2 * degree), "valid")[1:-1].clip(doubled[0], doubled[-1])
        values = np.swapaxes(np.tensordot(basis(own, degree, at), values, axes=1), 0, 1)
        knots.append(doubled)
        solved.append(basis(doubled, 2 * degree, at))
    x, y, z, weight = np.moveaxis(values, -1, 0)
    products = np.stack([x * weight, y * weight, z * weight - curvature * (x**2 + y**2) / 2.0, weight**2], axis=-1)
    try:
        for matrix in solved:
            rows = np.linalg.solve(matrix, products.reshape(len(products), -1))
            products = np.swapaxes(rows.reshape(products.shape), 0, 1)
    except np.linalg.LinAlgError:
        raise AnamorphError("NURBS: is torn along a knot, and cannot be bent further; export it in pieces") from None
    weights = products[..., 3] if np.ptp(surface.weights) else np.full(products.shape[:2], surface.weights.flat[0] ** 2)
    poles = pose.center + products[..., :3] / weights[..., None] @ pose.axes
    return NurbsSurface(poles, weights, knots[0], knots[1], 2 * surface.degree_u, 2 * surface.degree_v, surface.sign)


def _doubled(knots: np.ndarray, degree: int) -> np.ndarray:
    """Knots for the product of two splines over `knots`, as smooth as they are and twice their degree."""
    low, high = knots[degree], knots[-degree - 1]
    inner, counts = np.unique(knots[(knots > low) & (knots < high)], return_counts=True)
    return np.concatenate([[low] * (2 * degree + 1), np.repeat(inner, counts + degree), [high] * (2 * degree + 1)])


def _free(mesh: Mesh) -> bool:
    surface: Surface | None = mesh.surface
    free = isinstance(surface, BezierPatch | NurbsSurface) and mesh.parameters is not None
    return free and isinstance(mesh.material, Mirror)


def _local(mesh: Mesh, pose: Pose) -> np.ndarray:
    """The vertices, (V, 3) float64, in a pose's axes."""
    return (mesh.exact_positions() - pose.center) @ pose.axes.T
