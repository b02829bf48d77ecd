"""What is far from a mirror, as an environment map of triangles that is drawn behind what is near. Compiled.

From the middle of each mirror or lens it is known which triangle every direction meets. A ray that meets nothing near
shows what its direction meets from there, by that triangle's own place and colour. How far this is from what the ray
itself would meet, in pixels, falls with the distance.

Source: Mei, Popescu and Sacks 2007, section 7, where the background is an environment map and only objects near the
reflector are drawn by its cameras. Deviation: the map holds triangles and not colours, so that one pass shades all; and
where near ends is chosen by the error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.frame import Status
from anamorph.gpu.visibility import Rectangle
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.sample_rays import Samples
from anamorph.methods.threeray.surfels import Surfels
from anamorph.methods.tracing.packing import BLANK
from anamorph.optics.ray_meshes import Body
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import Geometry

ERROR = 0.5
"""Pixels by which what the map shows may be off, where the distance is chosen."""

FACE = 1024
"""Texels along a side of a map, of which there are six."""

GRAIN = 16384

SKY, FIRST = 1, 2
"""What texels hold of the sky, and of the first triangle."""

_SKY, _OUTSIDE, _WARPED = int(Status.SKY), int(Status.OUTSIDE), int(Status.WARPED)


@dataclass(frozen=True, eq=False)
class Background:
    """Environment maps around B mirrors and lenses, of which a texel is filled when it is first looked at.

    Parameters
    ----------
    center : (B, 3) float64
        The middles.
    near : (B,) float64
        How far from these the cameras see, metres: nothing that is nearer is hidden by what a map shows.
    body : (objects + 1,) int64
        The mirror or lens that each object belongs to; that of 0 is the first.
    number : (F,) int32
        The triangles that the maps show: their numbers in the scene.
    caster : Caster or None
        Over these triangles; None if there are none.
    texel : (B, 6, FACE, FACE) int32
        What is met from the centre: 0 where that is not known yet, `SKY`, or the triangle's number and `FIRST`. Face
        2 k looks along axis k, and face 2 k + 1 against it; rows follow axis k + 1, and columns axis k + 2.
    distance : (B, 6, FACE, FACE) float32
        How far that is, metres.
    """

    center: np.ndarray
    near: np.ndarray
    body: np.ndarray
    number: np.ndarray
    caster: Caster | None
    texel: np.ndarray
    distance: np.ndarray

    def moved(self, geometry: Geometry) -> Background:
        """Maps of the same triangles where `geometry` has them; nothing is known of these yet."""
        return _made(geometry, self.number, self.center, self.near, self.body)


def body_center(body: Body) -> np.ndarray:
    """The middle of the box around a mirror or lens, (3,) float64."""
    places = np.concatenate([side.optics.positions for side in body.sides])
    return 0.5 * (places.min(axis=0) + places.max(axis=0))


def are_near(surfels: Surfels, center: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Which surfels reach nearer to some `center` (B, 3) than its distance (B,) is: (N,) bool."""
    near, reach = np.zeros(len(surfels), bool), np.linalg.norm(surfels.half_extents(), axis=1)
    for middle, distance in zip(center, distances, strict=True):
        near |= np.linalg.norm(surfels.center - middle, axis=1) - reach <= distance
    return near


def least_distances(cameras: Cameras, owning: np.ndarray, center: np.ndarray, body: np.ndarray) -> np.ndarray:
    """How far things are at least that the maps show within `ERROR`, (B,) metres.

    Parameters
    ----------
    cameras : Cameras
        Of an image whose samples are pixels.
    owning : (M,) int64
        Those that are seen.
    center : (B, 3) float64
    body : (objects + 1,) int64
        As in `Background`.

    Returns
    -------
    distances : (B,) float64
        Infinite where some camera's rays do not part, since what it shows is magnified without a bound; and where none
        is seen, since nothing is known of any.
    """
    own = body[cameras.item[owning]]
    reach = np.linalg.norm(cameras.origins[owning] - center[own, None], axis=2).max(axis=1)
    image, directions = cameras.image[owning], cameras.directions[owning]
    with np.errstate(divide="ignore", invalid="ignore"):
        directions = directions / np.linalg.norm(directions, axis=2, keepdims=True)
        places = image[..., :2] / image[..., 2:]
        angles = np.linalg.norm(directions - np.roll(directions, -1, axis=1), axis=2)
        slowest = (angles / np.linalg.norm(places - np.roll(places, -1, axis=1), axis=2)).min(axis=1)
        needed = reach / (ERROR * slowest)
    needed = np.where(np.isfinite(needed) & (image[..., 2] > 0.0).all(axis=1), needed, np.inf)
    distances = np.full(len(center), -np.inf)
    np.maximum.at(distances, own, needed)
    return np.where(distances >= 0.0, distances, np.inf)


def make_background(
    geometry: Geometry, far: np.ndarray, center: np.ndarray, near: np.ndarray, body: np.ndarray
) -> Background:
    """The maps of the triangles that are `far` (F,) bool; `center`, `near` and `body` as in `Background`."""
    return _made(geometry, np.flatnonzero(far).astype(np.int32), center, near, body)


def _made(geometry: Geometry, number: np.ndarray, center: np.ndarray, near: np.ndarray, body: np.ndarray) -> Background:
    caster = None
    if len(number):
        owner = geometry.face_object[number]
        first_face = np.searchsorted(owner, np.arange(1, len(geometry.first_face) + 1))
        caster = Caster(replace(geometry, faces=geometry.faces[number], face_object=owner, first_face=first_face))
    # The system gives the memory of a page when it is first written.
    shape = len(center), 6, FACE, FACE
    return Background(center, near, body, number, caster, np.zeros(shape, np.int32), np.zeros(shape, np.float32))


