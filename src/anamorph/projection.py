"""Projections onto an image: the eye's pinhole, and a map seen from any point, the point at infinity included.

A map's viewpoint V is given relative to its image plane. With Z the height over that plane, and k = 1 / L for a
viewpoint at distance L behind it, a point (X, Y, Z) projects to (X + a Z, Y + b Z) / (1 + k Z), where (a, b) is the
viewpoint's sideways offset times k. At k = 0 this is the parallel projection, so that there is no seam between the two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.scene.camera import Camera


@dataclass(frozen=True, eq=False)
class Projection:
    """How world points reach clip space, and which way each image point looks.

    Parameters
    ----------
    clip : (4, 4) float64
        World to clip space; depth is reversed, 1 on the near plane.
    base, right, up : (3,) float64
        The image point (x, y), each in -1 to 1, looks along base + x right + y up (not unit).
    eye : (3,) float64
        The eye; for a map, its image plane's centre.
    """

    clip: np.ndarray
    base: np.ndarray
    right: np.ndarray
    up: np.ndarray
    eye: np.ndarray

    def uniform(self, size: tuple[int, int], corner: tuple[int, int] = (0, 0)) -> np.ndarray:
        """The shader's `Projection` structure, as float32, for an image of `size` whose first pixel is at `corner`."""
        width, height = size
        # The angle of one pixel, by which the sky is filtered.
        spread = 2.0 * np.linalg.norm(self.up) / (np.linalg.norm(self.base) * height)
        return np.concatenate(
            [
                self.clip.T.ravel(),
                np.linalg.inv(self.clip).T.ravel(),
                [*self.base, spread],
                [*self.right, 0.0],
                [*self.up, 0.0],
                [*self.eye, 0.0],
                [width, height, *corner],
            ]
        ).astype(np.float32)


CROSSING = 1e-3
"""How close to the crossing of its lines a map draws, relative to the distance from its image plane."""

UNIFORM_BYTES = 4 * (16 + 16 + 5 * 4)


def pinhole_projection(eye: np.ndarray, base: np.ndarray, right: np.ndarray, up: np.ndarray, near: float) -> Projection:
    """A pinhole at `eye` whose image point (x, y) looks along base + x right + y up; depth is 0 at infinity."""
    x, y, w = np.linalg.inv(np.stack([right, up, base], axis=1))
    rows = np.stack([x, y, np.zeros(3), w])
    offset = -rows @ eye
    offset[2] = near
    return Projection(np.column_stack([rows, offset]), base, right, up, eye)


def camera_projection(camera: Camera, size: tuple[int, int], shift: tuple[float, float] = (0.0, 0.0)) -> Projection:
    """The projection of a pinhole camera; `shift` moves its sample points right and down, in pixels."""
    width, height = size
    right, up, forward = camera.axes()
    tangent = np.tan(np.radians(camera.field_of_view) / 2.0)
    right, up = right * tangent * width / height, up * tangent
    base = forward + 2.0 * shift[0] / width * right - 2.0 * shift[1] / height * up
    # The target may be far beyond what is near. Reversed depth in floating point resolves as much whatever `near` is.
    near = 1e-6 * float(np.linalg.norm(np.subtract(camera.target, camera.position)))
    return pinhole_projection(np.asarray(camera.position, float), base, right, up, near)


@dataclass(frozen=True, eq=False)
class MapFrame:
    """A viewpoint and its image plane.

    Parameters
    ----------
    center : (3,) float64
        A point of the image plane.
    axes : (3, 3) float64
        Rows: right, up and forward; the image plane is perpendicular to forward.
    slope : (2,) float64
        (a, b): the sideways offset of the viewpoint from `center`, over its distance behind the image plane.
    convergence : float
        k: one over that distance; 0 is a parallel projection.
    """

    center: np.ndarray
    axes: np.ndarray
    slope: np.ndarray
    convergence: float

    def project(self, points: np.ndarray) -> np.ndarray:
        """Homogeneous image-plane coordinates (x w, y w, w), (N, 3), of world points (N, 3)."""
        local = (points - self.center) @ self.axes.T
        height = local[:, 2]
        return np.column_stack([local[:, :2] + height[:, None] * self.slope, 1.0 + self.convergence * height])

    def vanishing(self, directions: np.ndarray) -> np.ndarray:
        """Where in the image plane lines along `directions` (N, 3) end, (N, 2); not for a parallel projection."""
        right, up, ahead = (directions @ self.axes.T).T
        safe = np.where(np.abs(ahead) > 1e-9, ahead, 1e-9) * self.convergence
        return np.stack([right + self.slope[0] * ahead, up + self.slope[1] * ahead], axis=-1) / safe[:, None]

    def matrix(self) -> np.ndarray:
        """The same as a (3, 4) matrix on homogeneous world points."""
        right, up, forward = self.axes
        rows = np.stack([right + self.slope[0] * forward, up + self.slope[1] * forward, self.convergence * forward])
        return np.column_stack([rows, np.array([0.0, 0.0, 1.0]) - rows @ self.center])


