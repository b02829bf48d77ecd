"""Trilinear projection: every scene triangle drawn through every ray triangle that sees it, with exact curved edges.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005). A mirror, a lens, or a camera made by hand is a mesh of ray
triangles (chapters 2, 5 to 7; ray_triangles.py). What each of them sees of the scene is planned on the processor
(beams, box_tree, pairs, plan), found by the device without a ray being cast (visibility.py), and coloured
(coloring.py); here it becomes a part of the image.

Deviation: the thesis draws straight lines between the projected corners of a scene triangle, and more corners where
these are too wrong, which `edges=straight` does (straight/). Else each pixel decides by its own ray.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.bindings import bind, layout_of, texture
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.drawing import make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, make_target
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.specular_drawing import SpecularDrawing
from anamorph.methods.stage import Stage
from anamorph.methods.trilinear.box_tree import make_tree, moved_tree
from anamorph.methods.trilinear.coloring import Coloring
from anamorph.methods.trilinear.ray_layer import LayerPlan, RayLayer, SceneTriangles
from anamorph.methods.trilinear.ray_records import add_incident, going_on, triangle_records
from anamorph.methods.trilinear.ray_triangles import body_groups, body_triangles, camera_triangles, lens_edges
from anamorph.methods.trilinear.straight import StraightEdges
from anamorph.methods.trilinear.visibility import Kind, Visibility, data_layout
from anamorph.optics.ray_meshes import bodies_of
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

LINES = wgpu.ColorWrite.ALL, wgpu.ColorWrite.RED, wgpu.ColorWrite.BLUE
"""What is drawn of the light of each line: green's everywhere, then red and blue over it."""

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
        Samples a pixel: 1 or 4. Each scene triangle is coloured once a pixel. What mirrors show in mirrors keeps one.
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


