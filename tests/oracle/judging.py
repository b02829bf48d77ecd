"""How far, in pixels, one must move in the image until the second tracer sees what a frame shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oracle.scene import Camera
from oracle.subrays import DEPTH, Shown, any_subray_sees, depths, offsets_of, toward
from oracle.tracer import ASTRAY, LIMIT, Seen, Tracer

STEP = 1.0 / 16.0
"""Pixels between the rays from whose difference Newton's steps are taken."""

ROUNDS = 6
ALLOWED = 0.5
"""Pixels that a pixel may be off."""

ENOUGH = 1e-3
"""Pixels: a step as short as this ends the iteration."""


@dataclass(frozen=True, eq=False)
class Judgement:
    """What is wrong with a frame, by pixel: (H, W) each.

    Parameters
    ----------
    counted : bool
        Pixels that look at a specular surface, in truth or in the frame, and have an answer: the tracer's path ends
        before the bounce limit, and no interpolated normal sends it through its own triangle.
    unanswered : bool
        Pixels that look at a specular surface and have none.
    silhouette : bool
        Counted pixels within one pixel of another object or another first or last specular surface, by the tracer's
        pixel centres; and those that show another one which some sub-ray within half a pixel sees, too.
    other : bool
        Of the rest, those that show another object or another specular surface.
    angles : float64
        Radians between the truth's last ray and the frame's; where the frame has none, at the origin of the truth's,
        between that ray and what is shown. 0 where not counted and at silhouettes.
    pixels : float64
        How far one must move; infinite where the tracer sees it nowhere near; 0 at silhouettes and where not counted.
    missed : bool
        At silhouettes: no sub-ray within half a pixel sees what is shown.
    status : int64
        The frame's.
    """

    counted: np.ndarray
    unanswered: np.ndarray
    silhouette: np.ndarray
    other: np.ndarray
    angles: np.ndarray
    pixels: np.ndarray
    missed: np.ndarray
    status: np.ndarray

    @property
    def plain(self) -> np.ndarray:
        """The counted pixels away from silhouettes."""
        return self.counted & ~self.silhouette

    @property
    def wrong(self) -> np.ndarray:
        """Pixels away from silhouettes that show something else, or the same more than half a pixel off."""
        return self.plain & (self.other | (self.pixels > ALLOWED))

    def wrong_by_status(self) -> dict[int, int]:
        """How many wrong pixels have each status."""
        values, counts = np.unique(self.status[self.wrong], return_counts=True)
        return dict(zip(values.tolist(), counts.tolist(), strict=True))


def judge(tracer: Tracer, camera: Camera, shown: Shown) -> Judgement:
    """Compare a frame's seen buffers, (H, W) each, with what the tracer sees through the same camera."""
    size = shown.size
    centres = pixel_centres(size)
    truth, flat = tracer.look(camera, centres, size), shown.flat()
    specular = (truth.specular > 0) | (flat.specular > 0)
    answered = (truth.flags & (LIMIT | ASTRAY)) == 0
    counted = specular & answered
    labels = np.stack([truth.object_id, truth.specular, truth.last]).reshape(3, *shown.object_id.shape)
    silhouette = counted & beside_another(labels).ravel()
    other = counted & ~silhouette & ((truth.object_id != flat.object_id) | (truth.specular != flat.specular))
    angles, pixels, missed = np.zeros(len(counted)), np.zeros(len(counted)), np.zeros(len(counted), bool)
    measured = np.flatnonzero(counted & ~silhouette)
    if len(measured):
        angles[measured], pixels[measured] = _distances(
            tracer, camera, size, centres[measured], truth[measured], flat[measured]
        )
    # What is seen in the right direction may stand behind what the ray meets.
    shown_depth = np.where(flat.object_id == 0, 0.0, toward(truth, flat)[1])
    deep = np.abs(depths(truth) - shown_depth) > DEPTH * shown_depth
    far = np.flatnonzero(counted & (silhouette | other | deep | (pixels > ALLOWED)))
    if len(far):
        sees = any_subray_sees(tracer, camera, size, centres[far], flat[far], ALLOWED)
        # A thing that shows between the tracer's pixel centres has a silhouette that they do not tell of.
        silhouette[far[sees & other[far]]] = True
        other &= ~silhouette
        at_silhouette = silhouette[far]
        missed[far] = at_silhouette & ~sees
        pixels[far] = np.where(at_silhouette, 0.0, np.where(sees, np.minimum(pixels[far], ALLOWED), np.inf))
        angles[far[at_silhouette]] = 0.0
    maps = counted, specular & ~answered, silhouette, other, angles, pixels, missed, flat.status
    return Judgement(*(each.reshape(shown.object_id.shape) for each in maps))


