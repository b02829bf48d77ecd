"""The rays that go on from a mirror seen in a mirror: one more ray triangle for each pair of the plan.

Through image point q a ray triangle's ray meets the plane of mirror triangle m at P(q), and is reflected there to
r(q) = d - 2 (d . n) n, by normals n interpolated on m. Three sample points q_i stand for the pair's region (`samples`),
with the rays (P_i, r_i) there. Their lengths are left as the incident d(q), linear in q, makes them; and N_i is N(q),
d times the normal of m's plane, there. With the barycentric coordinates L_i(q) of q in the three,

    o'(q) = sum L_i N_i P_i,    d'(q) = sum L_i r_i,    s'(q) = sum L_i N_i = N(q),

which is a ray triangle of homogeneous image corners (x_i, y_i, 1) / N_i and directions r_i / N_i.

- Where m is flat, d' is r everywhere: that is linear in d, and d in q.
- Where the incident rays pass through one point E, as behind a flat mirror, o = s E + h d with a number h. Then with
  another, P = E + k d / N, which is linear over N: o' / s' is P everywhere. And o' = s' E' + k d' where m is flat, with
  the image E' of E in m: the following rays pass through one point again, and so on from mirror to mirror.
- s' is positive just where the rays come to m from the side that is seen.

What is wrong of other rays falls with the square of the region's size. A fourth point could be met, by weights and
lengths chosen for it; it is not done, because away from the four that was more wrong, ten to a hundred times where
samples lie nearly in a line or reflected rays are nearly parallel.

Source: Vallance 2005, section 7.2.3, names interpolated rays at vertices for several hits. Deviation: the samples are
corners of what is seen of m and not of m itself, and homogeneous.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.plan import Plan
from anamorph.methods.trilinear.samples import samples

DRAWN_IN = 1.0 / 32.0
"""By how much of the way to the middle samples are moved in from the corners of a region."""

LEAST_SLANT = 1.0 / 16.0
"""Samples move in until N is at least this share of what it is in their middle."""


@dataclass(frozen=True, eq=False)
class Following:
    """Ray triangles that follow pairs of a plan, as `making_beams` takes them.

    Parameters
    ----------
    image : (S, 3, 3) float64
        Homogeneous image corners (x w, y w, w), pixels; all w are positive.
    origins, directions : (S, 3, 3) float64
        On the plane of the scene triangle, and the reflected rays there, of about unit length in the middle.
    domain : (S, 4, 2) float64
        The rectangle of the image that holds all of the pair's pieces, pixels. It has no area, and `making_beams`
        does not show it, where rays do not meet the plane in the middle of the pieces, which rounding alone has left
        there.
    """

    image: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    domain: np.ndarray


def following_rays(beams: Beams, plan: Plan, chosen: np.ndarray, corners: np.ndarray, normals: np.ndarray) -> Following:
    """The reflected rays of pairs whose scene triangle is a mirror.

    Parameters
    ----------
    beams : Beams
    plan : Plan
        Of these beams.
    chosen : (S,) int array
        Rows of `plan.pair`.
    corners, normals : (F, 3, 3) array
        Positions and unit vertex normals of all scene triangles.

    Returns
    -------
    Following
    """
    chosen = np.asarray(chosen, np.int64)
    place, box = samples(plan, chosen)
    ray, face, side = plan.pair[chosen].T
    center, anchor = beams.center[ray], beams.anchor[ray]
    a, b, c = np.moveaxis(np.asarray(corners, float)[face] - anchor[:, None], 1, 0)
    normal = np.cross(b - a, c - a)
    toward = np.where(side == 0, 1.0, -1.0)[:, None] * normal
    place = _drawn_in(place, np.einsum("sxq,sx->sq", beams.direction[ray], toward))
    terms = np.concatenate([place, np.ones((len(chosen), 3, 1))], axis=2)
    incident = terms @ beams.direction[ray].swapaxes(1, 2)
    origin = terms @ beams.origin[ray].swapaxes(1, 2)
    scale = np.einsum("spq,sq->sp", terms, beams.scale[ray])
    slant = np.einsum("spi,si->sp", incident, toward)
    height = scale * _dot(a, toward)[:, None] - np.einsum("spi,si->sp", origin, toward)

    met = (slant > 0.0).all(axis=1) & (scale > 0.0).all(axis=1)
    slant, scale = np.where(met[:, None], slant, 1.0), np.where(met[:, None], scale, 1.0)
    incident = np.where(met[:, None, None], incident, -normal[:, None])
    point = np.where(
        met[:, None, None], (origin + (height / slant)[..., None] * incident) / scale[..., None], a[:, None]
    )
    weights = _weights(point, a, b, c, normal)
    at = np.einsum("spv,svi->spi", weights, np.asarray(normals, float)[face])
    square = _dot(at, at)
    # Opposite normals may leave none between them, where the mirror is as if it were not there.
    along = np.where(square > 0.0, 2.0 * _dot(incident, at) / np.where(square > 0.0, square, 1.0), 0.0)
    reflected = incident - along[..., None] * at

    corner_weights = slant.mean(axis=1, keepdims=True) / slant
    pace = np.linalg.norm(incident.mean(axis=1), axis=1)
    reflected = reflected / np.where(pace > 0.0, pace, 1.0)[:, None, None]
    terms[..., :2] += center[:, None]
    box = np.where(met[:, None], box, 0.0)
    return Following(
        image=terms * corner_weights[..., None],
        origins=point + anchor[:, None],
        directions=reflected * corner_weights[..., None],
        domain=box[:, [[0, 1], [2, 1], [2, 3], [0, 3]]] + center[:, None],
    )


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", a, b)


def _drawn_in(place: np.ndarray, slant: np.ndarray) -> np.ndarray:
    """Places (S, 3, 2) moved in to their middle, so far that N = slant . (x, y, 1) is well positive if it is there."""
    middle = place.mean(axis=1, keepdims=True)
    here = np.einsum("spq,sq->sp", place, slant[:, :2]) + slant[:, 2:]
    mean = here.mean(axis=1, keepdims=True)
    most = (1.0 - LEAST_SLANT) * np.maximum(mean, 0.0)
    share = np.clip(most / np.maximum(np.maximum(mean - here, most), np.finfo(float).tiny), 0.0, 1.0 - DRAWN_IN)
    return middle + share[..., None] * (place - middle)


def _weights(point: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Barycentric coordinates (S, P, 3) of points (S, P, 3) in triangles of normals (b - a) x (c - a)."""
    square = np.maximum(_dot(normal, normal), np.finfo(float).tiny)[:, None]
    offset = point - a[:, None]
    second = np.einsum("spi,si->sp", offset, np.cross(c - a, normal)) / square
    third = np.einsum("spi,si->sp", offset, np.cross(normal, b - a)) / square
    return np.stack([1.0 - second - third, second, third], axis=-1)
