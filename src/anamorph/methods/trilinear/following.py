"""The rays that go on from a mirror seen in a mirror: one more ray triangle for each pair that samples see.

Through image point q a ray triangle's ray meets the plane of mirror triangle m at P(q), and is reflected there to
r(q) = d - 2 (d . n) n, by normals n interpolated on m. Three places q_i stand for the samples that see m so
(`samples`), with the rays (P_i, r_i) there. Their lengths are left as the incident d(q), linear in q, makes them; and
N_i is N(q), d times the normal of m's plane, there. With the barycentric coordinates L_i(q) of q in the three,

    o'(q) = sum L_i N_i P_i,    d'(q) = sum L_i r_i,    s'(q) = sum L_i N_i = N(q),

which is a ray triangle of homogeneous image corners (x_i, y_i, 1) / N_i and directions r_i / N_i.

- Where m is flat, d' is r everywhere: that is linear in d, and d in q.
- Where the incident rays pass through one point E, as behind a flat mirror, o = s E + h d with a number h. Then with
  another, P = E + k d / N, which is linear over N: o' / s' is P everywhere. And o' = s' E' + k d' where m is flat, with
  the image E' of E in m: the following rays pass through one point again, and so on from mirror to mirror.
- s' is positive just where the rays come to m from the side that is seen.

The corners of the ray triangle are those of a triangle of the image around the samples, with the rays that these
functions give there. One of its sides runs along the samples with the least N, and it widens to where N is greater, so
that N is positive in all of it.

What is wrong of other rays falls with the square of the samples' extent. A fourth point could be met, by weights and
lengths chosen for it; it is not done, because away from the four that was more wrong, ten to a hundred times where
samples lie nearly in a line or reflected rays are nearly parallel.

Source: Vallance 2005, section 7.2.3, names interpolated rays at vertices for several hits. Deviation: these
stand where samples see m and not at its own vertices, and are homogeneous.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from anamorph.gpu.visibility import Rectangle
from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.ray_records import SPECULAR
from anamorph.methods.trilinear.samples import spread
from anamorph.methods.trilinear.sights import Sights

DRAWN_IN = 1.0 / 8.0
"""By how much of the way to their middle places move in from the outermost of more than three samples: what is wrong
between them shrinks, and grows at the outermost. Three samples or fewer stay where they are."""

LEAST_SLANT = 1.0 / 16.0
"""Places move in further until N is at least this share of what it is in their middle."""

AROUND = 1.0 / 8.0
"""Samples by which a ray triangle is wider than those that it is for."""


class Sending(NamedTuple):
    """Samples that see the fronts of mirrors, in S groups: of one ray triangle and one mirror's triangle each."""

    ray_triangle: np.ndarray
    """(S,) int64: its place in the `Beams`."""
    face: np.ndarray
    """(S,) int64"""
    first: np.ndarray
    """(S + 1,) int64: where each group's samples begin, and where the last one's end."""
    place: np.ndarray
    """(M, 2) int64: columns and rows."""


@dataclass(frozen=True, eq=False)
class Following:
    """Ray triangles that follow groups of samples, as `making_beams` takes them, S of them.

    Parameters
    ----------
    image : (S, 3, 3) float64
        Homogeneous image corners (x w, y w, w), samples from the first one's centre; all w are positive.
    origins, directions : (S, 3, 3) float64
        On the plane of the mirror's triangle, and the reflected rays there, of about unit length in the middle.
    box : (S, 4) int64
        The first column and row of the samples, and the last ones and one.
    met : (S,) bool
        Whether there are such rays. Rays that meet the plane where rounding alone has let them meet it are not
        followed.
    """

    image: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    box: np.ndarray
    met: np.ndarray


def sending(sights: Sights, beams: Beams, mirror: np.ndarray, goes_on: np.ndarray, rectangle: Rectangle) -> Sending:
    """The samples of a rectangle whose rays are sent on by mirrors.

    Parameters
    ----------
    sights, beams
        Of the rays that come to the mirrors.
    mirror : (F,) bool
        Which scene triangles are mirrors.
    goes_on : (K,) bool
        Which of the beams are followed.
    rectangle : (x0, y0, x1, y1)
    """
    x0, y0, x1, y1 = rectangle
    owner, seen = sights.owner[y0:y1, x0:x1], sights.seen[y0:y1, x0:x1]
    row, column = np.nonzero((owner >= 0) & (seen & SPECULAR > 0))
    face = (seen[row, column] & ~SPECULAR).astype(np.int64) - 1
    place_of = np.zeros(int(beams.number.max(initial=-1)) + 1, np.int64)
    place_of[beams.number] = np.arange(len(beams.number))
    ray_triangle = place_of[owner[row, column]]
    chosen = mirror[face] & goes_on[ray_triangle]
    row, column, face, ray_triangle = row[chosen], column[chosen], face[chosen], ray_triangle[chosen]
    key = ray_triangle * len(mirror) + face
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    place = np.column_stack([x0 + column, y0 + row])[order]
    return Sending(ray_triangle[order][first], face[order][first], np.append(first, len(order)), place)


