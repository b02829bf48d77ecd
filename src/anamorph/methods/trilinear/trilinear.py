"""Trilinear projection: every scene triangle drawn through every ray triangle that sees it, with exact curved edges.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005). A mirror, a lens, or a camera made by hand is a mesh of ray
triangles (chapters 2, 5 to 7; ray_triangles.py). What each of them may see of the scene is found in a tree (beams,
box_tree, pairs, plan), its samples keep what is nearest of it (sights, sample_sights), and that is written into the
visibility buffer (path_ends).

Deviation: the thesis draws straight lines between the projected corners of a scene triangle, and more corners where
these are too wrong, which `edges=straight` does (straight/). Else each sample decides by its own ray.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.targets import Target, make_texture
from anamorph.gpu.visibility import Rectangle
from anamorph.methods.finding import FindingDrawing
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.paths import specular_rectangle
from anamorph.methods.trilinear.beams import Beams, making_beams
from anamorph.methods.trilinear.box_tree import make_tree, moved_tree
from anamorph.methods.trilinear.path_ends import PathEnds
from anamorph.methods.trilinear.ray_layer import LayerRays, RayLayer, SceneTriangles
from anamorph.methods.trilinear.ray_records import add_incident, ending, lens_records, seen_words, triangle_records
from anamorph.methods.trilinear.ray_triangles import (
    RayTriangles,
    body_groups,
    body_triangles,
    camera_triangles,
    lens_edges,
)
from anamorph.methods.trilinear.straight import StraightEdges
from anamorph.methods.trilinear.visibility import NEARNESS_FORMAT, Kind, Visibility, put
from anamorph.optics.ray_meshes import bodies_of
from anamorph.projection import camera_projection
from anamorph.raymesh import RayMesh
from anamorph.raytriangle.camera_frames import Frames
from anamorph.raytriangle.owners import Places, owners_of, places_of, sampled
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

NEAR = 1e-6
"""What is nearer than this to where its ray starts is that itself, as a share of the scene's coordinates."""


@dataclass(frozen=True)
class Options:
    """Options of `trilinear`.

    Parameters
    ----------
    edges : str
        "exact": curved, as each pixel's ray finds them; "straight": the thesis's lines between projected corners.
    tessellate : int
        With straight edges, into how many parts each side of a scene triangle is divided (4.5.1).
    slices : int
        With straight edges, how many levels of t are added to each shape (4.5.2).
    clip : str
        With straight edges, where shapes are cut at the sides of a ray triangle: "scene", so that those of neighbours
        meet (5.2), or "screen" (5.1).
    bounces : int
        How many specular interfaces a path may meet: a mirror is one, a lens is two. With straight edges no mirror is
        followed after the first mirror or lens. Where a lens is met after a mirror, or one interface too many, the path
        goes on as if nothing followed.
    antialias : int
        Samples a pixel: 1 or 4.
    dispersion : bool
        Whether red and blue light goes its own way through glass that has an Abbe number.
    """

    edges: str = option("exact", choices=("exact", "straight"))
    tessellate: int = option(1, low=1, high=64)
    slices: int = option(0, low=0, high=256)
    clip: str = option("scene", choices=("scene", "screen"))
    bounces: int = option(2, low=1, high=8)
    antialias: int = option(1, choices=(1, 4))
    dispersion: bool = True