class TrilinearDrawing(SpecularDrawing):
    """Draws what an image's ray triangles see."""

    def __init__(self, stage: Stage, options: Options) -> None:
        super().__init__(stage)
        self._options = options
        scene, size, geometry = stage.view.scene, stage.view.size, stage.geometry
        self._bare = not stage.has_pinhole
        self._bodies = bodies_of(scene, geometry)
        corners = np.asarray(geometry.positions, float)[geometry.faces]
        group, normals = body_groups(self._bodies, geometry)
        mirror = np.isin(geometry.face_object, np.array(stage.buffers.mirrors) + 1)
        self._triangles = SceneTriangles(
            make_tree(corners), corners, normals, group,
            geometry.face_object.astype(np.int32), mirror, NEAR * float(np.abs(corners).max(initial=0.0)),
        )  # fmt: skip
        self._planned: list[LayerPlan] = []
        self._colors = make_target(size, (COLOR_FORMAT,))
        lenses = lens_edges(self._bodies).astype(np.float32)
        self._lenses = storage_buffer(lenses if len(lenses) else np.zeros((1, 2, 4), np.float32))
        disperses = any(side.disperses for body in self._bodies for side in body.sides)
        disperses = disperses and options.dispersion and not self._bare
        self._lines = [self._line(mask) for mask in (LINES if disperses else LINES[:1])]
        whole = layout_of(texture())
        self._whole = bind(whole, [self._colors.textures[0].create_view()])
        module = shader_module("methods/trilinear/composed.wgsl")

        def composed(vertex: str, fragment: str, **settings: Any) -> wgpu.GPURenderPipeline:
            groups, formats, samples = (data_layout(), whole), (COLOR_FORMAT,), options.antialias
            return make_pipeline(
                module, vertex, fragment, formats, buffers=(), groups=groups, samples=samples, **settings
            )

        if self._bare:
            self._composed = composed("bare_owner_vertex", "composed_color")
            self._rim = composed("sky_vertex", "composed_rim", depth_compare="greater-equal")
        else:
            self._composed = composed("surface_owner_vertex", "composed_color", cull="back")

    def _line(self, mask: int) -> list[RayLayer]:
        """The layers of light that is written with a mask."""
        stage, options = self.stage, self._options
        straight = None
        if options.edges == "straight":
            straight = StraightEdges(options.tessellate, options.slices, options.clip == "scene").pieces
        mirrors = bool(self._triangles.mirror.any())
        # Bare rays meet their first mirror one layer later.
        bounces = (options.bounces + self._bare if mirrors else 1) if straight is None else 1
        layers: list[RayLayer] = []
        for bounce in range(bounces):
            bare = self._bare or bounce > 0
            kind = Kind(
                bare,
                fine=options.antialias > 1 and bounce == 0,
                straight=straight is not None,
                glass=not bare and any(side.refracts for body in self._bodies for side in body.sides),
                meets_specular=bool(self._triangles.group.any()),
            )
            seen, shown = (layers[-1].visibility, layers[-1].coloring) if layers else (None, None)
            visibility = Visibility(stage.buffers, self._lenses, stage.view.size, kind, seen)
            coloring = Coloring(stage.buffers, visibility, self._colors, mask, shown, bounce + 1 < bounces)
            layers.append(RayLayer(visibility, coloring, stage.view.size, straight))
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
        """Plan what each ray triangle sees, find it for each pixel, and colour it, in steps."""
        recorder = self.stage.recorder
        size, projection = self.stage.view.size, self.stage.projection
        if not self._bare and not self._bodies:
            return encoder
        if isinstance(camera, RayMesh):
            lines = [camera_triangles(camera)]
        else:
            lines = body_triangles(self._bodies, self.stage.geometry, camera.eye(size), self._options.dispersion)
        for number, (unmoved, layers) in enumerate(zip(lines, self._lines, strict=False)):
            rays = replace(unmoved, image=unmoved.image - unmoved.image[..., 2:] * [*shift, 0.0])
            beams = yield from layers[0].beams(rays, self._triangles)
            records = triangle_records(rays, beams)
            if isinstance(camera, Camera):
                add_incident(records, beams, camera, size, shift)
            beams = going_on(beams, records, self._options.bounces)
            planned = [(yield from layers[0].first(rays, beams, records, self._triangles))]
            encoder = yield from layers[0].draw(encoder, recorder, projection, clear=number == 0)
            for layer in layers[1:]:
                follows = yield from layer.follow(planned[-1], self._triangles, self._options.bounces)
                if follows is None:
                    break
                encoder = yield from layer.draw(encoder, recorder, projection, clear=False)
                planned.append(follows)
            self._planned = planned if number == 0 else self._planned
        return encoder

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """What the rays see, where it belongs in the image."""
        if not self._planned:
            return
        first = self._lines[0][0].visibility
        render_pass.set_pipeline(self._composed)
        first.bind(render_pass)
        render_pass.set_bind_group(3, self._whole)
        render_pass.draw(3 * first.count)
        if self._bare and self._options.antialias > 1:
            render_pass.set_pipeline(self._rim)
            render_pass.draw(3)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The seen buffers, by the d line."""
        for layer, _ in zip(self._lines[0], self._planned, strict=False):
            layer.coloring.draw_seen(render_pass)

    def figures(self) -> dict[str, float]:
        """How many pairs of ray triangle and scene triangle the last frame took, and in how many pieces."""
        plans = [layer.plan for layer in self._planned]
        return {"pairs": sum(len(plan.pair) for plan in plans), "pieces": sum(len(plan.owner) for plan in plans)}

    def diagnostics(self) -> Mapping[str, Any]:
        """The scene's triangles, and what was planned for each layer of the last frame."""
        return {"triangles": self._triangles, "layers": self._planned}


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
    return Session(stage, TrilinearDrawing(stage, options), options.antialias)


METHOD = Method(
    name="trilinear",
    summary="every scene triangle projected through every ray triangle that sees it: exact curved edges",
    source="Vallance 2005",
    options=Options,
    open=open_session,
    refracts=True,
    ray_meshes=True,
)
