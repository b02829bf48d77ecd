"""Environment mapping: what the reflected direction sees from the reflector's centre; the baseline that everyone uses.

Source: Blinn and Newell 1976; cube maps after Greene 1986. `mode=planar` is the other common way, for flat mirrors
alone: the scene drawn once more from the mirrored eye.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.drawing import draw_mesh, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS
from anamorph.methods.environment.cube_map import FACES, CubeMap, cube_layout
from anamorph.methods.options import check_options, option
from anamorph.methods.pervertex.options import Options as PerVertexOptions
from anamorph.methods.pervertex.pervertex import PerVertexDrawing
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.specular_drawing import SpecularDrawing
from anamorph.methods.stage import Stage
from anamorph.optics.ray_meshes import Body, bodies_of, rays_of
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Camera
from anamorph.scene.model import Glass

DEFAULT_FACE = 1024
"""Texels along an edge that a cube map takes at most by itself."""

PLANAR_BOUNCES = 2
"""How many mirrors a path may meet with planar reflection."""

MARGIN = np.radians(3.0)
"""How far the directions at normals between the vertices may stray beyond those at the vertices."""


@dataclass(frozen=True)
class Options:
    """Options of `environment`.

    Parameters
    ----------
    mode : str
        "cube", or "planar" for flat mirrors.
    update : str
        When the cube map is drawn: "always", or "once" (static).
    face : int
        Texels along an edge of the cube map; 0 takes one for each pixel of the image, up to 1024.
    antialias : int
        Samples a pixel of the image: 1 or 4.
    """

    mode: str = option("cube", choices=("cube", "planar"))
    update: str = option("always", choices=("always", "once"))
    face: int = option(0, low=0, high=4096, unit="texels")
    antialias: int = option(1, choices=(1, 4))


def face_size(rays: RayMesh) -> int:
    """Texels along an edge of a cube map that give each pixel of the image one, by the median over the mesh."""
    edges = np.concatenate([rays.faces[:, [0, 1]], rays.faces[:, [1, 2]]])
    edges = edges[((rays.status == RayStatus.OK) & (rays.image[:, 2] > 0.0))[edges].all(axis=1)]
    if not len(edges):
        return 64
    places = rays.places()
    pixels = np.linalg.norm(places[edges[:, 0]] - places[edges[:, 1]], axis=1)
    directions = rays.unit_directions()
    angles = np.linalg.norm(directions[edges[:, 0]] - directions[edges[:, 1]], axis=1)
    return int(np.clip(2.0 * np.median(pixels / np.maximum(angles, 1e-6)), 64, DEFAULT_FACE))


def faces_needed(rays: RayMesh) -> list[int]:
    """The faces of a cube map that the mesh's directions, and those between them, can meet."""
    directions = rays.unit_directions()
    edges = np.concatenate([rays.faces[:, [0, 1]], rays.faces[:, [1, 2]], rays.faces[:, [2, 0]]])
    spread = np.linalg.norm(directions[edges[:, 0]] - directions[edges[:, 1]], axis=1).max(initial=0.0)
    reach = np.pi / 4.0 + spread + MARGIN
    if reach >= np.pi / 2.0:
        return list(range(6))
    needed = []
    for face, axes in enumerate(np.array(FACES, float)):
        right, up, forward = np.abs(directions @ axes[0]), np.abs(directions @ axes[1]), directions @ axes[2]
        if (np.maximum(right, up) <= np.tan(reach) * forward).any():
            needed.append(face)
    return needed


class _CubeReflector:
    """One mirror, of one or more meshes, and the cube map around it."""

    def __init__(self, stage: Stage, body: Body, options: Options) -> None:
        self.indices, self._body = body.meshes, body
        (side,) = body.sides
        low, high = side.optics.positions.min(axis=0), side.optics.positions.max(axis=0)
        rays, owner = self.rays(stage.view.pinhole_camera, stage.view.size), stage.geometry.face_object[side.triangles]
        parts = (replace(rays, faces=rays.faces[owner == each]) for each in side.objects)
        size = options.face or max(face_size(part) for part in parts)
        self.map = CubeMap((low + high) / 2.0, size, near=1e-3 * float(np.linalg.norm(high - low)))

    def rays(self, camera: Camera, size: tuple[int, int]) -> RayMesh:
        """Its ray mesh."""
        return rays_of(self._body, camera.eye(size)).rays


