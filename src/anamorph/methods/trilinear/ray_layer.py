"""One layer of an image: the rays that leave the specular surfaces first met, or those that go on from a second one.

Each layer plans what its rays see, finds it for each sample, and writes it over what the layer before has found. The
first one's rays come from ray_triangles.py; those of the next follow from what it sees of mirrors.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass

import numpy as np
import wgpu

from anamorph.gpu.drawing import ProjectionUniform
from anamorph.gpu.recording import Recorder
from anamorph.gpu.visibility import VisibilityBuffer
from anamorph.methods.trilinear.beams import Beams, making_beams
from anamorph.methods.trilinear.box_tree import BoxTree
from anamorph.methods.trilinear.following import following_rays
from anamorph.methods.trilinear.pairs import FRONTS, Own
from anamorph.methods.trilinear.path_ends import PathEnds
from anamorph.methods.trilinear.pixels import seen_samples
from anamorph.methods.trilinear.plan import Plan, Planner
from anamorph.methods.trilinear.ray_records import following_records, pair_records, piece_records, triangle_records
from anamorph.methods.trilinear.ray_triangles import RayTriangles
from anamorph.methods.trilinear.visibility import Visibility

Straight = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""What makes pieces with straight edges: of ray triangles' images, origins and directions, all scene triangles'
corners, and pairs of both."""

AROUND = 1.0 / 8.0
"""Pixels by which rays that follow are planned beyond the samples that ask for them. Next to the curved mirror that
they left they spread wide: a whole pixel's may see all of the scene, of which a sample sees one point."""


@dataclass(frozen=True, eq=False)
class SceneTriangles:
    """The scene's triangles, F of them, with their tree.

    Parameters
    ----------
    tree : BoxTree
    corners, normals : (F, 3, 3) float64
    group : (F,) int32
        See `body_groups`.
    object : (F,) int32
        The object number of each.
    mirror : (F,) bool
    near : float
        What is nearer than this to where its ray starts is that itself, metres.
    """

    tree: BoxTree
    corners: np.ndarray
    normals: np.ndarray
    group: np.ndarray
    object: np.ndarray
    mirror: np.ndarray
    near: float


@dataclass(frozen=True, eq=False)
class LayerPlan:
    """What was planned for a layer in a frame, from which the next one follows.

    Parameters
    ----------
    beams : Beams
    plan : Plan
    records : (K,) of `RAY_TRIANGLE`
        By the beams' numbers.
    pairs : (P,) of `PAIR`
    """

    beams: Beams
    plan: Plan
    records: np.ndarray
    pairs: np.ndarray


