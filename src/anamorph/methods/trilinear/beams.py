"""Ray triangles as functions of the image: what a sample's ray is, and which part of the image they own samples in.

Places in the image are in samples from a sample's centre. At the place q = (x, y, 1) the weights of the three rays are
linear in q, up to a common factor that cancels: W = q P^-1, where the rows of P are the homogeneous image corners
(x w, y w, w). So the ray's origin, its direction and the sum of the weights are linear in q as well:

    o(q) = sum W_i o_i,    d(q) = sum W_i d_i,    s(q) = sum W_i,    the ray is o / s + t d / s,

and its Pluecker coordinates, the direction s d and the moment o x d, are quadratic. A weight is nowhere negative in the
triangle's part of the image, even where that runs through the plane of the eye.

Source: the ray triangle is that of Vallance 2005, equation 2.4; homogeneous images are new here.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple

import numpy as np

from anamorph.raytriangle.camera_frames import Frames, frames_of
from anamorph.raytriangle.scaled import checked

AT_ONCE = 1024
"""Ray triangles of one step."""


class Beams(NamedTuple):
    """K ray triangles, with places in samples from a `center` each.

    The six terms of a quadratic are those of x x, x y, y y, x, y and 1.
    """

    number: np.ndarray
    """(K,) int32: which of the given ray triangles each one is."""
    box: np.ndarray
    """(K, 4) int64: the first column and row of the samples that it owns, and the last ones and one."""
    center: np.ndarray
    """(K, 2) int64: the column and row of the sample that places are relative to."""
    extent: np.ndarray
    """(K, 4) float64: the middle of the box, and half its width and height from the first to the last centre."""
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
    near: np.ndarray
    """(K,) float64: the t from which on things are seen."""


def making_beams(
    image: np.ndarray, origins: np.ndarray, directions: np.ndarray, box: np.ndarray, near: float = 0.0
) -> Generator[None, None, tuple[Beams, Frames]]:
    """Ray triangles as functions of the image, and by what they are culled, in steps.

    Parameters
    ----------
    image : (K, 3, 3) array
        A row (x w, y w, w) for each corner, in samples from the first one's centre.
    origins, directions : (K, 3, 3) array
        A row for each ray; not all directions of a ray triangle may be 0.
    box : (K, 4) int array
        See `Beams`.
    near : float
        What is nearer than this, along its ray, is not seen; metres.

    Raises
    ------
    AnamorphError
        If a number of a ray is not finite, or all directions of a ray triangle are 0.
    """
    origins, directions = checked(origins, directions)
    parts = []
    for first in range(0, max(len(image), 1), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        part = _make_beams(image[some], origins[some], directions[some], box[some], near)
        parts.append(part._replace(number=part.number + np.int32(first)))
        yield
    beams = Beams(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    return beams, frames_of(origins, directions)


def _make_beams(image: np.ndarray, origins: np.ndarray, directions: np.ndarray, box: np.ndarray, near: float) -> Beams:
    """The ray triangles of one step; see `making_beams`."""
    box = np.asarray(box, np.int64).reshape(-1, 4)
    center = (box[:, :2] + box[:, 2:]) // 2
    middle, half = 0.5 * (box[:, :2] + box[:, 2:] - 1), 0.5 * (box[:, 2:] - box[:, :2] - 1)
    # Near its own place a small triangle keeps its digits.
    image = np.array(image, float)
    image[..., :2] -= image[..., 2:] * center[:, None]
    rows = np.cross(np.roll(image, -1, axis=1), np.roll(image, -2, axis=1))
    # A common factor of the weights means nothing but by its sign: with this one they are about 1 in the middle.
    sign = np.where(np.einsum("ki,ki->k", image[:, 0], rows[:, 0]) < 0.0, -1.0, 1.0)
    inverse = (
        rows.swapaxes(1, 2) * (sign / np.maximum(np.abs(rows[..., 2]).sum(axis=1), np.finfo(float).tiny))[:, None, None]
    )

    anchor = origins.mean(axis=1)
    origin = np.einsum("kqi,kix->kxq", inverse, origins - anchor[:, None])
    direction = np.einsum("kqi,kix->kxq", inverse, directions)
    scale = inverse.sum(axis=2)
    pace = np.linalg.norm(directions, axis=-1).max(axis=-1, initial=0.0)
    return Beams(
        number=np.arange(len(image), dtype=np.int32),
        box=box,
        center=center,
        extent=np.concatenate([middle - center, half], axis=1),
        anchor=anchor,
        weights=inverse,
        origin=np.ascontiguousarray(origin),
        direction=np.ascontiguousarray(direction),
        scale=scale,
        line=_products(np.einsum("kxq,kr->kqrx", direction, scale)),
        moment=_products(np.cross(direction.swapaxes(1, 2)[:, :, None], origin.swapaxes(1, 2)[:, None])),
        near=near / np.maximum(pace, np.finfo(float).tiny),
    )


def _products(outer: np.ndarray) -> np.ndarray:
    """Six terms (K, 6, 3) from the products (K, 3, 3, 3) of two linear functions' terms, those of x, y and 1."""
    pairs = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
    return np.stack([outer[:, i, j] + (outer[:, j, i] if i != j else 0.0) for i, j in pairs], axis=1)
