"""Ray triangles as functions of the image: what a pixel's ray is, and which part of the image is theirs.

At the image point q = (x, y, 1) the weights of the three rays are linear in q, up to a common factor that cancels:
W = q P^-1, where the rows of P are the homogeneous image corners (x w, y w, w). So the ray's origin, its direction
and the sum of the weights are linear in q as well:

    o(q) = sum W_i o_i,    d(q) = sum W_i d_i,    s(q) = sum W_i,    the ray is o / s + t d / s,

and its Pluecker coordinates, the direction s d and the moment o x d, are quadratic. A weight is nowhere negative in the
triangle's part of the image, even where that runs through the plane of the eye.

Source: the ray triangle is that of Vallance 2005, equation 2.4; homogeneous images are new here.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any, NamedTuple

import numpy as np

from anamorph.methods.trilinear.domains import extent_of, given_domains, own_domains
from anamorph.raytriangle.boxes import SLACK, BoundingPlanes, beam_planes, bounding_planes
from anamorph.raytriangle.scaled import checked

FLAT = 1e-9
"""A ray triangle whose image is thinner than this, as a share of its length, covers no pixel."""


AT_ONCE = 1024
"""Ray triangles of one step."""


class Beams(NamedTuple):
    """K ray triangles, with places in pixels from a `center` each.

    The six terms of a quadratic are those of x x, x y, y y, x, y and 1.
    """

    number: np.ndarray
    """(K,) int32: which of the given ray triangles each one is: those that the image does not show are left out."""
    center: np.ndarray
    """(K, 2) float64, whole pixels."""
    anchor: np.ndarray
    """(K, 3) float64: the world point that origins and moments are relative to."""
    weights: np.ndarray
    """(K, 3, 3) float64: W = (x, y, 1) @ weights, with a common factor that makes them about 1."""
    origin: np.ndarray
    """(K, 3, 3) float64: o = origin @ (x, y, 1)."""
    direction: np.ndarray
    """(K, 3, 3) float64: d = direction @ (x, y, 1)."""
    scale: np.ndarray
    """(K, 3) float64: s = scale . (x, y, 1)."""
    line: np.ndarray
    """(K, 6, 3) float64: s d."""
    moment: np.ndarray
    """(K, 6, 3) float64: d x o."""
    domain: np.ndarray
    """(K, C, 2) float64: the corners of the part of the image that is its own, a little enlarged."""
    corners: np.ndarray
    """(K,) int64: how many corners that has."""
    extent: np.ndarray
    """(K, 4) float64: the middle of the box around that part, and half its width and height."""
    normals: np.ndarray
    """(K, N, 3) float64: see `BoundingPlanes`."""
    distances: np.ndarray
    """(K, N) float64: relative to the world's origin, less their slack."""
    spacing: float
    """Pixels between samples, the first half of it from the image's corner: nothing is planned that no sample sees.
    0 plans everything."""
    near: np.ndarray
    """(K,) float64: the t from which on things are seen."""


def making_beams(
    image: np.ndarray,
    origins: np.ndarray,
    directions: np.ndarray,
    size: tuple[int, int],
    near: float = 0.0,
    spacing: float = 0.0,
    domain: np.ndarray | None = None,
) -> Generator[None, None, Beams]:
    """The ray triangles that have a part in an image, in steps.

    Parameters
    ----------
    image : (K, 3, 3) array
        A row (x w, y w, w) for each corner, in pixels.
    origins, directions : (K, 3, 3) array
        A row for each ray; not all directions of a ray triangle may be 0.
    size : (width, height)
        Of the image, pixels.
    near : float
        What is nearer than this, along its ray, is not seen; metres.
    spacing : float
        Pixels between samples; see `Beams`.
    domain : (K, C, 2) array, optional
        Corners of a convex part of the image, pixels, in either order around it, that each ray triangle has in place
        of its own: its rays go on beyond its corners, as far as s is positive. One without an area is not shown.

    Raises
    ------
    AnamorphError
        If a number is not finite, or all directions of a ray triangle are 0.
    """
    parts = []
    for first in range(0, max(len(image), 1), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        own = None if domain is None else domain[some]
        part = _make_beams(image[some], origins[some], directions[some], size, near, spacing, own)
        parts.append(part._replace(number=part.number + np.int32(first)))
        yield
    if len(parts) == 1:
        return parts[0]
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in Beams._fields if name != "spacing"
    }
    return Beams(spacing=spacing, **arrays)


