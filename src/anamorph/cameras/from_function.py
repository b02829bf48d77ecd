"""A camera from any function of the image: its grid is divided until interpolated rays are as near as wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from anamorph.base.errors import AnamorphError
from anamorph.cameras.grid import Size, checked_number, checked_size, from_grid, grid_points
from anamorph.raymesh import RayMesh, RayStatus

RayFunction = Callable[[np.ndarray], tuple[np.ndarray, ...]]
"""From image points (N, 2), pixels, to origins (N, 3), directions (N, 3), and where some see nothing a status (N,)."""

FIRST = 8
"""Quads along the longer side to begin with."""
LEAST = 2.0
"""The least side of a quad, pixels."""
FINE = 4.0
"""The same for what is beside a hole."""
RIM = 16.0
"""Pixels from a hole within which triangles that cannot be near enough belong to it."""
ROOM = 0.8
"""Of the tolerance: what checks between vertices may find, because the largest error lies between them."""
HALVINGS = 40
"""After them a border is found to less than a millionth of a pixel."""
BESIDE = 0.88
"""The same beside a hole."""
STEP = 0.25
"""Pixels to each side over which the change of rays is taken."""
STRETCHED = 0.25
"""Of a pixel's greater extent among directions its smaller one counts as this share at least: at a pole it is 0."""
CHECKS = np.array([(1 / 2, 1 / 2), (1 / 2, 0), (0, 1 / 2), (1 / 3, 2 / 3), (2 / 3, 1 / 3)])
"""Where in a quad, from its top left, rays are checked."""


def from_function(function: RayFunction, size: Size, tolerance: float = 0.1) -> RayMesh:
    """A camera whose rays a function of the image gives.

    How far an interpolated ray is off is counted in pixels: the least move in the image after which the function gives
    it, to first order. Vertices without a ray keep their status, and no triangle has one of them: a hole. Within 16
    pixels of a hole what is not near enough with these quads belongs to it. Where a pixel sees more than four times as
    far one way as the other, as at a pole, its narrow way counts as a quarter of the wide one.

    Parameters
    ----------
    function : callable
        From image points (N, 2) in pixels to origins (N, 3) in metres, directions (N, 3) of any length, and, where not
        all see something, a `RayStatus` each, (N,). It must be smooth.
    size : (width, height)
        Pixels.
    tolerance : float
        Pixels.

    Returns
    -------
    RayMesh
        A grid of quads of two triangles, all of one size.

    Raises
    ------
    AnamorphError
        Where the rays change so fast that quads of two pixels do not suffice, and where no pixel sees anything.
    """
    wanted = ROOM * checked_number("tolerance", tolerance, 0.0, np.inf, "pixels")
    extent = np.array(checked_size(size), float)
    side, least = extent.max() / FIRST, min(LEAST, extent.max() / FIRST)
    while True:
        quads = np.maximum(np.ceil(extent / side - 1e-9).astype(int), 1)
        mesh, seen, off = _divided(function, size, (int(quads[0]), int(quads[1])))
        near = _beside_holes(mesh)
        # Rays may turn ever faster towards a hole: what is beside it asks for no smaller quads than these.
        worst, end = off[seen & ~near].max(initial=0.0), least
        if worst <= wanted and side > FINE:
            worst, end = off[seen].max(initial=0.0), max(least, FINE)
        if worst <= wanted or side <= end:
            break
        # The error falls with the square of the side; a step too far would cost more than one more.
        side = max(end, side * float(np.clip(0.95 * np.sqrt(wanted / worst), 0.25, 0.9)))
    # What lies beside a hole gets more of the tolerance.
    most = BESIDE * tolerance
    bad = seen & (off > np.where(near, most, wanted))
    if (bad & ~near).any():
        place = mesh.places()[mesh.faces[np.argmax(np.where(bad & ~near, off, 0.0))]].mean(axis=0)
        raise AnamorphError(
            f"camera: at ({place[0]:.0f}, {place[1]:.0f}) rays change too fast: quads of {side:.3g} pixels are "
            f"{off[bad & ~near].max():.2g} off; give a larger tolerance or a smooth function"
        )
    kept = replace(mesh, faces=mesh.faces[seen & ~bad])
    if not len(kept.faces):
        raise AnamorphError("camera: no pixel of the image sees anything; give another size or other intrinsics")
    cut = ~seen & (mesh.status[mesh.faces] == RayStatus.OK).any(axis=1)
    return _with_border(function, kept, mesh.faces[cut], size, most)


def _divided(function: RayFunction, size: Size, quads: tuple[int, int]) -> tuple[RayMesh, np.ndarray, np.ndarray]:
    """A mesh of `quads`, which triangles see something, (F,) bool, and how many pixels they are off, (F,)."""
    points = grid_points(size, quads)
    origins, directions, status = _called(function, points.reshape(-1, 2))
    mesh = replace(from_grid(origins.reshape(*points.shape[:2], 3), directions.reshape(*points.shape[:2], 3), size),
                   status=status)  # fmt: skip
    seen = (status[mesh.faces] == RayStatus.OK).all(axis=1)
    off = np.zeros(len(mesh.faces))
    corner = points[:-1, :-1].reshape(-1, 2)
    sides = np.divide(size, quads)
    for x, y in CHECKS:
        at = corner + (x, y) * sides
        # Of a quad's two triangles the first lies below its diagonal.
        for triangle, weights in ((0, (1.0 - y, y - x, x)), (1, (1.0 - x, y, x - y))):
            if min(weights) < -1e-9:
                continue
            faces = np.arange(triangle, len(mesh.faces), 2)
            faces, where = faces[seen[faces]], at[seen[faces]]
            corners = mesh.faces[faces]
            error = _pixels_off(
                function,
                where,
                np.einsum("k,fki->fi", weights, mesh.origins[corners]),
                np.einsum("k,fki->fi", weights, mesh.directions[corners]),
                size,
            )
            off[faces] = np.maximum(off[faces], error)
    return mesh, seen, off


