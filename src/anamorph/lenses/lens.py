"""A lens between two exact surfaces, as three meshes that close: front, back, and the edge around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.scene.model import Color, Diffuse, Glass, Mesh
from anamorph.surfaces.base import Surface

EDGE: Color = (0.14, 0.15, 0.15)


@dataclass(frozen=True, eq=False)
class Lens:
    """A lens, as meshes for a scene.

    Parameters
    ----------
    front, back : Mesh
        Glass, called NAME/front and NAME/back: the faces to which the axis points, and from which it comes. Their
        exact surfaces are in them.
    edge : Mesh
        The diffuse band between the two, called NAME/edge.
    """

    front: Mesh
    back: Mesh
    edge: Mesh

    @property
    def meshes(self) -> tuple[Mesh, Mesh, Mesh]:
        """What to put into a scene."""
        return self.front, self.back, self.edge


def disc(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """A unit disc of `rings` rings around its middle: points (1 + 3 rings (rings + 1), 2), faces (6 rings^2, 3).

    Ring k has 6 k points, so that all triangles are about alike; the last 6 `rings` points are the border, in order.
    """
    points, faces = [np.zeros((1, 2))], []
    inner, outer = 0, 1
    for ring in range(1, rings + 1):
        count, within = 6 * ring, max(6 * (ring - 1), 1)
        angle = np.arange(count) * 2.0 * np.pi / count
        points.append(ring / rings * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
        sector, step = np.divmod(np.arange(count), ring)
        near = sector * (ring - 1) + step
        a, b = near % within + inner, (near + 1) % within + inner
        c, d = np.arange(count) + outer, (np.arange(count) + 1) % count + outer
        between = step < ring - 1
        faces += [np.stack([a, c, d], axis=-1), np.stack([a, d, b], axis=-1)[between]]
        inner, outer = outer, outer + count
    return np.concatenate(points), np.concatenate(faces)


def rings_for(vertices: int) -> int:
    """How many rings of a `disc` give about so many vertices."""
    return max(1, round((np.sqrt(1.0 + 4.0 * (vertices - 1) / 3.0) - 1.0) / 2.0))


def drop(surface: Surface, points: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The parameters, (N, 2), of the points of `surface` on the lines along `axis` through `points` (N, 3)."""
    points = np.asarray(points, float)
    exact = 8.0 * np.finfo(float).eps * np.abs(points).max(initial=0.0)
    for _ in range(12):
        # Newton's iteration: onto the plane that touches the surface nearby.
        parameters = surface.parameters(points)
        normal = surface.normal(parameters)
        height = np.sum((surface.position(parameters) - points) * normal, axis=1) / (normal @ axis)
        points = points + height[:, None] * axis
        if np.abs(height).max(initial=0.0) <= exact:
            break
    return surface.parameters(points)


def thickness(front: Surface, back: Surface, middle: np.ndarray, axes: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """How thick a lens is along its axis, (N,) metres, at points `plane` (N, 2) across it."""
    right, up, outward = axes
    points = middle + plane[:, :1] * right + plane[:, 1:] * up
    ends = [surface.position(drop(surface, points, outward)) for surface in (front, back)]
    return (ends[0] - ends[1]) @ outward


def lens_between(
    front: Surface,
    back: Surface,
    middle: np.ndarray,
    axes: np.ndarray,
    radius: float,
    glass: Glass,
    name: str = "lens",
    vertices: int = 547,
) -> Lens:
    """A round lens between any two surfaces.

    Parameters
    ----------
    front, back : Surface
        Where the axis leaves the lens and where it enters; which way their own normals point does not matter.
    middle : (3,) array
        A point of the axis, near the lens.
    axes : (3, 3) array
        Rows: the unit vectors right, up and outward, right-handed and perpendicular; outward is the axis.
    radius : float
        From the axis to the edge, metres.
    glass : Glass
    name : str
    vertices : int
        About how many each face gets: 3 k (k + 1) + 1 for the nearest whole k.

    Returns
    -------
    Lens
        Its edge lies on the cylinder about the axis; each face has its own vertices there.
    """
    axes, middle = np.asarray(axes, float), np.asarray(middle, float)
    right, up, outward = axes
    plane, faces = disc(rings_for(vertices))
    plane = radius * plane
    points = middle + plane[:, :1] * right + plane[:, 1:] * up
    parameters = [drop(surface, points, outward) for surface in (front, back)]
    thick = (front.position(parameters[0]) - back.position(parameters[1])) @ outward
    if thick.min() <= 0.0:
        x, y = 1e3 * plane[thick.argmin()]
        raise AnamorphError(
            f"lens '{name}': its faces cross {np.hypot(x, y):.1f} mm from its axis; make it thicker or smaller"
        )
    ahead = Mesh.exact(f"{name}/front", front, parameters[0], faces, glass, outward)
    behind = Mesh.exact(f"{name}/back", back, parameters[1], faces[:, ::-1], glass, -outward)
    border = slice(-6 * rings_for(vertices), None)
    return Lens(ahead, behind, _edge(name, ahead.positions[border], behind.positions[border], outward))


def _edge(name: str, front: np.ndarray, back: np.ndarray, outward: np.ndarray) -> Mesh:
    """The band between two borders (N, 3), which run counter-clockwise about `outward`."""
    count = len(front)
    one, next_one = np.arange(count), (np.arange(count) + 1) % count
    faces = [np.stack([one + count, next_one + count, next_one], axis=-1), np.stack([one + count, next_one, one], -1)]
    away = front - front.mean(axis=0, dtype=float)
    away = away - np.outer(away @ outward, outward)
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    return Mesh(
        name=f"{name}/edge",
        positions=np.concatenate([front, back]),
        faces=np.concatenate(faces).astype(np.int32),
        normals=np.concatenate([away, away]).astype(np.float32),
        material=Diffuse(color=EDGE),
    )
