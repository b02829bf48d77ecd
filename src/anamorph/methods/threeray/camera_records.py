"""What the samples' rays have met, as records of paths: those that end there, and which ones go on. Compiled.

A path that meets a mirror's front or glass goes on; so does one for which its camera has no interpolated ray. These are
traced by `methods.tracing`, along the interpolated ray first.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.base.vectors import Vector, along, dot
from anamorph.frame import Status
from anamorph.gpu.visibility import Rectangle
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.sample_rays import Samples
from anamorph.methods.threeray.scene_triangles import Triangles
from anamorph.methods.tracing.bounces import GLASS, MIRROR, WORDS, schlick
from anamorph.methods.tracing.packing import BLANK
from anamorph.raytriangle.camera_frames import vector
from anamorph.raytriangle.owners import Places

ROWS = 16
"""Rows of samples that a core takes at a time."""

_SKY, _OUTSIDE, _PROJECTED = int(Status.SKY), int(Status.OUTSIDE), int(Status.PROJECTED)


def records_of(
    cameras: Cameras,
    places: Places,
    triangles: Triangles,
    materials: Materials,
    samples: Samples,
    rectangle: Rectangle,
    eye: np.ndarray | None,
    bounces: int,
    shown: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """The records of the samples in a rectangle.

    Parameters
    ----------
    cameras, places, triangles, materials, samples
    rectangle : (x0, y0, x1, y1)
        Samples.
    eye : (3,) float64 or None
        None where the ray mesh is the camera.
    bounces : int
        How many specular interfaces a path may meet.
    shown : (K,) bool
        Of which cameras there are records; those of others are empty.

    Returns
    -------
    records : (N, 16) float32
        Row by row, as in `PathTracer.tracing`.
    going : (M,) int64
        Which of them are of paths that go on: they only have the ray.
    """
    x0, y0, x1, y1 = rectangle
    count, columns = (x1 - x0) * (y1 - y0), x1 - x0
    records, goes_on = np.zeros((count, WORDS), np.float32), np.zeros(count, bool)
    words, place = records.view(np.uint32), np.zeros(3) if eye is None else np.asarray(eye, float)
    words[:, 3] = BLANK

    def work(start: int, stop: int) -> None:
        _record(
            cameras, places, triangles, materials, samples, rectangle, eye is None, place, bounces, shown,
            records, words, goes_on, start, stop,
        )  # fmt: skip

    over_all_cores(work, y1 - y0, ROWS * max(1, 512 // max(columns, 1)))
    return records, np.flatnonzero(goes_on)


@compiled
def _record(
    cameras: Cameras,
    places: Places,
    triangles: Triangles,
    materials: Materials,
    samples: Samples,
    rectangle: tuple[int, int, int, int],
    bare: bool,
    eye: np.ndarray,
    bounces: int,
    shown: np.ndarray,
    records: np.ndarray,
    words: np.ndarray,
    goes_on: np.ndarray,
    first_row: int,
    stop_row: int,
) -> None:
    columns = rectangle[2] - rectangle[0]
    for i in range(first_row * columns, stop_row * columns):
        row, column = rectangle[1] + i // columns, rectangle[0] + i % columns
        c = samples.owner[row, column]
        if c < 0 or not shown[c]:
            if bare:
                words[i, 7] = np.uint32(_OUTSIDE << 16)
            continue
        ray = samples.rays[:, row, column]
        origin, direction = (ray[0], ray[1], ray[2]), (ray[3], ray[4], ray[5])
        length = math.sqrt(dot(direction, direction))
        if length == 0.0:
            words[i, 7] = np.uint32(_OUTSIDE << 16)
            continue
        direction = (direction[0] / length, direction[1] / length, direction[2] / length)
        f, met_before, item = samples.triangle[row, column], cameras.bounces[c], cameras.item[c]
        status = _SKY if f < 0 else _PROJECTED
        if cameras.traced[c] or met_before > bounces:
            goes_on[i] = True
        elif f >= 0:
            kind = materials.kind[triangles.item[f]]
            if kind == GLASS or (kind == MIRROR and dot(vector(triangles.plane[f]), direction) < 0.0):
                status = _OUTSIDE
                goes_on[i] = met_before < bounces
        share = (1.0, 1.0, 1.0)
        if item > 0:
            x, y = float(column - places.box[c, 0]), float(row - places.box[c, 1])
            share = _share(cameras, places, materials, c, x, y, along(origin, -1.0, vector(eye)), direction)
        for k in range(3):
            records[i, k], records[i, 4 + k], records[i, 8 + k] = origin[k], direction[k], share[k]
        words[i, 3] = np.uint32(f) if f >= 0 else np.uint32(BLANK)
        words[i, 7] = np.uint32(item | (status << 16) | (met_before << 24))


@compiled
def _share(
    cameras: Cameras,
    places: Places,
    materials: Materials,
    c: int,
    x: float,
    y: float,
    incident: Vector,
    direction: Vector,
) -> Vector:
    """What share of the light arrives, by colour, along a ray that comes along `incident` and leaves a body."""
    item = cameras.item[c]
    tint = vector(materials.tint[item])
    if materials.kind[item] == MIRROR:
        scale = -1.0 / math.sqrt(dot(incident, incident))
        change = along(direction, scale, incident)
        share = schlick(materials.reflectance[item], 0.5 * math.sqrt(dot(change, change)))
    else:
        share, total = 0.0, 0.0
        for i in range(3):
            weight = places.weights[c, i, 0] * x + places.weights[c, i, 1] * y + places.weights[c, i, 2]
            share, total = share + weight * cameras.transmittance[c, i], total + weight
        share /= total
        far = vector(materials.tint[cameras.left[c]])
        tint = (tint[0] * far[0], tint[1] * far[1], tint[2] * far[2])
    return (share * tint[0], share * tint[1], share * tint[2])
