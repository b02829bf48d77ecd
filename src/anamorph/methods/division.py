"""Dividing a ray mesh into patches, each of which one map can show.

Source: Kakimoto et al. 2007, section 4.1, which asks for it (Figure 6) and leaves it open. Patches share the vertices of
their borders, and what a vertex shows depends on its own ray alone: so the picture is continuous there.
"""

from __future__ import annotations

import numpy as np

from anamorph.raymesh import RayMesh, RayStatus

MOST_PATCHES = 64


def seen_faces(rays: RayMesh, size: tuple[int, int]) -> np.ndarray:
    """The numbers of the faces that may be seen in a picture of `size`: some vertex faces the eye, none are outside."""
    facing = (rays.status != RayStatus.BACK_FACING)[rays.faces].any(axis=1)
    x, y, w = rays.picture.T
    outside = (w <= 0.0, x < 0.0, x > size[0] * w, y < 0.0, y > size[1] * w)
    return np.flatnonzero(facing & ~np.any([beyond[rays.faces].all(axis=1) for beyond in outside], axis=0))


def divide(rays: RayMesh, faces: np.ndarray, widest: float) -> list[np.ndarray]:
    """Divide faces into patches, until the rays of each lie within a cone.

    The patch with the widest cone is halved across the direction in which its rays spread most.

    Parameters
    ----------
    rays : RayMesh
    faces : (N,) int
        The numbers of those to be divided.
    widest : float
        The cone's full angle at its tip, radians.

    Returns
    -------
    list of int arrays
        The faces of each patch.
    """
    if not len(faces):
        return []
    directions = rays.unit_directions()
    facing = rays.status == RayStatus.OK
    means = _mean_directions(directions, facing, rays.faces)
    waiting, done = [faces], []
    while waiting:
        patch = waiting.pop()
        vertices = np.unique(rays.faces[patch])
        vertices = vertices[facing[vertices]] if facing[vertices].any() else vertices
        limit = len(waiting) + len(done) + 1 >= MOST_PATCHES
        if len(patch) == 1 or limit or _cone(directions[vertices]) <= widest:
            done.append(patch)
            continue
        spread = means[patch] - means[patch].mean(axis=0)
        _, _, axes = np.linalg.svd(spread, full_matrices=False)
        along = spread @ axes[0]
        upper = along > 0.5 * (along.min() + along.max())
        if upper.all() or not upper.any():
            upper = np.arange(len(patch)) < len(patch) // 2
        waiting += [patch[upper], patch[~upper]]
    return done


def _mean_directions(directions: np.ndarray, facing: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The mean direction of each face's vertices that face the eye, or of all three."""
    weights = np.where(facing, 1.0, 1e-6)[faces]
    return np.einsum("fc,fci->fi", weights / weights.sum(axis=1, keepdims=True), directions[faces])


def _cone(directions: np.ndarray) -> float:
    """The full angle of the cone around unit directions' mean that holds them all."""
    mean = directions.mean(axis=0)
    length = np.linalg.norm(mean)
    if length < 1e-9:
        return 2.0 * np.pi
    return 2.0 * float(np.arccos(np.clip((directions @ mean).min() / length, -1.0, 1.0)))
