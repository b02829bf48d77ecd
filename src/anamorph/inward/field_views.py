"""Views from a point of convergence: one where all rays fit in it, else four through the faces of a tetrahedron.

Source: Vallance and Calder, "Inward looking projections" (2003), sections 4.1, 4.2 and 6; the tetrahedron is that of
Fortes, "Tetrahedron environment maps" (2000). Deviation: both fields are seen as by who looks along the rays, and not
from the point backward, so that neither windings nor normals need to be turned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.inward.converging import Converging
from anamorph.projection import MapFrame, Projection

NARROW = np.cos(np.radians(60.0))
"""Rays within this cosine of their mean are seen in one view."""

HOLE = 1e-6
"""How near to the point of convergence a view sees, as a share of the distance of its image plane."""

MARGIN = 1.02
"""How much larger than needed a view is, so that it has neighbours at its borders, too."""

EXACT = 1e-9

CORNERS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3.0)
"""Of a tetrahedron, as unit vectors; they are also the normals of the opposite faces, turned inward."""


@dataclass(frozen=True, eq=False)
class FieldView:
    """An anti-perspective view.

    Parameters
    ----------
    frame : MapFrame
        Its image plane lies before all rays, and its viewpoint is the point of convergence.
    bounds : (2, 2) float64
        Least and greatest x and y in the image plane.
    size : (width, height)
        Texels.
    """

    frame: MapFrame
    bounds: np.ndarray
    size: tuple[int, int]

    def projections(self, point: np.ndarray) -> tuple[Projection, Projection]:
        """Of the near and of the far field; depth only cuts off what is not in them.

        Parameters
        ----------
        point : (3,) float64
            Of convergence.
        """
        center, half = self.bounds.mean(axis=0), np.ptp(self.bounds, axis=0) / 2.0
        x, y, w = self.frame.matrix()
        across, upright = (x - center[0] * w) / half[0], (y - center[1] * w) / half[1]
        forward = self.frame.axes[2]
        before = HOLE * -self.frame.convergence * np.append(forward, -forward @ self.frame.center)
        clips = np.stack([across, upright, before, w]), np.stack([-across, -upright, [0.0, 0.0, 0.0, HOLE], -w])
        near, far = (Projection(clip, forward, self.frame.axes[0], self.frame.axes[1], point) for clip in clips)
        return near, far

    def lookup(self) -> np.ndarray:
        """(3, 3) float64 on directions: homogeneous texels (x w, y w, w) from the top left, with w > 0 ahead."""
        right, up, forward = self.frame.axes
        distance = -1.0 / self.frame.convergence
        (left, _), (_, top) = self.bounds
        x, y = np.array(self.size) / np.ptp(self.bounds, axis=0)
        return np.stack([x * (-distance * right - left * forward), y * (distance * up + top * forward), forward])


def field_views(rays: Converging, size: tuple[int, int], texels: int = 0) -> list[FieldView]:
    """The views that show what rays see.

    Parameters
    ----------
    rays : Converging
    size : (width, height)
        Of the image, pixels.
    texels : int
        Across each view; 0 takes one for each pixel, by the median over the mesh. Where rays leave a plane, and are
        linear in the image, the view is the image itself: texels are pixels.
    """
    image = _as_image(rays, size)
    if image is not None:
        return [image]
    directions = rays.arrows.reshape(-1, 3) / np.linalg.norm(rays.arrows.reshape(-1, 3), axis=1, keepdims=True)
    mean = directions.mean(axis=0)
    mean /= max(np.linalg.norm(mean), 1e-30)
    if (directions @ mean).min() > NARROW:
        axes = _axes(mean, CORNERS[np.abs(CORNERS @ mean).argmin()])
        distance = float((rays.arrows @ mean).max())
        frame = _frame(rays.point, axes, distance)
        local = directions @ axes.T
        slopes = -distance * local[:, :2] / local[:, 2:]
        middle, half = (slopes.max(axis=0) + slopes.min(axis=0)) / 2.0, np.ptp(slopes, axis=0) / 2.0
        bounds = middle + np.array([[-MARGIN], [MARGIN]]) * half
        return [FieldView(frame, bounds, _sides(rays, np.ptp(bounds, axis=0) / distance, texels))]
    distance = rays.reach
    # At a distance of 1 a face has its corners at a distance of sqrt 8 from its middle, of which one is up.
    bounds = MARGIN * distance * np.sqrt(2.0) * np.array([[-np.sqrt(3.0), -2.0], [np.sqrt(3.0), 1.0]])
    sides = _sides(rays, np.ptp(bounds, axis=0) / distance, texels)
    return [
        FieldView(_frame(rays.point, _axes(corner, -CORNERS[number - 1]), distance), bounds, sides)
        for number, corner in enumerate(CORNERS)
    ]


def _as_image(rays: Converging, size: tuple[int, int]) -> FieldView | None:
    """The view whose texels are the image's pixels, if there is one."""
    places, arrows = rays.places.reshape(-1, 3), rays.arrows.reshape(-1, 3)
    linear = np.linalg.lstsq(places, arrows * places[:, 2:], rcond=None)[0]
    if np.abs(places @ linear - arrows * places[:, 2:]).max() > EXACT * rays.reach * places[:, 2].max():
        return None
    # Where rays leave moves against the arrows.
    across, down = -linear[0], -linear[1]
    forward = np.cross(across, down)
    if abs(across @ down) > EXACT * np.linalg.norm(forward) or forward @ arrows[0] <= 0.0:
        return None
    axes = np.stack([each / np.linalg.norm(each) for each in (across, -down, forward)])
    corners = np.array([[0.0, size[1], 1.0], [size[0], 0.0, 1.0]]) @ linear @ axes.T
    return FieldView(_frame(rays.point, axes, float(corners[0, 2])), -corners[:, :2], size)


def _frame(point: np.ndarray, axes: np.ndarray, distance: float) -> MapFrame:
    return MapFrame(point - distance * axes[2], axes, np.zeros(2), -1.0 / distance)


def _axes(forward: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Rows: right, up and forward, the second one as near to `up` as it can be."""
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward])


def _sides(rays: Converging, slopes: np.ndarray, texels: int) -> tuple[int, int]:
    """Texels across and upright of a view over so much slope each way."""
    if not texels:
        places = rays.places[..., :2] / rays.places[..., 2:]
        directions = rays.arrows / np.linalg.norm(rays.arrows, axis=2, keepdims=True)
        pixels, angles = (
            np.linalg.norm(each - np.roll(each, 1, axis=1), axis=2).ravel() for each in (places, directions)
        )
        wide = angles > EXACT
        texels = int(np.clip(slopes[0] * np.median(pixels[wide] / angles[wide]), 64, 4096))
    return texels, max(int(np.ceil(texels * slopes[1] / slopes[0])), 1)
