"""Cameras, points and samples as the device reads them, to project points and to draw their squares."""

from __future__ import annotations

import numpy as np

from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.sample_rays import Samples
from anamorph.methods.threeray.surfels import Surfels
from anamorph.raytriangle.on_device import two_floats

CAMERA = np.dtype(
    [
        ("image", "f4", (3, 4)), ("origins", "f4", (3, 4)), ("directions", "f4", (3, 4)),
        ("transmittance", "f4", 3), ("near", "f4"), ("longest", "f4"), ("least_depth", "f4"), ("greatest_depth", "f4"),
        ("surface", "u4"), ("item", "u4"), ("left", "u4"), ("met", "u4"), ("pace", "f4"),
    ]
)  # fmt: skip
"""`ThreeRayCamera` of three_ray_camera.wgsl."""

POINT = np.dtype([("high", "f4", 3), ("triangle", "u4"), ("low", "f4", 3), ("surface", "u4")])
"""`ScenePoint` of three_ray_camera.wgsl."""

PROJECTED = np.dtype([("u", "f4"), ("v", "f4"), ("way", "f4")])
"""`Projected` of three_ray_camera.wgsl."""

OWNER = np.dtype([("item", "u4"), ("depth", "f4")])
"""`Owner` of squares.wgsl."""

NO_SURFACE = 0xFFFFFFFF

ANY_DEPTH = 3e38
"""A ray mesh that is the camera stands nowhere."""


def camera_records(cameras: Cameras, chosen: np.ndarray, materials: Materials, pace: np.ndarray) -> np.ndarray:
    """The chosen cameras, (K,) of `CAMERA`, with the `pace` (K,) of their `ScaledRays`."""
    records = np.zeros(len(chosen), CAMERA)
    records["pace"] = pace
    for name in ("image", "origins", "directions"):
        records[name][..., :3] = getattr(cameras, name)[chosen]
    for name, values in (
        ("transmittance", cameras.transmittance), ("near", cameras.near), ("longest", cameras.longest),
        ("item", cameras.item), ("left", cameras.left), ("met", cameras.bounces),
    ):  # fmt: skip
        records[name] = values[chosen]
    stands = records["item"] > 0
    depths = cameras.image[chosen, :, 2]
    records["least_depth"] = np.where(stands, depths.min(axis=1), -ANY_DEPTH)
    records["greatest_depth"] = np.where(stands, depths.max(axis=1), ANY_DEPTH)
    records["surface"] = np.where(records["left"] > 0, materials.surface[records["left"]], NO_SURFACE)
    return records


def point_records(surfels: Surfels, face_object: np.ndarray, materials: Materials, middle: np.ndarray) -> np.ndarray:
    """The surfels' centres, less a `middle`, (N,) of `POINT`."""
    records, place = np.zeros(len(surfels), POINT), two_floats(surfels.center - middle)
    records["high"], records["low"] = place[:, 0, :3], place[:, 1, :3]
    records["triangle"] = surfels.triangle
    records["surface"] = materials.surface[np.asarray(face_object)[surfels.triangle]]
    return records


def owner_records(cameras: Cameras, samples: Samples, shown: np.ndarray) -> np.ndarray:
    """What the samples look at, (height, width) of `OWNER`: those of cameras that are `shown` (K,) bool."""
    records, owner = np.zeros(samples.owner.shape, OWNER), samples.owner
    items = np.append(np.where(shown, cameras.item + 1, 0), 0)
    records["item"] = items[np.where(owner >= 0, owner, len(shown))]
    with np.errstate(divide="ignore"):
        records["depth"] = np.where(records["item"] > 0, 1.0 / samples.depth, 0.0)
    return records
