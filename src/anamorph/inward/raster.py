"""What converging rays see, drawn by raster: each pixel's own ray meets what its place in the views shows.

Source: Vallance and Calder, "Inward looking projections" (2003), sections 4 and 6. Deviation: views hold triangles and
not colours, and are looked up by each pixel's own ray instead of being textures of a mesh; so a picture is as sharp as
its pixels, and right but at silhouettes. Mirrors and glass, of which the paper knows nothing, are seen by tracing.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import Status, View
from anamorph.gpu.bindings import STORAGE, bind, layout_of
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import begin_depth_pass, make_target, read_texture
from anamorph.gpu.visibility import TEXEL_FORMAT
from anamorph.inward.converging import Converging, converging
from anamorph.inward.field_maps import FieldMaps
from anamorph.inward.field_views import field_views
from anamorph.methods.finding import FindingDrawing
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.specification import Specification
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.launch import GivenRays
from anamorph.methods.tracing.packing import packed
from anamorph.methods.tracing.paths import PathTracer
from anamorph.projection import Projection
from anamorph.raymesh import RayMesh
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import Geometry

RAY_CORNER = np.dtype({"names": ["place", "arrow"], "formats": ["3f4", "3f4"], "offsets": [0, 16], "itemsize": 32})
LOOKUP = np.dtype(
    {"names": ["x", "y", "ahead"], "formats": ["3f4", "3f4", "3f4"], "offsets": [0, 16, 32], "itemsize": 48}
)
"""As looked_up_along.wgsl reads them."""


@dataclass(frozen=True)
class Options:
    """Options of `INWARD`.

    Parameters
    ----------
    far : bool
        Whether rays go on beyond the point of convergence, where all is seen reversed (4.2).
    texels : int
        Across each view; 0 takes one for each pixel.
    traced : bool
        Whether what is doubtful is traced: where a ray does not meet what its place in the views shows.
    antialias : int
        Samples a pixel: 1 or 4.
    """

    far: bool = True
    texels: int = option(0, low=0, high=8192, unit="texels")
    traced: bool = False
    antialias: int = option(1, choices=(1, 4))


@of_device
def _lookup_layout() -> wgpu.GPUBindGroupLayout:
    stages = wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
    fields = {"texture": {"view_dimension": "2d-array", "sample_type": "uint"}}
    return layout_of(STORAGE, STORAGE, STORAGE, STORAGE, fields, stages=stages)


class InwardDrawing(FindingDrawing):
    """Finds what converging rays see."""

    def __init__(self, stage: Stage, options: Options) -> None:
        super().__init__(stage, 1, options.antialias)
        self._options = options
        specular = stage.buffers.specular_meshes[stage.geometry.face_object - 1]
        self._specular = np.append(False, specular)
        self._caster = Caster(stage.geometry) if specular.any() or options.traced else None
        self._covered = make_target(self.visibility.size, ())
        self._own = ProjectionUniform()
        self._maps: FieldMaps | None = None
        self._pipeline = make_pipeline(
            shader_module("inward/looked_up_along.wgsl"),
            "ray_vertex",
            "looked_up_along",
            (TEXEL_FORMAT, TEXEL_FORMAT),
            buffers=(),
            groups=(_lookup_layout(),),
        )

    def deformed(self, geometry: Geometry) -> None:
        """Refit the tree, where there is one."""
        if self._caster is not None:
            self._caster.moved(geometry.positions)

    def prepare(
        self, encoder: wgpu.GPUCommandEncoder, camera: RayMesh, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Draw the views, and look each sample up in them."""
        if self.looked is None or self.looked[0] is not camera or self.looked[1] != shift:
            self._look(camera, shift)
        self.looked = camera, shift
        assert self._maps is not None
        self._maps.draw(encoder)
        begin_depth_pass(encoder, self._covered).end()
        render_pass = self.visibility.begin(encoder, self._covered.depth)
        bind_scene(render_pass, self.stage.buffers, self._own)
        render_pass.set_pipeline(self._pipeline)
        render_pass.set_bind_group(2, self._group)
        render_pass.draw(3 * self._faces)
        render_pass.end()
        self.visibility.show((0, 0, *self.stage.view.size))
        if self._caster is not None:
            encoder = self.stage.recorder.part(encoder)
            yield from self._trace(self._caster)
        return encoder

    def _look(self, camera: RayMesh, shift: tuple[float, float]) -> None:
        """Plan the views, and upload the rays."""
        rays, side = converging(camera), self.visibility.side
        places = (rays.places - rays.places[..., 2:] * [*shift, 0.0]) * [side, side, 1.0]
        rays = Converging(rays.point, places, rays.arrows)
        views = field_views(rays, self.visibility.size, self._options.texels)
        self._maps = FieldMaps(self.stage.buffers, rays, views, self._options.far)
        right, up, ahead = np.eye(3)
        self._own.write(Projection(np.eye(4), ahead, right, up, rays.point), self.visibility.size)
        corners = np.zeros(3 * len(places), RAY_CORNER)
        corners["place"], corners["arrow"] = places.reshape(-1, 3), rays.arrows.reshape(-1, 3)
        lookups = np.zeros(len(views), LOOKUP)
        lookups["x"], lookups["y"], lookups["ahead"] = np.swapaxes([view.lookup() for view in views], 0, 1)
        self._faces = len(places)
        self._group = bind(
            _lookup_layout(),
            [
                self.stage.buffers.vertices,
                self.stage.buffers.indices,
                storage_buffer(corners),
                storage_buffer(lookups),
                self._maps.texture.create_view(dimension="2d-array"),
            ],
        )

    def _trace(self, caster: Caster) -> Generator[None, None, None]:
        """Trace on what meets a mirror or a lens, and what is doubtful where that is wanted."""
        texels = np.stack([read_texture(texture) for texture in self.visibility.textures[0]])
        traced = self._specular[texels[0, ..., 3]]
        if self._options.traced:
            traced |= (texels[1, ..., 2] >> 16) & 0xFF == Status.DOUBTFUL
        if not traced.any():
            return
        _, origins, directions = self.visibility.rays()
        tracer = PathTracer(self.stage.view.scene, self.stage.geometry, caster)
        records = yield from tracer.tracing(GivenRays(origins[traced].astype(float), directions[traced].astype(float)))
        texels[:, traced] = packed(records)
        self.visibility.write((0, 0, *self.visibility.size), texels)


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view`, whose camera is a ray mesh of rays that converge."""
    check_options("inward", options)
    if not isinstance(view.camera, RayMesh):
        raise AnamorphError("inward: sees through ray meshes alone; give one, as cameras.anti_perspective makes it")
    stage = Stage(view)
    middles = partial(open_session, view, replace(options, antialias=1))
    return Session(stage, InwardDrawing(stage, options), options.antialias, middles)


METHOD = Method(
    name="inward",
    summary="near and far field of rays that converge, drawn by raster in one depth buffer",
    source="Vallance and Calder 2003",
    options=Options,
    open=open_session,
    refracts=True,
    ray_meshes=True,
)

INWARD = Specification(METHOD, Options())
"""The method, to be given to `render`; its options beside it."""
