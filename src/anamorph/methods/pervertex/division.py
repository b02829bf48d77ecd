"""Dividing a ray mesh into patches, each of which one map can show.

Source: Kakimoto et al. 2007, section 4.1, which asks for it (Figure 6) and leaves it open. Patches share the vertices
of their borders, and what a vertex shows depends on its own ray alone: so the image is continuous there.
"""

from __future__ import annotations

import numpy as np

from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.optics.viewpoint import virtual_viewpoint
from anamorph.raymesh import RayMesh, RayStatus

MOST_PATCHES = 32
"""Into which a body is divided, even where that leaves some wider than asked for."""

MOST_PARTS = 8
"""Into which a patch of a closed body is halved, again and again."""

ALIKE = 1e-6
"""What differs by less, of directions or of lengths, is alike: vertices are not placed better."""


def seen_faces(rays: RayMesh, size: tuple[int, int]) -> np.ndarray:
    """The numbers, (N,), of the faces that may be seen in an image of `size` (width, height).

    Some vertex faces the eye, and not all three lie outside the image on the same side.
    """
    facing = (rays.status != RayStatus.BACK_FACING)[rays.faces].any(axis=1)
    x, y, w = rays.image.T
    outside = (w <= 0.0, x < 0.0, x > size[0] * w, y < 0.0, y > size[1] * w)
    return np.flatnonzero(facing & ~np.any([beyond[rays.faces].all(axis=1) for beyond in outside], axis=0))


def divide(rays: RayMesh, faces: np.ndarray, widest: float) -> list[np.ndarray]:
    """Divide faces into patches, until the rays of each lie within a cone.

    Axes of cones are chosen one by one, each along the ray that lies farthest outside the cones before it; each face
    goes to the nearest axis. That takes at most as many cones as would be needed of half the width.
    Source: Gonzalez, "Clustering to minimize the maximum intercluster distance" (1985).

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
    means = _mean_directions(directions, rays.status == RayStatus.OK, rays.faces[faces])
    first = means.mean(axis=0)
    length = np.linalg.norm(first)
    # Where faces look to all sides alike, no axis is the first.
    first = first / length if length > ALIKE else np.zeros(3)
    nearest = means @ first
    if nearest.min() >= np.cos(0.5 * widest):
        return [faces]
    patch = np.zeros(len(faces), int)
    start, nearest = _first_of_most(nearest), np.full(len(faces), -np.inf)
    for number in range(MOST_PATCHES):
        farthest = _first_of_most(-nearest) if number else start
        if nearest[farthest] >= np.cos(0.5 * widest):
            break
        closeness = means @ means[farthest]
        patch[closeness > nearest + ALIKE] = number
        nearest = np.maximum(nearest, closeness)
    return [faces[patch == number] for number in range(patch.max() + 1)]


def part_where_hidden(
    rays: RayMesh, faces: np.ndarray, surroundings: Surroundings, own: tuple[int, ...]
) -> list[np.ndarray]:
    """Halve a patch across its longest extent, until each part lies on one side of its viewpoint, with nothing between.

    For closed bodies, whose parts may look one way from far apart, with something between them.

    Parameters
    ----------
    rays : RayMesh
    faces : (N,) int
        Of the patch.
    surroundings : Surroundings
    own : tuple of int
        The object numbers of the body, which hide nothing.

    Returns
    -------
    list of int arrays
        The faces of each part, at most `MOST_PARTS`.
    """
    waiting: list[np.ndarray] = [faces]
    done: list[np.ndarray] = []
    while waiting:
        part = waiting.pop()
        vertices = np.unique(rays.faces[part])
        vertices = vertices[rays.status[vertices] == RayStatus.OK]
        middles = rays.origins[rays.faces[part]].mean(axis=1)
        middles = middles - middles.mean(axis=0)
        along = middles @ longest_extent(middles)
        upper = along > 0.5 * (along.min() + along.max())
        whole = upper.all() or not upper.any() or len(waiting) + len(done) + 2 > MOST_PARTS
        if whole or not len(vertices) or not _hidden(rays, vertices, surroundings, own):
            done.append(part)
        else:
            waiting += [part[upper], part[~upper]]
    return done


def _first_of_most(values: np.ndarray) -> int:
    """The first of those that are as great as any, so that it is no rounding error that tells equals apart."""
    return int(np.argmax(values >= values.max() - ALIKE))


def longest_extent(points: np.ndarray) -> np.ndarray:
    """The direction (3,) in which points around the origin lie farthest apart; of equals the one nearest to an axis."""
    values, vectors = np.linalg.eigh(points.T @ points)
    equals = vectors[:, values >= (1.0 - ALIKE) * values[-1]]
    return equals[:, 0] if equals.shape[1] == 1 else equals @ equals[_first_of_most(np.linalg.norm(equals, axis=1))]


def _hidden(rays: RayMesh, vertices: np.ndarray, surroundings: Surroundings, own: tuple[int, ...]) -> bool:
    origins, directions = rays.origins[vertices], rays.unit_directions()[vertices]
    viewpoint = virtual_viewpoint(origins, directions)
    ahead = np.einsum("ni,ni->n", viewpoint[3] * origins - viewpoint[:3], directions) > 0.0
    if ahead.all():
        return viewpoint[3] > 0.0 and not surroundings.sees(viewpoint[:3] / viewpoint[3], origins, own)
    return bool(ahead.any())


def _mean_directions(directions: np.ndarray, facing: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The mean direction of each face's vertices that face the eye, or of all three."""
    weights = np.where(facing, 1.0, 1e-6)[faces]
    means = np.einsum("fc,fci->fi", weights, directions[faces])
    return means / np.maximum(np.linalg.norm(means, axis=1, keepdims=True), 1e-12)