class RayLayer:
    """The rays of one bounce, of one line of the spectrum. What may take long is done in steps."""

    def __init__(
        self, visibility: Visibility, ends: PathEnds, size: tuple[int, int], straight: Straight | None = None
    ) -> None:
        self.visibility, self.ends = visibility, ends
        self._size, self._straight = size, straight
        # A straight edge may show what no ray sees.
        self._spacing = 0.0 if straight is not None else 1.0 / visibility.kind.side
        self._planner = Planner()

    def beams(self, rays: RayTriangles, triangles: SceneTriangles) -> Generator[None, None, Beams]:
        """The rays that exist, as functions of the image."""
        chosen = np.flatnonzero(rays.exists)
        image, origins, directions = (each[chosen] for each in (rays.image, rays.origins, rays.directions))
        beams = yield from making_beams(image, origins, directions, self._size, triangles.near, self._spacing)
        return beams._replace(number=chosen[beams.number].astype(np.int32))

    def plan(self, rays: RayTriangles, beams: Beams, triangles: SceneTriangles) -> Generator[None, None, Plan]:
        """What the rays see."""
        shown = beams.number
        own = Own(rays.face[shown], rays.group[shown], rays.sees[shown])
        return (yield from self._planner.planning(beams, triangles.tree, triangles.group, own))

    def first(
        self, rays: RayTriangles, beams: Beams, records: np.ndarray, triangles: SceneTriangles
    ) -> Generator[None, None, LayerPlan]:
        """Take over the rays that leave the surfaces first met; `records` are those of `triangle_records`."""
        plan = yield from self.plan(rays, beams, triangles)
        pairs = pair_records(beams, plan, triangles.group > 0)
        if self._straight is None:
            pieces = piece_records(beams, plan)
        else:
            # Those left out may have no direction at all.
            image, origins, directions = (each[beams.number] for each in (rays.image, rays.origins, rays.directions))
            pieces = self._straight(image, origins, directions, triangles.corners, plan.pair[:, :2])
        self.visibility.write(records, pairs, pieces)
        return LayerPlan(beams, plan, records, pairs)

    def follow(
        self, before: LayerPlan, triangles: SceneTriangles, bounces: int
    ) -> Generator[None, None, LayerPlan | None]:
        """Take over the rays that mirrors send on which the layer before sees; None where it sees none.

        Rays that have met `bounces` interfaces are not followed.
        """
        pair = before.plan.pair
        goes_on = before.records["met"][before.beams.number] < bounces
        chosen = np.flatnonzero((pair[:, 2] == 1) & triangles.mirror[pair[:, 1]] & goes_on[pair[:, 0]])
        box, count = seen_samples(before.plan, chosen, self._spacing)
        chosen, box = chosen[count > 0], box[count > 0]
        if not len(chosen):
            return None
        sent = following_rays(before.beams, before.plan, chosen, triangles.corners, triangles.normals)
        yield
        # The rectangle of the samples that see the mirror: pieces may reach further.
        low_high = box + AROUND * np.array([-1.0, -1.0, 1.0, 1.0])
        domain = low_high[:, [[0, 1], [2, 1], [2, 3], [0, 3]]] + before.beams.center[pair[chosen, 0]][:, None]
        beams = yield from making_beams(
            sent.image, sent.origins, sent.directions, self._size, triangles.near, self._spacing, domain
        )
        if not len(beams.number):
            return None
        face = pair[chosen, 1]
        number = len(chosen)
        nothing, never = np.zeros(number, np.int32), np.zeros(number, bool)
        rays = RayTriangles(
            sent.image, sent.origins, sent.directions, np.ones((number, 3)),
            np.ones(number, bool), never, never,
            face, triangles.object[face], triangles.group[face], np.full(number, FRONTS, np.int32), nothing,
        )  # fmt: skip
        plan = yield from self.plan(rays, beams, triangles)
        records = following_records(
            triangle_records(rays, beams), beams, before.beams, before.plan, before.records, before.pairs, chosen
        )
        yield
        pairs = pair_records(beams, plan, triangles.group > 0)
        drawn = piece_corners(records, before.beams, before.plan, chosen)
        yield
        self.visibility.write(drawn, pairs, piece_records(beams, plan))
        return LayerPlan(beams, plan, records, pairs)

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        recorder: Recorder,
        projection: ProjectionUniform,
        found: VisibilityBuffer,
        depth: wgpu.GPUTextureView | None,
        line: int,
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Find what is seen, and write it into a line of the visibility buffer; returns the encoder to go on with.

        With a `depth`, rays that are drawn on surfaces are only found where these are not behind it.
        """
        depth = None if self.visibility.kind.bare else depth
        encoder = yield from self.visibility.draw(encoder, recorder, projection, depth)
        self.ends.draw(encoder, projection, found, depth, line)
        if self.visibility.many:
            encoder = recorder.part(encoder)
            yield
        return encoder


def piece_corners(records: np.ndarray, beams: Beams, plan: Plan, chosen: np.ndarray) -> np.ndarray:
    """Following ray triangles, once for each piece of their pairs, which is where they are drawn; (T,)."""
    row = np.full(len(plan.pair), -1)
    row[chosen] = np.arange(len(chosen))
    pieces = np.flatnonzero(row[plan.owner] >= 0)
    pair = plan.owner[pieces]
    drawn = records[row[pair]]
    place = plan.place[pieces] + beams.center[plan.pair[pair, 0]][:, None]
    for corner in range(3):
        drawn[f"corner_{corner}"][:, :2], drawn[f"corner_{corner}"][:, 2] = place[:, corner], 1.0
    return drawn[drawn["number"] > 0]
