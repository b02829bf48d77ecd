"""The radii of curvature of a rear-view mirror, as the European rules take them.

After the definitions of Directive 2003/97/EC, annex I (UN Regulation 46 has the same): at three points of the central
arc, a third, half and two thirds of the way along it, the mean of the two principal radii; the mean of these is the
mirror's radius. The bounds are for a reader to check against the rule in force.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.scene.model import Mesh
from anamorph.scene.pose import WORLD_UP, bounding_pose
from anamorph.surfaces.intersection import intersect
from anamorph.surfaces.nurbs import NurbsSurface

SHARES = (1.0 / 3.0, 1.0 / 2.0, 2.0 / 3.0)


@dataclass(frozen=True, eq=False)
class MirrorRadii:
    """Radii in metres, negative for a concave mirror.

    Parameters
    ----------
    points : (3, 3) float64
        On the surface, a third, half and two thirds along the longer side through the middle.
    principal : (3, 2) float64
        r_i and r'_i at each, the one of lesser magnitude first.
    point_means : (3,) float64
        r_p = (r_i + r'_i) / 2.
    mean : float
        r, the mean of these three.
    principal_deviation : float
        The greatest of |r_i - r_p| and |r'_i - r_p|, as a share of r: at most 0.15.
    point_deviation : float
        The greatest |r_p - r|, as a share of r: at most 0.15, or 0.25 from r = 3 m on.
    """

    points: np.ndarray
    principal: np.ndarray
    point_means: np.ndarray
    mean: float
    principal_deviation: float
    point_deviation: float


def principal_radii(mesh: Mesh) -> np.ndarray:
    """Both principal radii at every vertex, (V, 2) float64, metres; infinite where flat, negative where concave."""
    surface, parameters = _nurbs(mesh)
    with np.errstate(divide="ignore"):
        return 1.0 / surface.curvatures(parameters)


def mirror_radii(mesh: Mesh) -> MirrorRadii:
    """The mean radius of a mirror, and how far it is from one radius everywhere."""
    surface, parameters = _nurbs(mesh)
    frame = bounding_pose((mesh,), WORLD_UP, f"mirror '{mesh.name}'")
    vertices = (surface.position(parameters) - frame.center) @ frame.axes.T
    size = np.ptp(vertices, axis=0)
    longer = int(size[1] > size[0])
    places = np.zeros((3, 3))
    places[:, longer] = (np.array(SHARES) - 0.5) * size[longer]
    nearest = np.linalg.norm(vertices[None, :, :2] - places[:, None, :2], axis=2).argmin(axis=1)
    # Seen from before the mirror, along its mean normal.
    places[:, 2] = 2.0 * size.max()
    outward = np.tile(-frame.axes[2], (3, 1))
    points, _, ok = intersect(surface, frame.center + places @ frame.axes, outward, parameters[nearest])
    if not ok.all():
        raise AnamorphError(f"mirror '{mesh.name}': is not whole around its middle; choose the faces of one glass")
    inside = surface.curvatures(_parameters(surface, points, parameters[nearest]))
    with np.errstate(divide="ignore"):
        radii = 1.0 / inside
    if not np.isfinite(radii).all():
        raise AnamorphError(f"mirror '{mesh.name}': is flat, so that it has no mean radius")
    means = radii.mean(axis=1)
    mean = float(means.mean())
    return MirrorRadii(
        points,
        radii,
        means,
        mean,
        float(np.abs(radii - means[:, None]).max() / abs(mean)),
        float(np.abs(means - mean).max() / abs(mean)),
    )


def _nurbs(mesh: Mesh) -> tuple[NurbsSurface, np.ndarray]:
    if not isinstance(mesh.surface, NurbsSurface) or mesh.parameters is None:
        raise AnamorphError(f"mirror '{mesh.name}': has no NURBS surface to measure; give a CAD face")
    return mesh.surface, mesh.parameters


def _parameters(surface: NurbsSurface, points: np.ndarray, near: np.ndarray) -> np.ndarray:
    """The (u, v), (N, 2), of points on the surface, by Gauss-Newton from `near`."""
    uv = np.array(near, float)
    for _ in range(20):
        away = points - surface.position(uv)
        slopes = np.stack([surface.derivative(uv, 1, 0), surface.derivative(uv, 0, 1)], axis=-1)
        uv += np.stack([np.linalg.lstsq(slope, gap, rcond=None)[0] for slope, gap in zip(slopes, away, strict=True)])
    return uv