class TrilinearDrawing(FindingDrawing):
    """Finds what an image's ray triangles see."""

    def __init__(self, stage: Stage, options: Options) -> None:
        self._bare = not stage.has_pinhole
        self._bodies = bodies_of(stage.view.scene, stage.geometry)
        disperses = any(side.disperses for body in self._bodies for side in body.sides)
        self._disperses = disperses and options.dispersion and not self._bare
        super().__init__(stage, 3 if self._disperses else 1, options.antialias)
        self._options, geometry = options, stage.geometry
        corners = np.asarray(geometry.positions, float)[geometry.faces]
        group, normals = body_groups(self._bodies, geometry)
        mirror = np.isin(geometry.face_object, np.array(stage.buffers.mirrors) + 1)
        self._triangles = SceneTriangles(
            make_tree(corners), corners, normals, group, seen_words(group > 0),
            geometry.face_object.astype(np.int32), mirror, NEAR * float(np.abs(corners).max(initial=0.0)),
        )  # fmt: skip
        self._planned: list[list[LayerRays]] = []
        width, height = self.visibility.size
        self._owner, self._nearness = np.empty((height, width), np.int32), np.empty((height, width))
        self._depths = make_texture(self.visibility.size, NEARNESS_FORMAT)
        self._lenses = storage_buffer(lens_records(lens_edges(self._bodies), stage.buffers.first_face))
        self._lines = [self._line() for _ in self.visibility.textures]

    def _line(self) -> list[RayLayer]:
        """The layers of the light of one line of the spectrum."""
        stage, options, buffer = self.stage, self._options, self.visibility
        straight = None
        if options.edges == "straight":
            straight = StraightEdges(options.tessellate, options.slices, options.clip == "scene").pieces
        mirrors = bool(self._triangles.mirror.any())
        # Bare rays meet their first mirror one layer later.
        bounces = (options.bounces + self._bare if mirrors else 1) if straight is None else 1
        layers: list[RayLayer] = []
        for bounce in range(bounces):
            glass = (
                not self._bare and bounce == 0 and any(side.refracts for body in self._bodies for side in body.sides)
            )
            kind = Kind(not self._bare, straight is not None, glass)
            visibility = Visibility(stage.buffers, self._lenses, buffer.size, kind)
            before = layers[-1].ends if layers else None
            ends = PathEnds(visibility, self._depths, before, bounce + 1 < bounces)
            layers.append(RayLayer(visibility, ends, straight))
        return layers

    @property
    def replaced(self) -> tuple[int, ...]:
        """The mirrors and lenses; a ray mesh replaces none."""
        return () if self._bare else tuple(mesh for body in self._bodies for mesh in body.meshes)

    def deformed(self, geometry: Geometry) -> None:
        """Refit the tree."""
        corners = np.asarray(geometry.positions, float)[geometry.faces]
        self._triangles = replace(self._triangles, corners=corners, tree=moved_tree(self._triangles.tree, corners))

    def prepare(
        self, encoder: wgpu.GPUCommandEncoder, camera: Camera | RayMesh, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Plan what each ray triangle sees, in steps."""
        size = self.stage.view.size
        self.visibility.show(None)
        self._planned = []
        if isinstance(camera, RayMesh):
            self.looked, rectangle = (camera, shift), (0, 0, *size)
            lines = [camera_triangles(camera)]
        else:
            self.look(camera, shift)
            seen = specular_rectangle(self.stage.view.scene, camera, size)
            if seen is None:
                return encoder
            rectangle = seen
            lines = body_triangles(self._bodies, self.stage.geometry, camera.eye(size), self._disperses)
        side = self.visibility.side
        inner: Rectangle = (side * rectangle[0], side * rectangle[1], side * rectangle[2], side * rectangle[3])
        lines = [replace(rays, image=rays.image - rays.image[..., 2:] * [*shift, 0.0]) for rays in lines]
        places, owning = self._owners(lines[0])
        for rays, layers in zip(lines, self._lines, strict=False):
            self._planned.append(
                (yield from self._find(camera, shift, inner, rays, places, lines[0].face, owning, layers))
            )
        self.visibility.show(rectangle, len(self._planned))
        return encoder

    def _owners(self, rays: RayTriangles) -> tuple[Places, np.ndarray]:
        """Where ray triangles are, and which of them own samples."""
        places = places_of(sampled(rays.image, self.visibility.side, (0.0, 0.0)), self.visibility.size)
        fronts = None if self._bare else places.front
        if fronts is not None:
            # From behind, a lens is not looked at.
            places.box[~fronts & (rays.lens > 0)] = 0
        return places, owners_of(places, self.visibility.size, fronts, self._nearness, self._owner)

    def _find(
        self,
        camera: Camera | RayMesh,
        shift: tuple[float, float],
        rectangle: Rectangle,
        line: RayTriangles,
        places: Places,
        face: np.ndarray,
        owning: np.ndarray,
        layers: list[RayLayer],
    ) -> Generator[None, None, list[LayerRays]]:
        """Find what the rays of one line see, from layer to layer."""
        rows = np.arange(len(face))
        if len(line.face) < len(face):
            # Of red and blue light there are the rays of what disperses it.
            number = np.full(len(self._triangles.group), -1)
            number[line.face] = np.arange(len(line.face))
            rows = number[face]
        owning = owning[rows[owning] >= 0]
        rays = line.chosen(rows[owning])
        # Its last two places are those of `NOBODY` and `BACK`.
        place_of = np.full(len(face) + 2, -1, np.int32)
        place_of[owning] = np.arange(len(owning))
        x0, y0, x1, y1 = rectangle
        exist = np.flatnonzero(rays.exists)
        image = sampled(rays.image[exist], self.visibility.side, (0.0, 0.0))
        beams, frames = yield from making_beams(
            image, rays.origins[exist], rays.directions[exist], places.box[owning[exist]], self._triangles.near
        )
        beams = beams._replace(number=exist.astype(np.int32))
        records = triangle_records(rays, beams)
        if isinstance(camera, Camera):
            add_incident(records, beams, camera, self.stage.view.size, self.visibility.side, shift)
        kept = ~ending(records, self._options.bounces)[beams.number]
        if not kept.all():
            beams, frames = Beams(*(each[kept] for each in beams)), Frames(*(each[kept] for each in frames))
        layer = LayerRays(beams, frames, records)
        owner = place_of[self._owner[y0:y1, x0:x1]]
        found = [(yield from layers[0].first(rays, layer, owner, rectangle, self._triangles))]
        for before, following in pairwise(layers):
            follows = yield from following.follow(before, found[-1], rectangle, self._triangles, self._options.bounces)
            if follows is None:
                break
            found.append(follows)
        return found

    def find(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Camera | RayMesh, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """Write what each sample sees, in steps; what a layer sees takes the place of what it follows."""
        if not self._planned:
            return None
        if not isinstance(camera, Camera):
            return self._finding(encoder, None)
        side, rectangle = self.visibility.side, self.visibility.rectangle
        assert rectangle is not None
        x0, y0, x1, y1 = (side * end for end in rectangle)
        # The projection's depth is this number over the depth in metres.
        near = camera_projection(camera, self.stage.view.size).clip[2, 3]
        put(self._depths, (x0, y0, x1, y1), (near * self._nearness[y0:y1, x0:x1]).astype(np.float32))
        return self._finding(encoder, self.depth_of(encoder, target))

    def _finding(
        self, encoder: wgpu.GPUCommandEncoder, depth: wgpu.GPUTextureView | None
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        recorder, projection = self.stage.recorder, self.stage.projection
        for line, (layers, planned) in enumerate(zip(self._lines, self._planned, strict=False)):
            for layer, _ in zip(layers, planned, strict=False):
                encoder = yield from layer.draw(encoder, recorder, projection, self.visibility, depth, line)
        return encoder

    @property
    def _layers(self) -> list[LayerRays]:
        """What was found for green light."""
        return self._planned[0] if self._planned else []

    def figures(self) -> dict[str, float]:
        """How many ray triangles the last frame had, and pairs of these and scene triangles."""
        return {
            "ray_triangles": sum(len(layer.beams.number) for layer in self._layers),
            "pairs": sum(layer.pairs for layer in self._layers),
        }

    def diagnostics(self) -> Mapping[str, Any]:
        """The scene's triangles, and the rays of each layer of the last frame with what samples see by them."""
        sights = [layer.sights for layer in self._lines[0][: len(self._layers)]]
        return {"triangles": self._triangles, "layers": self._layers, "sights": sights}


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by trilinear projection."""
    check_options("trilinear", options)
    if options.edges == "exact":
        for name in ("tessellate", "slices", "clip"):
            if getattr(options, name) != getattr(Options, name):
                raise AnamorphError(f"trilinear: {name} is for straight edges; leave it out, or give edges=straight")
    elif options.antialias > 1:
        raise AnamorphError("trilinear: antialias is for exact edges; leave it out, or give edges=exact")
    stage = Stage(view)
    middles = partial(open_session, view, replace(options, antialias=1))
    return Session(stage, TrilinearDrawing(stage, options), options.antialias, middles)


METHOD = Method(
    name="trilinear",
    summary="every scene triangle projected through every ray triangle that sees it: exact curved edges",
    source="Vallance 2005",
    options=Options,
    open=open_session,
    refracts=True,
    ray_meshes=True,
)
