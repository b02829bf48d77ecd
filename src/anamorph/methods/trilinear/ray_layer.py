"""One layer of an image: the rays that leave the specular surfaces first met, or those that go on from a second one.

Each layer finds what its samples see, and is written over what the layer before has found. The first one's rays come
from ray_triangles.py; those of the next follow from what it sees of mirrors.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace

import numpy as np
import wgpu

from anamorph.gpu.drawing import ProjectionUniform
from anamorph.gpu.recording import Recorder
from anamorph.gpu.visibility import Rectangle, VisibilityBuffer
from anamorph.methods.trilinear.beams import Beams, making_beams
from anamorph.methods.trilinear.box_tree import BoxTree
from anamorph.methods.trilinear.following import following_rays, sending
from anamorph.methods.trilinear.pairs import FRONTS, Own
from anamorph.methods.trilinear.path_ends import PathEnds
from anamorph.methods.trilinear.plan import Planner
from anamorph.methods.trilinear.ray_records import add_before, triangle_records
from anamorph.methods.trilinear.ray_triangles import RayTriangles
from anamorph.methods.trilinear.sights import Sights
from anamorph.methods.trilinear.visibility import Visibility
from anamorph.raytriangle.camera_frames import Frames

Straight = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""What makes pieces with straight edges: of ray triangles' images, origins and directions, all scene triangles'
corners, pairs of both, and their words."""


@dataclass(frozen=True, eq=False)
class SceneTriangles:
    """The scene's triangles, F of them, with their tree.

    Parameters
    ----------
    tree : BoxTree
    corners, normals : (F, 3, 3) float64
    group : (F,) int32
        See `body_groups`.
    words : (F, 2) uint32
        See `seen_words`.
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
    words: np.ndarray
    object: np.ndarray
    mirror: np.ndarray
    near: float


@dataclass(frozen=True, eq=False)
class LayerRays:
    """The rays of a layer in a frame, from which those of the next one follow.

    Parameters
    ----------
    beams : Beams
    frames : Frames
        By what they are culled.
    records : (K,) of `RAY_TRIANGLE`
        By the beams' numbers.
    pairs : int
        How many pairs of ray triangle and scene triangle were asked.
    """

    beams: Beams
    frames: Frames
    records: np.ndarray
    pairs: int = 0


class RayLayer:
    """The rays of one bounce, of one line of the spectrum. What may take long is done in steps."""

    def __init__(self, visibility: Visibility, ends: PathEnds, straight: Straight | None = None) -> None:
        self.visibility, self.ends = visibility, ends
        self.sights = Sights.reserved(visibility.size)
        self._straight = straight
        self._planner = Planner()

    def first(
        self,
        rays: RayTriangles,
        layer: LayerRays,
        owner: np.ndarray,
        rectangle: Rectangle,
        triangles: SceneTriangles,
    ) -> Generator[None, None, LayerRays]:
        """Find what the rays see that leave the surfaces first met, in a rectangle whose samples' owners are known."""
        self.sights.clear()
        x0, y0, x1, y1 = rectangle
        self.sights.owner[y0:y1, x0:x1] = owner
        if self._straight is None:
            return (yield from self._look(rays, layer, rectangle, triangles))
        own = Own(*(each[layer.beams.number] for each in (rays.face, rays.group, rays.sees)))
        plan = yield from self._planner.planning(layer.beams, layer.frames, triangles.tree, triangles.group, own)
        number = layer.beams.number[plan.pair[:, 0]]
        words = np.column_stack([number, triangles.words[plan.pair[:, 1], plan.pair[:, 2]]]).astype(np.uint32)
        # Those left out may have no direction at all.
        image, origins, directions = (each[layer.beams.number] for each in (rays.image, rays.origins, rays.directions))
        self.visibility.write(rectangle, owner, layer.records, None)
        self.visibility.write_straight(
            self._straight(image, origins, directions, triangles.corners, plan.pair[:, :2], words)
        )
        return replace(layer, pairs=len(plan.pair))

    def follow(
        self,
        before: RayLayer,
        rays_before: LayerRays,
        rectangle: Rectangle,
        triangles: SceneTriangles,
        bounces: int,
    ) -> Generator[None, None, LayerRays | None]:
        """Find what the rays see that mirrors send on which the layer before sees; None where it sees none.

        Rays that have met `bounces` interfaces are not followed.
        """
        self.sights.clear()
        beams = rays_before.beams
        goes_on = rays_before.records["met"][beams.number] < bounces
        sent = sending(before.sights, beams, triangles.mirror, goes_on, rectangle)
        found = following_rays(beams, sent, triangles.corners, triangles.normals)
        met = np.flatnonzero(found.met)
        if not len(met):
            return None
        yield
        column, row = sent.place.T
        numbers = np.cumsum(found.met) - 1
        self.sights.owner[row, column] = np.repeat(np.where(found.met, numbers, -1), np.diff(sent.first))
        image, origins, directions = found.image[met], found.origins[met], found.directions[met]
        made = yield from making_beams(image, origins, directions, found.box[met], triangles.near)
        face, number = sent.face[met], len(met)
        nothing, never = np.zeros(number, np.int32), np.zeros(number, bool)
        rays = RayTriangles(
            image, origins, directions, np.ones((number, 3)),
            np.ones(number, bool), never, never,
            face, triangles.object[face], triangles.group[face], np.full(number, FRONTS, np.int32), nothing,
        )  # fmt: skip
        records = triangle_records(rays, made[0])
        add_before(records, made[0], beams, rays_before.records, sent.ray_triangle[met])
        yield
        return (yield from self._look(rays, LayerRays(*made, records), rectangle, triangles))

    def _look(
        self, rays: RayTriangles, layer: LayerRays, rectangle: Rectangle, triangles: SceneTriangles
    ) -> Generator[None, None, LayerRays]:
        """Find what samples see whose owners are known."""
        own = Own(*(each[layer.beams.number] for each in (rays.face, rays.group, rays.sees)))
        pairs = yield from self._planner.looking(
            layer.beams, layer.frames, triangles.tree, triangles.group, own, triangles.words, self.sights
        )
        x0, y0, x1, y1 = rectangle
        self.visibility.write(rectangle, self.sights.owner[y0:y1, x0:x1], layer.records, self.sights.seen[y0:y1, x0:x1])
        return replace(layer, pairs=pairs)

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        recorder: Recorder,
        projection: ProjectionUniform,
        found: VisibilityBuffer,
        depth: wgpu.GPUTextureView | None,
        line: int,
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Write what is seen into a line of the visibility buffer; returns the encoder to go on with.

        With a `depth`, only samples are written whose mirror or lens is not behind it.
        """
        if self._straight is not None:
            encoder = yield from self.visibility.draw(encoder, recorder, projection)
        self.ends.draw(encoder, projection, found, depth, line)
        return encoder