def pixel_centres(size: tuple[int, int]) -> np.ndarray:
    """Image points, (H W, 2), row by row."""
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    return np.stack([x, y], axis=-1).reshape(-1, 2)


def beside_another(labels: np.ndarray) -> np.ndarray:
    """Pixels, (H, W), with one of their eight neighbours different in one of the labels (L, H, W)."""
    padded = np.pad(labels, ((0, 0), (1, 1), (1, 1)), mode="edge")
    height, width = labels.shape[1:]
    shifted = [padded[:, y : y + height, x : x + width] for y in range(3) for x in range(3)]
    return np.any([(each != labels).any(axis=0) for each in shifted], axis=0)


def _distances(
    tracer: Tracer, camera: Camera, size: tuple[int, int], centres: np.ndarray, truth: Seen, shown: Shown
) -> tuple[np.ndarray, np.ndarray]:
    """Angles at the pixels' centres, and how far away in the image the tracer sees what is shown: Newton's steps.

    They stay on the pixel's path: rays that meet other surfaces, or more or fewer of them, say nothing of its slope.
    """
    first = np.linalg.norm(offsets_of(truth, shown), axis=1)
    away = np.linalg.norm(shown.direction - truth.direction, axis=1)
    angles = np.where(shown.direction.any(axis=1), away, np.nan_to_num(first, nan=np.pi))
    places, distances = centres.copy(), np.where(first == 0.0, 0.0, np.inf)
    going = np.flatnonzero(first != 0.0)
    for _ in range(ROUNDS):
        if not len(going):
            break
        here, own = places[going], shown[going]
        seen = tracer.look(camera, here, size)
        on_path = same_path(seen, truth[going])
        offset = offsets_of(seen, own)
        slopes = np.stack([_slope(tracer, camera, size, here, seen, own, axis) for axis in range(2)], axis=-1)
        with np.errstate(all="ignore"):
            step = -np.einsum("nij,nj->ni", _inverses(slopes), offset)
        step[(offset == 0.0).all(axis=1)] = 0.0
        length = np.linalg.norm(step, axis=1)
        usable = on_path & np.isfinite(length)
        step *= np.minimum(1.0, 2.0 / np.maximum(length, 1e-300))[:, None]
        following = here + np.where(usable[:, None], step, 0.0)
        done = usable & (length < ENOUGH)
        distances[going[done]] = np.linalg.norm(following[done] - centres[going[done]], axis=1)
        places[going] = following
        going = going[usable & ~done]
    return angles, distances


def same_path(one: Seen, other: Seen) -> np.ndarray:
    """Which of two sets of N paths meet the same first and last surface with as many bounces."""
    return (one.specular == other.specular) & (one.last == other.last) & (one.bounces == other.bounces)


def _slope(
    tracer: Tracer, camera: Camera, size: tuple[int, int], here: np.ndarray, seen: Seen, shown: Shown, axis: int
) -> np.ndarray:
    """How the offset, (N, 3), changes by pixel along x or y; not a number where no ray beside is on the same path."""
    change, weight = np.zeros((len(here), 3)), np.zeros(len(here))
    middle = offsets_of(seen, shown, rounded=False)
    for sign in (-1.0, 1.0):
        beside = here.copy()
        beside[:, axis] += sign * STEP
        there = tracer.look(camera, beside, size)
        alike = same_path(there, seen)
        # Directions as they are: what rounding explains of an offset has no slope.
        change += np.where(alike[:, None], sign * (offsets_of(there, shown, rounded=False) - middle), 0.0)
        weight += alike
    with np.errstate(invalid="ignore"):
        return change / (weight * STEP)[:, None]


def _inverses(slopes: np.ndarray) -> np.ndarray:
    """Least-squares inverses, (N, 2, 3), of (N, 3, 2)."""
    square = np.einsum("nki,nkj->nij", slopes, slopes)
    volume = square[:, 0, 0] * square[:, 1, 1] - square[:, 0, 1] * square[:, 1, 0]
    adjugate = np.stack(
        [np.stack([square[:, 1, 1], -square[:, 0, 1]], -1), np.stack([-square[:, 1, 0], square[:, 0, 0]], -1)], axis=1
    )
    return np.einsum("nij,nkj->nik", adjugate / volume[:, None, None], slopes)