def _make_beams(
    image: np.ndarray,
    origins: np.ndarray,
    directions: np.ndarray,
    size: tuple[int, int],
    near: float,
    spacing: float,
    domain: np.ndarray | None,
) -> Beams:
    """The ray triangles of one step; see `making_beams`."""
    image = np.asarray(image, float)
    start = np.zeros((len(image), 2)) if domain is None else np.rint(np.mean(domain, axis=1))
    # Near its own place a small triangle keeps its digits.
    image = image - image[..., 2:] * np.pad(start, ((0, 0), (0, 1)))[:, None]
    length = np.linalg.norm(image, axis=-1)
    flat = np.abs(np.linalg.det(image)) <= FLAT * np.prod(length, axis=-1) / max(*size, 1)
    inverse = np.linalg.inv(np.where(flat[:, None, None], np.eye(3), image))
    if domain is None:
        part, corners = own_domains(inverse, size)
    else:
        part, corners = given_domains(np.asarray(domain, float) - start[:, None], inverse.sum(axis=2), start, size)
    shown = np.flatnonzero(~flat & (corners >= 3))
    image, origins, directions = (np.asarray(each, float)[shown] for each in (image, origins, directions))
    inverse, part, corners, start = inverse[shown], part[shown], corners[shown], start[shown]

    some = np.arange(part.shape[1]) < corners[:, None]
    middle = np.where(some[..., None], part, 0.0).sum(axis=1) / np.maximum(corners, 1)[:, None]
    center = np.rint(middle)
    inverse = inverse.copy()
    inverse[:, 2] += np.einsum("ki,kij->kj", center, inverse[:, :2])
    # A common factor of the weights means nothing: with this one they are about 1 in the middle.
    inverse /= np.maximum(np.abs(inverse[:, 2]).sum(axis=1), np.finfo(float).tiny)[:, None, None]

    anchor = origins.mean(axis=1) if len(origins) else np.zeros((0, 3))
    origin = np.einsum("kqi,kix->kxq", inverse, origins - anchor[:, None])
    direction = np.einsum("kqi,kix->kxq", inverse, directions)
    scale = inverse.sum(axis=2)
    pace = np.linalg.norm(directions, axis=-1).max(axis=-1, initial=0.0)
    near_t = near / np.maximum(pace, np.finfo(float).tiny)
    part = part - center[:, None]
    if domain is None:
        planes = bounding_planes(origins, directions)
    else:
        checked(origins, directions)
        planes = _planes_of(part, corners, origin, direction, scale, anchor)
    slack = planes.slack + SLACK * np.abs(planes.distances)
    return Beams(
        number=shown.astype(np.int32),
        center=start + center,
        anchor=anchor,
        weights=inverse,
        origin=np.ascontiguousarray(origin),
        direction=np.ascontiguousarray(direction),
        scale=scale,
        line=_products(np.einsum("kxq,kr->kqrx", direction, scale)),
        moment=_products(np.cross(direction.swapaxes(1, 2)[:, :, None], origin.swapaxes(1, 2)[:, None])),
        domain=part,
        corners=corners,
        extent=extent_of(part, corners),
        normals=planes.normals,
        distances=planes.distances - slack,
        spacing=spacing,
        near=near_t,
    )


def _products(outer: np.ndarray) -> np.ndarray:
    """Six terms (K, 6, 3) from the products (K, 3, 3, 3) of two linear functions' terms, those of x, y and 1."""
    pairs = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
    terms = [outer[:, i, j] + (outer[:, j, i] if i != j else 0.0) for i, j in pairs]
    return np.stack(terms, axis=1) if len(outer) else np.zeros((0, 6, 3))


def _planes_of(
    part: np.ndarray,
    corners: np.ndarray,
    origin: np.ndarray,
    direction: np.ndarray,
    scale: np.ndarray,
    anchor: np.ndarray,
) -> BoundingPlanes:
    """The planes of all rays in parts (K, C, 2) of the image: those at a part's corners hold all others."""
    used = np.where(np.arange(part.shape[1]) < corners[:, None], np.arange(part.shape[1]), 0)
    place = np.concatenate([np.take_along_axis(part, used[..., None], axis=1), np.ones((*used.shape, 1))], axis=2)
    s = np.einsum("kcq,kq->kc", place, scale)[..., None]
    origins = place @ origin.swapaxes(1, 2) / s + anchor[:, None]
    return beam_planes(origins, place @ direction.swapaxes(1, 2), np.arange(4) * corners[:, None] // 4)