def following_rays(beams: Beams, sent: Sending, corners: np.ndarray, normals: np.ndarray) -> Following:
    """The rays that mirrors reflect.

    Parameters
    ----------
    beams : Beams
        Of the rays that come to them.
    sent : Sending
    corners, normals : (F, 3, 3) array
        Positions and unit vertex normals of all scene triangles.
    """
    ray, face, first = sent.ray_triangle, sent.face, sent.first[:-1]
    center, anchor = beams.center[ray], beams.anchor[ray]
    a, b, c = np.moveaxis(np.asarray(corners, float)[face] - anchor[:, None], 1, 0)
    normal = np.cross(b - a, c - a)
    # The front of the mirror is seen.
    toward = -normal
    slants = np.einsum("sxq,sx->sq", beams.direction[ray], toward)
    sample = (sent.place - np.repeat(center, np.diff(sent.first), axis=0)).astype(float)
    drawn_in = np.where(np.diff(sent.first) > 3, DRAWN_IN, 0.0)
    place = _drawn_in(spread(sample, first, sent.first[1:]), slants, drawn_in)
    terms = np.concatenate([place, np.ones((len(ray), 3, 1))], axis=2)
    incident = terms @ beams.direction[ray].swapaxes(1, 2)
    origin = terms @ beams.origin[ray].swapaxes(1, 2)
    scale = np.einsum("spq,sq->sp", terms, beams.scale[ray])
    slant = np.einsum("spq,sq->sp", terms, slants)
    height = scale * _dot(a, toward)[:, None] - np.einsum("spi,si->sp", origin, toward)

    low, high = _ends(sample, first)
    around = _around(sample, sent.first, slants)
    ahead = np.einsum("scq,sq->sc", around, slants)
    met = (slant > 0.0).all(axis=1) & (scale > 0.0).all(axis=1) & (ahead > 0.0).all(axis=1)
    slant, scale, ahead = (np.where(met[:, None], each, 1.0) for each in (slant, scale, ahead))
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

    pace = np.linalg.norm(incident.mean(axis=1), axis=1)
    reflected = reflected / np.where(pace > 0.0, pace, 1.0)[:, None, None]
    shares = around @ np.linalg.inv(np.where(met[:, None, None], terms, np.eye(3)))
    corner_weights = (slant.mean(axis=1, keepdims=True) / ahead)[..., None]
    around[..., :2] += center[:, None]
    return Following(
        image=around * corner_weights,
        origins=shares @ (slant[..., None] * point) / ahead[..., None] + anchor[:, None],
        directions=shares @ reflected * corner_weights,
        box=np.concatenate([low + center, high + center + 1], axis=1).astype(np.int64),
        met=met,
    )


def _ends(values: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least and the greatest of each group of rows that begins at `first`."""
    if not len(first):
        return values[:0], values[:0]
    return np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)


def _around(sample: np.ndarray, first: np.ndarray, slants: np.ndarray) -> np.ndarray:
    """Corners (S, 3, [x, y, 1]) of triangles around groups of samples, in which the slants are positive."""
    steepness = np.linalg.norm(slants[:, :2], axis=1)
    steep = steepness > 0.0
    up = np.where(steep[:, None], slants[:, :2] / np.where(steep, steepness, 1.0)[:, None], [1.0, 0.0])
    across = np.column_stack([-up[:, 1], up[:, 0]])
    groups = np.repeat(np.arange(len(slants)), np.diff(first))
    low, high = _ends(np.column_stack([_dot(sample, up[groups]), _dot(sample, across[groups])]), first[:-1])
    least = steepness * low[:, 0] + slants[:, 2]
    margin = np.where(steep, np.minimum(AROUND, 0.5 * least / np.where(steep, steepness, 1.0)), AROUND)
    height, width = high[:, 0] - low[:, 0] + margin + AROUND, high[:, 1] - low[:, 1] + 2.0 * AROUND
    base, middle = low[:, 0] - margin, 0.5 * (low[:, 1] + high[:, 1])
    heights = np.stack([base, base, base + 2.0 * height], axis=1)
    widths = np.stack([middle - width, middle + width, middle], axis=1)
    places = heights[..., None] * up[:, None] + widths[..., None] * across[:, None]
    return np.concatenate([places, np.ones((len(places), 3, 1))], axis=2)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", a, b)


def _drawn_in(place: np.ndarray, slant: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Places (S, 3, 2) moved in to their middle: by the `least` (S,) share of the way, and further until
    N = slant . (x, y, 1) is well positive if it is there."""
    middle = place.mean(axis=1, keepdims=True)
    here = np.einsum("spq,sq->sp", place, slant[:, :2]) + slant[:, 2:]
    mean = here.mean(axis=1, keepdims=True)
    most = (1.0 - LEAST_SLANT) * np.maximum(mean, 0.0)
    share = most / np.maximum(np.maximum(mean - here, most), np.finfo(float).tiny)
    return middle + np.minimum(share, 1.0 - least[:, None])[..., None] * (place - middle)


def _weights(point: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Barycentric coordinates (S, P, 3) of points (S, P, 3) in triangles of normals (b - a) x (c - a)."""
    square = np.maximum(_dot(normal, normal), np.finfo(float).tiny)[:, None]
    offset = point - a[:, None]
    second = np.einsum("spi,si->sp", offset, np.cross(c - a, normal)) / square
    third = np.einsum("spi,si->sp", offset, np.cross(normal, b - a)) / square
    return np.stack([1.0 - second - third, second, third], axis=-1)
