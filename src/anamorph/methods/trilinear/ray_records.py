"""Ray triangles, and what they see, as the shaders read them."""

from __future__ import annotations

import numpy as np

from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.ray_triangles import RayTriangles
from anamorph.projection import camera_projection
from anamorph.scene.camera import Camera

RAY_TRIANGLE = np.dtype(
    [
        ("direction_x", "f4", 3), ("face", "u4"),
        ("direction_y", "f4", 3), ("object", "u4"),
        ("direction_one", "f4", 3), ("scale_x", "f4"),
        ("origin_x", "f4", 3), ("scale_y", "f4"),
        ("origin_y", "f4", 3), ("scale_one", "f4"),
        ("origin_one", "f4", 3), ("transmittance_x", "f4"),
        ("anchor", "f4", 3), ("transmittance_y", "f4"),
        ("incident_x", "f4", 3), ("transmittance_one", "f4"),
        ("incident_y", "f4", 3), ("lens", "u4"),
        ("incident_one", "f4", 3), ("inner", "u4"),
        ("center_x", "f4"), ("center_y", "f4"), ("first", "u4"), ("met", "u4"),
        ("exists", "u4"), ("padding", "u4", 3),
    ]
)  # fmt: skip

LENS = np.dtype(
    [
        ("middle", "f4", 3), ("radius", "f4"),
        ("axis", "f4", 3), ("first_face", "u4"),
        ("stop_face", "u4"), ("padding", "u4", 3),
    ]
)  # fmt: skip

TOTAL, ENDS, BY_EDGE = np.uint32(1), np.uint32(2), np.uint32(4)
"""What happens in a lens, where light does not go through: reflection is total, the path ends, or it leaves by the
edge."""

SPECULAR = np.uint32(0x80000000)
"""What marks the front of a specular surface among the triangles seen."""


def triangle_records(rays: RayTriangles, beams: Beams) -> np.ndarray:
    """All ray triangles, (K,) of `RAY_TRIANGLE`. Those without rays are left at zero but for what they are."""
    records = np.zeros(len(rays.image), RAY_TRIANGLE)
    records["face"], records["object"], records["first"] = np.maximum(rays.face, 0), rays.object, rays.object
    records["lens"], records["inner"] = rays.lens, TOTAL * rays.total + BY_EDGE * rays.by_edge
    records["met"] = np.where(rays.lens > 0, 2, np.where(rays.object > 0, 1, 0))
    shown = beams.number
    records["exists"][shown] = 1
    records["anchor"][shown] = beams.anchor
    records["center_x"][shown], records["center_y"][shown] = beams.center.T
    transmittance = np.einsum("kqi,ki->kq", beams.weights, rays.transmittance[shown])
    for term, name in enumerate(("x", "y", "one")):
        records[f"direction_{name}"][shown] = beams.direction[:, :, term]
        records[f"origin_{name}"][shown] = beams.origin[:, :, term]
        records[f"scale_{name}"][shown] = beams.scale[:, term]
        records[f"transmittance_{name}"][shown] = transmittance[:, term]
    return records


def ending(records: np.ndarray, bounces: int) -> np.ndarray:
    """Which rays have met more than `bounces` interfaces, (K,) bool; the records say so from now on."""
    ends = records["met"] > bounces
    records["inner"][ends] = records["inner"][ends] & BY_EDGE | ENDS
    return ends


def add_incident(
    records: np.ndarray, beams: Beams, camera: Camera, size: tuple[int, int], side: int, shift: tuple[float, float]
) -> None:
    """Tell ray triangles how the eye looks at them, in an image of `size` pixels with `side` samples along a side."""
    looks = camera_projection(camera, size, shift)
    x, y = 2.0 / (side * size[0]) * looks.right, -2.0 / (side * size[1]) * looks.up
    records["incident_x"], records["incident_y"] = x, y
    middle = (beams.center[:, :1] + 0.5) * x + (beams.center[:, 1:] + 0.5) * y
    records["incident_one"][beams.number] = looks.base - looks.right + looks.up + middle


def add_before(records: np.ndarray, beams: Beams, before: Beams, sources: np.ndarray, ray_triangle: np.ndarray) -> None:
    """Tell ray triangles what they follow, and how light came to them.

    Parameters
    ----------
    records : (S,) of `RAY_TRIANGLE`
        Theirs, changed.
    beams : Beams
        Theirs.
    before, sources
        The beams and records of those that they follow.
    ray_triangle : (S,) int array
        Which of `before` each follows.
    """
    source = sources[before.number[ray_triangle]]
    records["first"] = np.where(source["first"] > 0, source["first"], records["object"])
    records["met"] = source["met"] + 1
    shown = beams.number
    incoming = before.direction[ray_triangle[shown]]
    moved = beams.center - before.center[ray_triangle[shown]]
    records["incident_x"][shown], records["incident_y"][shown] = incoming[:, :, 0], incoming[:, :, 1]
    records["incident_one"][shown] = incoming[:, :, 2] + np.einsum("kij,kj->ki", incoming[:, :, :2], moved)


def seen_words(fronts: np.ndarray) -> np.ndarray:
    """The words that say that a scene triangle is seen, from its back and from its front, (F, 2) uint32; `fronts` (F,)
    are those that have a specular front."""
    face = np.arange(1, len(fronts) + 1, dtype=np.uint32)
    return np.column_stack([face, face | np.where(fronts, SPECULAR, np.uint32(0))])


def lens_records(edges: np.ndarray, first_face: np.ndarray) -> np.ndarray:
    """The lenses, (L,) of `LENS`, at least one.

    Parameters
    ----------
    edges : (L, 2, 4) float64
        From `lens_edges`.
    first_face : (objects + 1,) int64
        The first triangle of each object.
    """
    records = np.zeros(max(len(edges), 1), LENS)
    if len(edges):
        number = edges[:, 0, 3].astype(int)
        records["middle"], records["axis"] = edges[:, 0, :3], edges[:, 1, :3]
        records["radius"] = edges[:, 1, 3]
        records["first_face"] = np.where(number > 0, first_face[number - 1], 0)
        records["stop_face"] = np.where(number > 0, first_face[number], 0)
    return records