def map_frame(viewpoint: np.ndarray, center: np.ndarray, axes: np.ndarray) -> MapFrame:
    """The frame of a homogeneous `viewpoint` (x, y, z, w), (4,); w = 0 is the point at infinity."""
    offset = axes @ (viewpoint[:3] - viewpoint[3] * center)
    distance = -offset[2]
    return MapFrame(center=center, axes=axes, slope=offset[:2] / distance, convergence=viewpoint[3] / distance)


def map_projection(frame: MapFrame, bounds: np.ndarray, near_plane: np.ndarray, corners: np.ndarray) -> Projection:
    """The projection that fills a map with the rectangle `bounds` of the image plane.

    Of lines that converge it draws the part before their crossing, as seen from where they come from: the depth test
    runs away from the near plane and towards the viewpoint. Source: Vallance 2005, appendix G, sections 4.1 to 4.3.

    Parameters
    ----------
    frame : MapFrame
    bounds : (2, 2) float64
        Least and greatest x and y in the image plane.
    near_plane : (4,) float64
        (n, c) with n.p + c > 0 for points to be drawn: it may lie askew.
    corners : (8, 3) float64
        Corners of a box around the scene, which sets the far end of the depth range.
    """
    x, y, w = _filled(frame, bounds)
    steepness = _steepness(frame, bounds, near_plane, corners)
    return _with_lines(frame, bounds, np.stack([x, y, w - steepness * near_plane, w]))


def far_projection(frame: MapFrame, bounds: np.ndarray) -> Projection:
    """The projection of what lies beyond the crossing of lines that converge (convergence < 0): all is reversed.

    Parameters
    ----------
    frame : MapFrame
    bounds : (2, 2) float64
        Least and greatest x and y in the image plane.
    """
    x, y, w = _filled(frame, bounds)
    return _with_lines(frame, bounds, np.stack([-x, -y, [0.0, 0.0, 0.0, CROSSING], -w]))


def _filled(frame: MapFrame, bounds: np.ndarray) -> np.ndarray:
    """Rows x, y and w of the clip matrix, (3, 4)."""
    center, half = bounds.mean(axis=0), np.ptp(bounds, axis=0) / 2.0
    x, y, w = frame.matrix()
    return np.stack([(x - center[0] * w) / half[0], (y - center[1] * w) / half[1], w])


def _with_lines(frame: MapFrame, bounds: np.ndarray, clip: np.ndarray) -> Projection:
    center, half = bounds.mean(axis=0), np.ptp(bounds, axis=0) / 2.0
    right, up, forward = frame.axes
    # The line through the image-plane point (X, Y) runs along (k X - a, k Y - b, 1) in the frame's axes.
    base = (
        forward
        + (frame.convergence * center[0] - frame.slope[0]) * right
        + (frame.convergence * center[1] - frame.slope[1]) * up
    )
    return Projection(
        clip=clip,
        base=base,
        right=frame.convergence * half[0] * right,
        up=frame.convergence * half[1] * up,
        eye=frame.center,
    )


def _steepness(frame: MapFrame, bounds: np.ndarray, near_plane: np.ndarray, corners: np.ndarray) -> float:
    """The s at which depth, 1 - s (n.p + c) / w, reaches 0 just where the view volume leaves the scene's box.

    On every line of the view volume that ratio grows with the height over the image plane, and at one height it is
    linear: so the greatest stands at a corner of the volume's far end.
    """
    far = float(((corners - frame.center) @ frame.axes[2]).max())
    if frame.convergence < 0.0:
        far = min(far, (1.0 - CROSSING) / -frame.convergence)
    w = 1.0 + frame.convergence * far
    x, y = np.meshgrid(*bounds.T)
    places = np.stack([x.ravel(), y.ravel()], axis=1) * w - far * frame.slope
    ends = frame.center + places @ frame.axes[:2] + far * frame.axes[2]
    height = float((ends @ near_plane[:3] + near_plane[3]).max())
    # A little less than that, so that rounding clips nothing there.
    return 0.999 * w / height if far > 0.0 and height > 0.0 else 1.0
