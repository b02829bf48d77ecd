"""Trilinear projection: every scene triangle drawn through every ray triangle that sees it, with exact curved edges.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005). A mirror, a lens, or a camera made by hand is a mesh of ray
triangles (chapters 2, 5 to 7; ray_triangles.py). What each of them sees of the scene is planned on the processor
(beams, box_tree, pairs, plan), found by the device without a ray being cast (visibility.py), and written into the
visibility buffer (path_ends.py).

Deviation: the thesis draws straight lines between the projected corners of a scene triangle, and more corners where
these are too wrong, which `edges=straight` does (straight/). Else each sample decides by its own ray.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.targets import Target
from anamorph.methods.finding import FindingDrawing
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.paths import specular_rectangle
from anamorph.methods.trilinear.box_tree import make_tree, moved_tree
from anamorph.methods.trilinear.path_ends import PathEnds
from anamorph.methods.trilinear.ray_layer import LayerPlan, RayLayer, SceneTriangles
from anamorph.methods.trilinear.ray_records import add_incident, going_on, lens_records, triangle_records
from anamorph.methods.trilinear.ray_triangles import body_groups, body_triangles, camera_triangles, lens_edges
from anamorph.methods.trilinear.straight import StraightEdges
from anamorph.methods.trilinear.visibility import Kind, Visibility
from anamorph.optics.ray_meshes import bodies_of
from anamorph.raymesh import RayMesh
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
            make_tree(corners), corners, normals, group,
            geometry.face_object.astype(np.int32), mirror, NEAR * float(np.abs(corners).max(initial=0.0)),
        )  # fmt: skip
        self._planned: list[list[LayerPlan]] = []
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
            bare = self._bare or bounce > 0
            glass = not bare and any(side.refracts for body in self._bodies for side in body.sides)
            kind = Kind(bare, buffer.side, straight is not None, glass)
            seen, ended = (layers[-1].visibility, layers[-1].ends) if layers else (None, None)
            visibility = Visibility(stage.buffers, self._lenses, buffer.size, kind, seen)
            ends = PathEnds(stage.buffers, visibility, ended, bounce + 1 < bounces)
            layers.append(RayLayer(visibility, ends, stage.view.size, straight))
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
        for unmoved, layers in zip(lines, self._lines, strict=False):
            rays = replace(unmoved, image=unmoved.image - unmoved.image[..., 2:] * [*shift, 0.0])
            beams = yield from layers[0].beams(rays, self._triangles)
            records = triangle_records(rays, beams)
            if isinstance(camera, Camera):
                add_incident(records, beams, camera, size, shift)
            beams = going_on(beams, records, self._options.bounces)
            planned = [(yield from layers[0].first(rays, beams, records, self._triangles))]
            for layer in layers[1:]:
                follows = yield from layer.follow(planned[-1], self._triangles, self._options.bounces)
                if follows is None:
                    break
                planned.append(follows)
            self._planned.append(planned)
        self.visibility.show(rectangle, len(self._planned))
        return encoder

    def find(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Camera | RayMesh, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """Find what each sample sees, in steps; what a layer finds takes the place of what it follows."""
        if not self._planned:
            return None
        return self._finding(encoder, None if self._bare else self.depth_of(encoder, target))

    def _finding(
        self, encoder: wgpu.GPUCommandEncoder, depth: wgpu.GPUTextureView | None
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        recorder, projection = self.stage.recorder, self.stage.projection
        for line, (layers, planned) in enumerate(zip(self._lines, self._planned, strict=False)):
            for layer, _ in zip(layers, planned, strict=False):
                encoder = yield from layer.draw(encoder, recorder, projection, self.visibility, depth, line)
        return encoder

    @property
    def _layers(self) -> list[LayerPlan]:
        """What was planned for green light."""
        return self._planned[0] if self._planned else []

    def figures(self) -> dict[str, float]:
        """How many pairs of ray triangle and scene triangle the last frame took, and in how many pieces."""
        plans = [layer.plan for layer in self._layers]
        return {"pairs": sum(len(plan.pair) for plan in plans), "pieces": sum(len(plan.owner) for plan in plans)}

    def diagnostics(self) -> Mapping[str, Any]:
        """The scene's triangles, and what was planned for each layer of the last frame."""
        return {"triangles": self._triangles, "layers": self._layers}


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
