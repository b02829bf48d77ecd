"""Trilinear projection: every scene triangle drawn through every ray triangle that sees it, with exact curved edges.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005). A mirror, or a camera made by hand, is a mesh of ray
triangles (chapters 2, 5 and 7). What each of them sees of the scene is planned on the processor (trilinear/: beams,
tree, pairs, plan) and found by the device without a ray being cast (visibility.py); here it is coloured, as part of
the scene.

Deviation: the thesis draws straight lines between the projected corners of a scene triangle, and more corners where
these are too wrong. Here each pixel decides by its own ray; see `pairs`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import wgpu

from anamorph.frame import View
from anamorph.gpu.drawing import draw_mesh, make_pipeline, shader_module
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS, Target
from anamorph.methods.protocol import Method, Session
from anamorph.methods.session import DrawingSession, Stage
from anamorph.methods.visibility import RAY_TRIANGLE, Visibility, data_layout, seen_layout
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry
from anamorph.trilinear.beams import make_beams
from anamorph.trilinear.pairs import ALL, FRONTS, Own, Triangles
from anamorph.trilinear.plan import Planner
from anamorph.trilinear.tree import Tree, make_tree, moved_tree


@dataclass(frozen=True)
class Options:
    """Options of `trilinear`."""


class TrilinearDrawing:
    """Draws what a picture's ray triangles see. See `SpecularDrawing`."""

    def __init__(self, stage: Stage, options: Options) -> None:
        self._stage = stage
        self._bare = isinstance(stage.view.camera, RayMesh)
        self._mirrors = [(index, reflector(stage.view.scene.meshes[index])) for index in stage.buffers.specular]
        self.replaced = tuple(index for index, _ in self._mirrors)
        self._visibility = Visibility(stage.buffers, stage.view.size, self._bare)
        geometry = stage.geometry
        self._tree: Tree = make_tree(geometry.positions[geometry.faces])
        self._group = geometry.face_object.astype(np.int32)
        self._planner = Planner()
        bends = np.array([False, *stage.buffers.bends])
        self._fronts = bends[geometry.face_object]
        module = shader_module("gpu/vertices.wgsl", "methods/visibility.wgsl", "methods/trilinear.wgsl")
        vertex, kind = ("sky_vertex", "ray_mesh") if self._bare else ("scene_vertex", "reflected")
        settings = {"buffers": ()} if self._bare else {"cull": "back"}

        def pipeline(output: str, formats: tuple[str, ...]) -> wgpu.GPURenderPipeline:
            return make_pipeline(
                module, vertex, f"{kind}_{output}", formats,
                groups=(data_layout(), seen_layout()),
                depth_compare="greater-equal" if self._bare else "greater", **settings,
            )  # fmt: skip

        self._color, self._seen = pipeline("color", (COLOR_FORMAT,)), pipeline("seen", SEEN_FORMATS)

    def deformed(self, geometry: Geometry) -> None:
        """Refit the tree."""
        self._tree = moved_tree(self._tree, geometry.positions[geometry.faces])

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera | RayMesh, shift: tuple[float, float]) -> None:
        """Plan what each ray triangle sees, and find it for each pixel."""
        if isinstance(camera, RayMesh):
            meshes, own_face = [camera], np.full(len(camera.faces), -1, np.int32)
            objects = np.zeros(len(camera.faces), np.int32)
        else:
            eye = camera.eye(self._stage.view.size)
            meshes = [reflected_rays(mirror, eye) for _, mirror in self._mirrors]
            first = self._stage.geometry.first_face
            own_face = np.concatenate([np.arange(first[i], first[i + 1]) for i, _ in self._mirrors]).astype(np.int32)
            objects = self._group[own_face]
        picture, origins, directions = (
            np.concatenate([getattr(rays, name)[rays.faces] for rays in meshes])
            for name in ("picture", "origins", "directions")
        )
        picture = picture - picture[..., 2:] * [*shift, 0.0]
        beams = make_beams(picture, origins, directions, self._stage.view.size)
        own = Own(
            own_face[beams.number],
            objects[beams.number],
            np.full(len(beams.number), FRONTS if objects.any() else ALL, np.int32),
        )
        tree = self._tree
        plan = self._planner.plan(beams, Triangles(tree.faces, tree.low, tree.high, tree.corners, self._group), own)
        triangles = np.zeros(len(picture), RAY_TRIANGLE)
        for corner in range(3):
            triangles[f"corner_{corner}"] = picture[:, corner]
        triangles["valid"], triangles["face"] = 1, np.maximum(own_face, 0)
        self._visibility.write(triangles, beams, plan, self._fronts)
        self._visibility.draw(encoder, self._stage.projection)

    def complete(self, target: Target, camera: Camera, shift: tuple[float, float]) -> None:
        """There is nothing to mend."""

    def prepare_seen(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """The pairs carry all that the seen buffers need."""

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """What the rays see."""
        self._draw(render_pass, self._color)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The seen buffers."""
        self._draw(render_pass, self._seen)

    def _draw(self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline) -> None:
        render_pass.set_pipeline(pipeline)
        self._visibility.bind(render_pass)
        render_pass.set_bind_group(3, self._visibility.group)
        if self._bare:
            render_pass.draw(3)
            return
        for index in self.replaced:
            draw_mesh(render_pass, self._stage.buffers, index)

    def figures(self) -> dict[str, float]:
        """Nothing but what the frame shows."""
        return {}

    def rays(self) -> None:
        """Pixels' rays are on the device alone."""
        return None


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by trilinear projection."""
    stage = Stage(view)
    return DrawingSession(stage, TrilinearDrawing(stage, options))


METHOD = Method(
    name="trilinear",
    summary="every scene triangle projected through every ray triangle that sees it: exact curved edges",
    source="Vallance 2005",
    options=Options,
    open=open_session,
)