def _pixels_off(
    function: RayFunction, at: np.ndarray, origins: np.ndarray, directions: np.ndarray, size: Size
) -> np.ndarray:
    """How far rays at image points are from the function's, in pixels; infinite where it gives none."""
    true_origins, true_directions, status = _called(function, at)
    lost = status != RayStatus.OK
    changes = []
    for axis in (0, 1):
        step = STEP * np.eye(2)[axis]
        before, after = np.maximum(at - step, 0.0), np.minimum(at + step, size)
        # Beside a hole the change is taken to one side.
        for side in (before, after):
            holes = _called(function, side)[2] != RayStatus.OK
            side[holes] = at[holes]
        here, there = _called(function, before), _called(function, after)
        lost |= (after == before).all(axis=1)
        width = np.maximum((after - before)[:, axis, None], 1e-9)
        changes.append([(there[0] - here[0]) / width, (_units(there[1]) - _units(here[1])) / width])
    moved = _least_move(np.stack([each[1] for each in changes], -1), _units(directions) - _units(true_directions))
    moved += _least_move(np.stack([each[0] for each in changes], -1), origins - true_origins)
    return np.where(lost, np.inf, moved)


def _least_move(change: np.ndarray, error: np.ndarray) -> np.ndarray:
    """The length of the least move (N,) in the image that changes rays by `error` (N, 3), by `change` (N, 3, 2)."""
    across, extents, _ = np.linalg.svd(change, full_matrices=False)
    extents = np.maximum(extents, STRETCHED * extents[:, :1])
    there = extents[:, :1] > 0.0
    return np.linalg.norm(np.einsum("nik,ni->nk", across, error) / np.where(there, extents, np.inf), axis=1)


def _with_border(function: RayFunction, mesh: RayMesh, faces: np.ndarray, size: Size, wanted: float) -> RayMesh:
    """With what is seen of `faces`, (F, 3), which a border crosses, as far as it is as near as `wanted`, pixels."""
    ok = mesh.status[faces] == RayStatus.OK
    # A corner that is alone in what it is, seen or not, comes first.
    alone = np.argmax(ok == (ok.sum(axis=1) == 1)[:, None], axis=1)
    first, second, third = np.take_along_axis(faces, (alone[:, None] + np.arange(3)) % 3, axis=1).T
    places, one = mesh.places(), ok.sum(axis=1) == 1
    ends = []
    for other in (second, third):
        seen, lost = places[np.where(one, first, other)], places[np.where(one, other, first)]
        low, high = np.zeros(len(faces)), np.ones(len(faces))
        for _ in range(HALVINGS):
            middle = (low + high) / 2.0
            there = _called(function, seen + middle[:, None] * (lost - seen))[2] == RayStatus.OK
            low, high = np.where(there, middle, low), np.where(there, high, middle)
        ends.append(seen + low[:, None] * (lost - seen))
    origins, directions, status = _called(function, np.concatenate(ends))
    near = len(mesh.image) + np.arange(len(faces))
    far = near + len(faces)
    made = np.concatenate(
        [
            np.column_stack([first, near, far])[one],
            np.column_stack([near, second, third])[~one],
            np.column_stack([near, third, far])[~one],
        ]
    )
    whole = RayMesh(
        image=np.vstack([mesh.image, np.column_stack([np.concatenate(ends), np.ones(2 * len(faces))])]),
        origins=np.vstack([mesh.origins, origins]),
        directions=np.vstack([mesh.directions, directions]),
        faces=made.astype(np.int32),
        status=np.concatenate([mesh.status, status]),
    )
    if len(made):
        values = [each[whole.faces] for each in (whole.places(), whole.origins, whole.directions)]
        weights = np.array([(1, 1, 1), (1, 1, 0), (0, 1, 1), (1, 0, 1)], float)
        weights /= weights.sum(axis=1, keepdims=True)
        at, leaving, going = (np.einsum("ck,fki->cfi", weights, value) for value in values)
        off = [_pixels_off(function, *each, size=size) for each in zip(at, leaving, going, strict=True)]
        made = whole.faces[np.max(off, axis=0) <= wanted]
    return replace(whole, faces=np.concatenate([mesh.faces, made]))


def _beside_holes(mesh: RayMesh) -> np.ndarray:
    """Which triangles have a vertex within `RIM` pixels of one that sees nothing, (F,) bool."""
    places, holes = mesh.places(), mesh.status != RayStatus.OK
    if not holes.any():
        return np.zeros(len(mesh.faces), bool)
    distance, _ = KDTree(places[holes]).query(places, distance_upper_bound=RIM)
    return np.isfinite(distance)[mesh.faces].any(axis=1)


def _called(function: RayFunction, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    result = function(points)
    origins, directions = np.asarray(result[0], float), np.asarray(result[1], float)
    if origins.shape != (len(points), 3) or directions.shape != (len(points), 3):
        raise AnamorphError(
            f"camera: the function gives origins {origins.shape} and directions {directions.shape}; "
            f"give ({len(points)}, 3) each"
        )
    status = np.asarray(result[2], np.uint8) if len(result) > 2 else np.zeros(len(points), np.uint8)
    return origins, directions, status


def _units(directions: np.ndarray) -> np.ndarray:
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)
