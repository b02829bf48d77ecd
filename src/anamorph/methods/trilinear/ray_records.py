"""Ray triangles, and what they see, as visibility.wgsl reads them."""

from __future__ import annotations

import numpy as np

from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.plan import Plan
from anamorph.methods.trilinear.ray_triangles import RayTriangles
from anamorph.projection import camera_projection
from anamorph.scene.camera import Camera

PAIR = np.dtype([("terms", "f4", 24), ("center", "f4", 2), ("ray_triangle", "u4"), ("seen", "u4")])

PIECE = np.dtype([("place", "f4", 6), ("pair", "u4")])

RAY_TRIANGLE = np.dtype(
    [
        ("corner_0", "f4", 3), ("center_x", "f4"),
        ("corner_1", "f4", 3), ("center_y", "f4"),
        ("corner_2", "f4", 3), ("number", "u4"),
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
        ("before", "u4"), ("through", "u4"), ("first", "u4"), ("met", "u4"),
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
    """All ray triangles, (K,) of `RAY_TRIANGLE`. Those that the image does not show are left at zero but for where
    they are, and have no number."""
    records = np.zeros(len(rays.image), RAY_TRIANGLE)
    for corner in range(3):
        records[f"corner_{corner}"] = rays.image[:, corner]
    records["face"], records["object"], records["first"] = np.maximum(rays.face, 0), rays.object, rays.object
    records["lens"], records["inner"] = rays.lens, TOTAL * rays.total + BY_EDGE * rays.by_edge
    records["met"] = np.where(rays.lens > 0, 2, np.where(rays.object > 0, 1, 0))
    shown = beams.number
    records["number"][shown] = shown + 1
    records["anchor"][shown] = beams.anchor
    records["center_x"][shown], records["center_y"][shown] = beams.center.T
    transmittance = np.einsum("kqi,ki->kq", beams.weights, rays.transmittance[shown])
    for term, name in enumerate(("x", "y", "one")):
        records[f"direction_{name}"][shown] = beams.direction[:, :, term]
        records[f"origin_{name}"][shown] = beams.origin[:, :, term]
        records[f"scale_{name}"][shown] = beams.scale[:, term]
        records[f"transmittance_{name}"][shown] = transmittance[:, term]
    return records


def going_on(beams: Beams, records: np.ndarray, bounces: int) -> Beams:
    """The beams of the rays that have met no more than `bounces` interfaces; the records of the others say so."""
    ends = records["met"] > bounces
    if not ends.any():
        return beams
    records["inner"][ends] = records["inner"][ends] & BY_EDGE | ENDS
    kept = ~ends[beams.number]
    return beams._replace(**{name: each[kept] for name, each in beams._asdict().items() if np.ndim(each)})


def add_incident(
    records: np.ndarray, beams: Beams, camera: Camera, size: tuple[int, int], shift: tuple[float, float]
) -> None:
    """Tell ray triangles how the eye looks at them."""
    looks = camera_projection(camera, size, shift)
    x, y = 2.0 / size[0] * looks.right, -2.0 / size[1] * looks.up
    records["incident_x"], records["incident_y"] = x, y
    middle = beams.center[:, :1] * x + beams.center[:, 1:] * y
    records["incident_one"][beams.number] = looks.base - looks.right + looks.up + middle


def following_records(
    records: np.ndarray,
    beams: Beams,
    before: Beams,
    plan: Plan,
    sources: np.ndarray,
    pairs: np.ndarray,
    chosen: np.ndarray,
) -> np.ndarray:
    """Ray triangles that follow the `chosen` pairs of a plan: what they follow, and how light came to them.

    Parameters
    ----------
    records : (S,) of `RAY_TRIANGLE`
        Theirs, changed and returned.
    beams : Beams
        Theirs.
    before, plan, sources, pairs
        The beams, plan, ray triangles and pairs that they follow.
    chosen : (S,) int array
        Rows of the plan.
    """
    ray_triangle = plan.pair[chosen, 0]
    source = sources[before.number[ray_triangle]]
    records["before"], records["through"] = source["number"], pairs["seen"][chosen]
    records["first"] = np.where(source["first"] > 0, source["first"], records["object"])
    records["met"] = source["met"] + 1
    shown = beams.number
    incoming = before.direction[ray_triangle[shown]]
    moved = beams.center - before.center[ray_triangle[shown]]
    records["incident_x"][shown], records["incident_y"][shown] = incoming[:, :, 0], incoming[:, :, 1]
    records["incident_one"][shown] = incoming[:, :, 2] + np.einsum("kij,kj->ki", incoming[:, :, :2], moved)
    return records


def pair_records(beams: Beams, plan: Plan, fronts: np.ndarray) -> np.ndarray:
    """The pairs, (P,) of `PAIR`; `fronts` (F,) says which scene triangles have a specular front."""
    ray_triangle, face, side = plan.pair.T
    records = np.zeros(len(plan.pair), PAIR)
    records["terms"], records["center"] = plan.terms, beams.center[ray_triangle]
    records["ray_triangle"] = beams.number[ray_triangle] + 1
    records["seen"] = face + 1 + np.where(fronts[face] & (side == 1), SPECULAR, np.uint32(0))
    return records


def piece_records(beams: Beams, plan: Plan) -> np.ndarray:
    """The pieces, (T,) of `PIECE`."""
    records = np.zeros(len(plan.owner), PIECE)
    place = plan.place + beams.center[plan.pair[plan.owner, 0]][:, None]
    records["place"], records["pair"] = place.reshape(-1, 6), plan.owner
    return records


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
