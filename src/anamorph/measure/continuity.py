"""How well the maps of neighbouring patches agree: the continuity error along the borders of `pervertex`'s patches.

Source: Kakimoto et al. 2007, section 4.1, which divides a surface that spreads its rays too wide. Patches share the
vertices of their borders, and look up there what each vertex ray hits: so they agree at vertices, but for what hides a
hit from one of two viewpoints, and what stands before the near plane of one. Between vertices each looks into its own
map.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from anamorph.frame import View
from anamorph.measure.angles import angles_between, image_distances, normalized
from anamorph.measure.errors import Statistics, statistics
from anamorph.methods import pervertex
from anamorph.methods.pervertex import MapPlan, Options, Seen, Surroundings
from anamorph.optics.ray_meshes import bodies_of
from anamorph.optics.tessellation import outlined_scene
from anamorph.scene.geometry import flatten

ALONG = (np.arange(8) + 0.5) / 8.0
"""Where along an edge the error is measured, in parts of its length."""

SAME = 1e-6
"""Vertices closer than this are one, in sizes of the body, if their rays go the same way to a thousandth."""


@dataclass(frozen=True, eq=False)
class BorderErrors:
    """By what two patches disagree at N points of the edges that they share.

    Parameters
    ----------
    points : (N, 3) float64
        On the surface, metres.
    places : (N, 2) float64
        The same in the image, pixels from the top left corner.
    along : (N,) float64
        Where on their edges they lie, 0 and 1 at the vertices.
    angular_mrad : (N,) float64
        The angle between what the two patches show, at the point where the ray leaves the surface, milliradians.
    pixels : (N,) float64
        How far one would have to move in the image to see the other, to first order.
    edges : int
        How many edges two patches share.
    left_out : int
        Edges among them without a ray at both ends, or without a place in both maps.
    """

    points: np.ndarray
    places: np.ndarray
    along: np.ndarray
    angular_mrad: np.ndarray
    pixels: np.ndarray
    edges: int
    left_out: int

    @property
    def angular(self) -> Statistics:
        """Of the angles, milliradians."""
        return statistics(self.angular_mrad)

    @property
    def in_image(self) -> Statistics:
        """Of the errors in pixels."""
        return statistics(self.pixels)


def continuity(view: View, options: Options | None = None, along: np.ndarray = ALONG) -> BorderErrors:
    """Plan a frame of `view` with the `options` of `pervertex`, and measure it along its borders."""
    scene = outlined_scene(view.scene, view.pinhole_camera, view.size)
    geometry = flatten(scene)
    bodies = bodies_of(scene, geometry)
    surroundings = pervertex.surroundings_of(geometry, bodies)
    seen = pervertex.seen_bodies(bodies, surroundings, view.pinhole_camera, view.size, options or Options())
    return border_errors(seen, surroundings, view.size, along)


def border_errors(
    seen: Sequence[Seen], surroundings: Surroundings, size: tuple[int, int], along: np.ndarray = ALONG
) -> BorderErrors:
    """Measure the warp of an image, before any refinement, along the borders of its patches.

    Parameters
    ----------
    seen : sequence of Seen
        What the image shows.
    surroundings : Surroundings
        The same that the maps were planned in.
    size : (width, height)
        Of the image, pixels; what lies outside it is not measured.
    along : (M,) float64
        Where on each edge, 0 to 1.
    """
    parts = [part for each in seen for part in _borders(each)]
    measured = [_measured(part, surroundings, size, np.asarray(along, float)) for part in parts]
    nothing = [np.zeros(shape) for shape in ((0, 3), (0, 2), 0, 0, 0)]
    columns = [np.concatenate(column) for column in zip(nothing, *measured, strict=True)]
    edges, left_out = sum(len(part.ends) for part in parts), sum(int((~part.usable).sum()) for part in parts)
    points, places, where, angles, pixels = columns
    return BorderErrors(points, places, where, angles, pixels, edges, left_out)


@dataclass(frozen=True, eq=False)
class _Border:
    """The edges between two patches: for each its ends in both of them, (E, 2, 2), and its face's corners, (E, 3)."""

    seen: Seen
    plans: tuple[MapPlan, MapPlan]
    ends: np.ndarray
    corners: np.ndarray
    usable: np.ndarray


