"""What the samples of an image meet first: their cameras look for it, or their rays go through the tree themselves.

Source: Mei, Popescu and Sacks 2007, section 6. Deviation: the paper projects points by the camera's cubic and draws
squares, which leave holes, and leak where surfaces touch. Rays that meet triangles do neither.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from anamorph.base.compiled import cores, steps_over_all_cores
from anamorph.gpu.visibility import Rectangle
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.packets import TILE, Packet, follow
from anamorph.methods.threeray.sample_rays import Samples, interpolate
from anamorph.methods.threeray.scene_triangles import Triangles
from anamorph.methods.threeray.surfel_tree import SurfelTree
from anamorph.methods.threeray.surfels_seen import look
from anamorph.raytriangle.camera_frames import frames_of
from anamorph.raytriangle.owners import Places
from anamorph.raytriangle.walls import SPACE, walls_of

FEW = 1024
"""With so many samples or fewer it does not pay for a camera to look: they go through the tree with others. At 250
samples that takes 0.6 times as long, at 3,000 1.4 times."""

GRAIN, TILES = 8, 64
"""Cameras, and tiles, that a core takes at a time."""

WORK = "nodes", "surfels", "boxes", "tests"
"""What is counted. Nodes and surfels: those that a camera or a packet was asked of. Boxes: surfels that may be seen by
cameras which look, while packets go by their rays alone. Tests: samples that were asked for a surfel's triangle."""


def meet(
    cameras: Cameras,
    places: Places,
    tree: SurfelTree,
    triangles: Triangles,
    materials: Materials,
    samples: Samples,
    shown: np.ndarray,
    rectangle: Rectangle,
    culling: str,
) -> Generator[None, None, dict[str, int]]:
    """Fill what the samples of cameras that are `shown` (K,) meet in a rectangle, in steps; returns the work's counts.

    The samples' owners are known; their rays are interpolated here. Boxes of the tree are told by `culling`: "bounds"
    or "walls".
    """
    interpolate(cameras, places, samples, rectangle)
    x0, y0, x1, y1 = rectangle
    own = samples.owner[y0:y1, x0:x1]
    count = np.bincount(own[own >= 0], minlength=len(shown))
    looking, alone = np.flatnonzero(shown & (count > FEW)), shown & (count <= FEW)
    tiles = -(-(x1 - x0) // TILE) * -(-(y1 - y0) // TILE)
    looks, follows = np.zeros((len(looking), len(WORK)), np.int64), np.zeros((tiles, len(WORK)), np.int64)
    nodes = tree.nodes
    if len(looking):
        rays = cameras.origins[looking], cameras.directions[looking]
        frames, walls = frames_of(*rays), walls_of(*rays) if culling == "walls" else None

        def one_by_one(start: int, stop: int) -> None:
            ways, space = np.empty(x1 - x0), np.empty(SPACE)
            look(
                cameras, frames, walls, places, nodes, triangles, materials, samples, looking, looks,
                ways, space, start, stop,
            )  # fmt: skip

        yield from steps_over_all_cores(one_by_one, len(looking), max(1, min(GRAIN, len(looking) // (8 * cores()))))

    def together(start: int, stop: int) -> None:
        packet = Packet.reserved()
        follow(cameras, nodes, triangles, materials, samples, alone, rectangle, packet, follows, start, stop)

    if alone.any():
        yield from steps_over_all_cores(together, tiles, TILES)
    spent = looks.sum(axis=0) + follows.sum(axis=0)
    cameras_shown = {"cameras": int(np.count_nonzero(shown)), "looking": len(looking)}
    return cameras_shown | dict(zip(WORK, spent.tolist(), strict=True))