class CubeDrawing(SpecularDrawing):
    """Draws every mirror of a scene by cube maps."""

    def __init__(self, stage: Stage, options: Options) -> None:
        super().__init__(stage)
        self._options = options
        bodies = bodies_of(stage.view.scene, stage.geometry)
        self._reflectors = [_CubeReflector(stage, body, options) for body in bodies]
        self._drawn = False
        module = shader_module("methods/environment/environment.wgsl")
        groups = (cube_layout(),)
        self._color = make_pipeline(
            module, "scene_vertex", "environment_color", (COLOR_FORMAT,),
            groups=groups, samples=options.antialias, cull="back",
        )  # fmt: skip
        self._seen = make_pipeline(module, "scene_vertex", "environment_seen", SEEN_FORMATS, groups=groups, cull="back")

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, shift: tuple[float, float]) -> None:
        """Draw each mirror's cube map, all of it once, or every time the faces that the frame needs."""
        if self._drawn and self._options.update == "once":
            return
        for item in self._reflectors:
            faces = set(range(6))
            if self._options.update == "always":
                faces = set(faces_needed(item.rays(camera, self.stage.view.size)))
            item.map.draw_color(encoder, self.stage.buffers, item.indices, sorted(faces))
        self._drawn = True

    def prepare_seen(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Draw what the cube maps see, for the seen buffers."""
        for item in self._reflectors:
            item.map.draw_depth(encoder, self.stage.buffers, item.indices)

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The mirrors, with their cube maps."""
        self._draw(render_pass, self._color, [item.map.group for item in self._reflectors])

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The mirrors' seen buffers."""
        self._draw(render_pass, self._seen, [item.map.seen_group for item in self._reflectors])

    def _draw(
        self,
        render_pass: wgpu.GPURenderPassEncoder,
        pipeline: wgpu.GPURenderPipeline,
        groups: Sequence[wgpu.GPUBindGroup],
    ) -> None:
        render_pass.set_pipeline(pipeline)
        for item, group in zip(self._reflectors, groups, strict=True):
            render_pass.set_bind_group(2, group)
            for index in item.indices:
                draw_mesh(render_pass, self.stage.buffers, index)

    def diagnostics(self) -> Mapping[str, Any]:
        """The cube map of each mirror."""
        return {"maps": [item.map for item in self._reflectors]}


def _check_flat(view: View) -> None:
    for mesh in view.scene.meshes:
        if not mesh.specular:
            continue
        offsets = np.asarray(mesh.positions, float) - mesh.positions.mean(axis=0)
        flatness = np.linalg.svd(offsets, compute_uv=False)[-1]
        if flatness > 1e-4 * np.linalg.norm(np.ptp(mesh.positions, axis=0)):
            raise AnamorphError(f"environment: mode=planar needs flat mirrors, {mesh.name!r} is curved; give mode=cube")


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by environment mapping."""
    check_options("environment", options)
    if options.mode == "planar":
        for name in ("update", "face"):
            if getattr(options, name) != getattr(Options, name):
                raise AnamorphError(f"environment: {name} is for cube maps; leave it out, or give mode=cube")
    glass = next((mesh.name for mesh in view.scene.meshes if isinstance(mesh.material, Glass)), None)
    if glass is not None:
        raise AnamorphError(f"environment: draws mirrors alone, and {glass!r} is glass; use pervertex or raytrace")
    stage = Stage(view)
    if options.mode == "planar":
        _check_flat(view)
        # The mirrored eye is the one point that all lines of a flat mirror share, and its image needs no warp but
        # the projective one that per-vertex reflection does.
        planar = PerVertexDrawing(stage, PerVertexOptions(antialias=options.antialias, bounces=PLANAR_BOUNCES))
        return Session(stage, planar, options.antialias)
    return Session(stage, CubeDrawing(stage, options), options.antialias)


METHOD = Method(
    name="environment",
    summary="a cube map from the reflector's centre, looked up by direction; or planar reflection",
    source="Blinn and Newell 1976; Greene 1986",
    options=Options,
    open=open_session,
)