def _borders(seen: Seen) -> Iterator[_Border]:
    """Each pair of patches that share edges. An edge of more than two faces counts between any two that follow."""
    rays = seen.body_rays.rays
    same = _welded(rays.origins, rays.unit_directions())
    corners = np.concatenate([rays.faces[faces] for faces in seen.patches])
    patch = np.repeat(np.arange(len(seen.patches)), [len(faces) for faces in seen.patches])
    ends = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    patch, corners = np.tile(patch, 3), np.tile(corners, (3, 1))
    backwards = same[ends[:, 0]] > same[ends[:, 1]]
    ends[backwards] = ends[backwards, ::-1]
    low, high = same[ends].T
    order = np.lexsort((patch, high, low))
    first, second = order[:-1], order[1:]
    shared = (low[first] == low[second]) & (high[first] == high[second]) & (patch[first] != patch[second])
    first, second = first[shared], second[shared]
    for one, other in np.unique(np.stack([patch[first], patch[second]], axis=1), axis=0):
        chosen = (patch[first] == one) & (patch[second] == other)
        pair = np.stack([ends[first[chosen]], ends[second[chosen]]], axis=1)
        plans = seen.plans[one], seen.plans[other]
        valid = [_lookups(plan, pair[:, number])[..., 3].all(axis=1) for number, plan in enumerate(plans)]
        usable = (rays.status[pair] == 0).all(axis=(1, 2)) & (rays.image[pair, 2] > 0.0).all(axis=(1, 2))
        yield _Border(seen, plans, pair, corners[first[chosen]], usable & valid[0] & valid[1])


def _welded(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """A number for each vertex, (V,), the same for those of several meshes that lie and look alike."""
    grid = SAME * (float(np.ptp(points, axis=0).max()) or 1.0)
    keys = np.rint(np.concatenate([points / grid, 1e3 * directions], axis=1)).astype(np.int64)
    return np.unique(keys, axis=0, return_inverse=True)[1].ravel()


def _lookups(plan: MapPlan, vertices: np.ndarray) -> np.ndarray:
    return plan.lookups[0, np.searchsorted(plan.vertices, vertices)]


def _measured(
    border: _Border, surroundings: Surroundings, size: tuple[int, int], along: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Points, places, where they are along their edges, angles and errors in pixels of one border."""
    rays, lens = border.seen.body_rays.rays, border.seen.body_rays.side.optics.positions
    pair, corners = border.ends[border.usable], border.corners[border.usable]
    ends = pair[:, 0]

    def between(values: np.ndarray) -> np.ndarray:
        """Interpolate what the two ends of each edge have, as the shader does: (E, 2, C) to (E M, C)."""
        weights = np.stack([1.0 - along, along], axis=1)
        return np.einsum("mc,ecj->emj", weights, values).reshape(-1, values.shape[-1])

    homogeneous, origins = between(rays.image[ends]), between(rays.origins[ends])
    places = homogeneous[:, :2] / homogeneous[:, 2:]
    inside = ((places >= 0.0) & (places <= size)).all(axis=1)
    found = [
        _found(plan, between(_lookups(plan, pair[:, number])), origins, surroundings, border.seen.body_rays.body.meshes)
        for number, plan in enumerate(border.plans)
    ]
    (toward, _), (other, distances) = found
    angles = 1000.0 * angles_between(toward, other)
    footprints = _footprints(border, np.repeat(corners, len(along), axis=0), homogeneous, distances)
    pixels = image_distances(origins, toward, other, distances, footprints, float(np.linalg.norm(size)))
    columns = between(lens[ends]), places, np.tile(along, len(ends)), angles, pixels
    return tuple(column[inside] for column in columns)


def _found(
    plan: MapPlan, lookups: np.ndarray, origins: np.ndarray, surroundings: Surroundings, meshes: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions from `origins` to what a map shows at `lookups` (N, 4), and how far that is; sky is infinite."""
    line_origins, lines = pervertex.map_lines(plan, lookups)
    distances = pervertex.shown_distances(line_origins, lines, meshes, surroundings)
    hits = line_origins + np.where(np.isfinite(distances), distances, 0.0)[:, None] * lines
    sky = ~np.isfinite(distances)
    toward = normalized(np.where(sky[:, None], lines, hits - origins))
    return toward, np.where(sky, np.inf, np.linalg.norm(hits - origins, axis=1))


def _footprints(border: _Border, corners: np.ndarray, homogeneous: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """How the point at a distance along the ray moves when one moves by a pixel, (N, 3, 2): by the face's own rays."""
    rays = border.seen.body_rays.rays
    infinite = ~np.isfinite(distances)
    ahead = np.where(infinite, 1.0, distances)[:, None]
    moved = ahead * rays.unit_directions()[corners].swapaxes(0, 1)
    moved += np.where(infinite[:, None], 0.0, rays.origins[corners].swapaxes(0, 1))
    image = rays.image[corners]
    by_corner = np.stack([moved[1] - moved[0], moved[2] - moved[0]], axis=2)
    places = homogeneous[:, :2] / homogeneous[:, 2:]
    edges = image[:, 1:] - image[:, :1]
    pixels = (edges[..., :2] - places[:, None] * edges[..., 2:]) / homogeneous[:, 2][:, None, None]
    return by_corner @ np.linalg.pinv(pixels.swapaxes(1, 2))
