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

from typing import Any

import numpy as np
import wgpu

from anamorph.frame import View
from anamorph.gpu.bindings import bind, layout_of, texture
from anamorph.gpu.drawing import bind_scene, make_pipeline, shader_module
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS, Target, begin_pass, make_target
from anamorph.methods.protocol import Method, Session
from anamorph.methods.session import DrawingSession, Stage
from anamorph.methods.visibility import RAY_TRIANGLE, Visibility, data_layout, number_texture
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.projection import camera_projection
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry
from anamorph.trilinear.beams import Beams, make_beams
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
        self._colors = make_target(stage.view.size, (COLOR_FORMAT,), depth=self._visibility.depth)
        views, whole = layout_of(number_texture(), number_texture()), layout_of(texture())
        self._views = bind(views, self._visibility.views)
        self._whole = bind(whole, [self._colors.textures[0].create_view()])
        module = shader_module("gpu/vertices.wgsl", "methods/visibility.wgsl", "methods/trilinear.wgsl")
        kind, cull = ("bare", "none") if self._bare else ("surface", "back")

        def pipeline(vertex: str, fragment: str, formats: tuple[str, ...], **settings: Any) -> wgpu.GPURenderPipeline:
            groups = data_layout(), whole if vertex == "owner" else views
            entry = f"{kind}_{vertex}_vertex"
            return make_pipeline(module, entry, fragment, formats, buffers=(), groups=groups, cull=cull, **settings)

        def shaded(fragment: str, depth: str) -> wgpu.GPURenderPipeline:
            constants = {"BARE": int(self._bare), "GOES_ON": int(self._fronts.any()), "LEVEL": 1}
            settings = {"depth_compare": depth, "depth_write": False, "constants": constants}
            return pipeline("ray", fragment, (COLOR_FORMAT,), **settings)

        # What is not a pass's own is left by its depth, before its shader runs: software runs both sides of a branch.
        self._shaded = shaded("surface_color", "less"), shaded("surface_sky", "equal")
        self._composed = pipeline("owner", "composed_color", (COLOR_FORMAT,))
        self._seen = pipeline("ray", "surface_seen", SEEN_FORMATS)

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
        if not isinstance(camera, RayMesh):
            self._add_incident(triangles, beams, camera, shift)
        triangles["valid"], triangles["object"], triangles["face"] = 1, objects, np.maximum(own_face, 0)
        self._visibility.write(triangles, beams, plan, self._fronts)
        self._visibility.draw(encoder, self._stage.projection)
        render_pass = begin_pass(encoder, self._colors, keep_depth=True)
        bind_scene(render_pass, self._stage.buffers, self._stage.projection)
        for pipeline in self._shaded:
            self._draw(render_pass, pipeline, self._views)
        render_pass.end()

    def _add_incident(self, triangles: np.ndarray, beams: Beams, camera: Camera, shift: tuple[float, float]) -> None:
        """Tell the ray triangles how the eye looks at them."""
        width, height = self._stage.view.size
        looks = camera_projection(camera, (width, height), shift)
        x, y = 2.0 / width * looks.right, -2.0 / height * looks.up
        shown = beams.number
        triangles["incident_x"], triangles["incident_y"] = x, y
        start = looks.base - looks.right + looks.up
        triangles["incident_one"][shown] = start + beams.center[:, :1] * x + beams.center[:, 1:] * y

    def complete(self, target: Target, camera: Camera, shift: tuple[float, float]) -> None:
        """There is nothing to mend."""

    def prepare_seen(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """The pairs carry all that the seen buffers need."""

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """What the rays see, where it belongs in the picture."""
        self._draw(render_pass, self._composed, self._whole)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The seen buffers."""
        self._draw(render_pass, self._seen, self._views)

    def _draw(
        self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline, textures: wgpu.GPUBindGroup
    ) -> None:
        render_pass.set_pipeline(pipeline)
        self._visibility.bind(render_pass)
        render_pass.set_bind_group(3, textures)
        render_pass.draw(3 * self._visibility.count)

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
    ray_meshes=True,
)