def show_behind(
    background: Background, samples: Samples, rectangle: Rectangle, records: np.ndarray, going: np.ndarray
) -> np.ndarray:
    """Have records show what is behind, where they meet nothing or where that is nearer.

    Of several mirrors, one may see what is near another behind what is far from both. Records that show what is behind
    start in the middle of their mirror or lens from then on.

    Parameters
    ----------
    background : Background
    samples : Samples
        How far away each has met something.
    rectangle : (x0, y0, x1, y1)
        Samples.
    records : (N, 16) float32
        Of the rectangle, from `records_of`; changed.
    going : (M,) int64
        Which of them go on.

    Returns
    -------
    (L,) int64
        Which of them still do.
    """
    if background.caster is None:
        return going
    place, shown, goes = np.full(len(records), -1, np.int64), np.zeros(len(records), bool), np.zeros(len(records), bool)
    goes[going] = True
    away = np.empty(len(records))
    words, texel, distance = records.view(np.uint32), background.texel.reshape(-1), background.distance.reshape(-1)

    def look(start: int, stop: int) -> None:
        _look(background.body, background.near, samples, rectangle, records, words, goes, away, place, start, stop)

    def show(start: int, stop: int) -> None:
        _show(background.center, texel, distance, away, place, records, words, shown, start, stop)

    over_all_cores(look, len(records), GRAIN)
    some = place[place >= 0]
    unknown = np.unique(some[texel[some] == 0])
    if len(unknown):
        directions = _directions(unknown)
        hits = background.caster.cast(background.center[unknown // (6 * FACE * FACE)], directions)
        texel[unknown] = np.where(hits.triangle >= 0, background.number[hits.triangle] + FIRST, SKY)
        distance[unknown] = hits.distance * np.linalg.norm(directions, axis=1)
    over_all_cores(show, len(records), GRAIN)
    return going[~shown[going]]


def _directions(place: np.ndarray) -> np.ndarray:
    """Through texels, by their places in the flat maps: (N, 3) float64."""
    rest, column = np.divmod(place, FACE)
    rest, row = np.divmod(rest, FACE)
    axis, against = np.divmod(rest % 6, 2)
    directions, numbers = np.empty((len(place), 3)), np.arange(len(place))
    directions[numbers, axis] = 1.0 - 2.0 * against
    directions[numbers, (axis + 1) % 3] = (row + 0.5) * (2.0 / FACE) - 1.0
    directions[numbers, (axis + 2) % 3] = (column + 0.5) * (2.0 / FACE) - 1.0
    return directions


@compiled
def _look(
    body: np.ndarray,
    near: np.ndarray,
    samples: Samples,
    rectangle: tuple[int, int, int, int],
    records: np.ndarray,
    words: np.ndarray,
    goes: np.ndarray,
    away: np.ndarray,
    place: np.ndarray,
    start: int,
    stop: int,
) -> None:
    """Find how far away records have met something, and the texels that may be nearer, by places in the flat maps."""
    columns = rectangle[2] - rectangle[0]
    for i in range(start, stop):
        flags = words[i, 7]
        status, own = (flags >> 16) & 0xFF, body[flags & 0xFFFF]
        if words[i, 3] == BLANK:
            asks = status == _SKY and not goes[i]
        else:
            row, column = rectangle[1] + i // columns, rectangle[0] + i % columns
            x, y, z = samples.rays[3, row, column], samples.rays[4, row, column], samples.rays[5, row, column]
            away[i] = samples.way[row, column] * math.sqrt(x * x + y * y + z * z)
            # Of those that go on, only these have met something: the others are traced from the start.
            asks = away[i] > near[own] and (status == _OUTSIDE or not goes[i])
        if not asks:
            continue
        direction = (np.float64(records[i, 4]), np.float64(records[i, 5]), np.float64(records[i, 6]))
        axis = 0
        for k in range(1, 3):
            if abs(direction[k]) > abs(direction[axis]):
                axis = k
        ahead = abs(direction[axis])
        if ahead > 0.0:
            row = min(int((direction[(axis + 1) % 3] / ahead + 1.0) * (0.5 * FACE)), FACE - 1)
            column = min(int((direction[(axis + 2) % 3] / ahead + 1.0) * (0.5 * FACE)), FACE - 1)
            face = 6 * own + 2 * axis + (1 if direction[axis] < 0.0 else 0)
            place[i] = (face * FACE + row) * FACE + column


@compiled
def _show(
    center: np.ndarray,
    texel: np.ndarray,
    distance: np.ndarray,
    away: np.ndarray,
    place: np.ndarray,
    records: np.ndarray,
    words: np.ndarray,
    shown: np.ndarray,
    start: int,
    stop: int,
) -> None:
    for i in range(start, stop):
        if place[i] < 0 or texel[place[i]] < FIRST:
            continue
        own, met = place[i] // (6 * FACE * FACE), np.uint32(texel[place[i]] - FIRST)
        if words[i, 3] != BLANK:
            apart = 0.0
            for k in range(3):
                apart += (np.float64(records[i, k]) - center[own, k]) ** 2
            # Seen from two places, what is nearer by less than these are apart may be the farther.
            if met == words[i, 3] or distance[place[i]] + math.sqrt(apart) >= away[i]:
                continue
        for k in range(3):
            records[i, k] = center[own, k]
        words[i, 3], shown[i] = met, True
        words[i, 7] = np.uint32((words[i, 7] & 0xFF00FFFF) | (_WARPED << 16))
