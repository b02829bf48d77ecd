"""Drawing: pipelines over shading.wgsl and scene.wgsl, and the passes that every method shares."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.bindings import UNIFORM, bind, layout_of
from anamorph.gpu.buffers import VERTEX_LAYOUT, SceneBuffers, shading_layout
from anamorph.gpu.device import get_device, of_device, once
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, DEPTH_FORMAT, MAP_FORMATS, SEEN_FORMATS
from anamorph.projection import UNIFORM_BYTES, Projection


@of_device
def projection_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 1: one projection."""
    return layout_of(UNIFORM, stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT)


class ProjectionUniform:
    """A projection on the device, at first unset: group 1."""

    def __init__(self) -> None:
        usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self.buffer = get_device().create_buffer(size=UNIFORM_BYTES, usage=usage)
        self.group = bind(projection_layout(), [self.buffer])

    def write(self, projection: Projection, size: tuple[int, int]) -> None:
        """Set it for an image of `size`."""
        get_device().queue.write_buffer(self.buffer, 0, projection.uniform(size))


def make_pipeline(
    module: wgpu.GPUShaderModule,
    vertex: str,
    fragment: str | None,
    formats: Sequence[str],
    *,
    buffers: Sequence[dict] = (VERTEX_LAYOUT,),
    groups: Sequence[wgpu.GPUBindGroupLayout] = (),
    samples: int = 1,
    depth_compare: str = "greater",
    depth_write: bool = True,
    topology: str = "triangle-list",
    write_mask: int = wgpu.ColorWrite.ALL,
    cull: str = "none",
    mirrored: bool = False,
    constants: dict[str, float] | None = None,
) -> wgpu.GPURenderPipeline:
    """A pipeline that binds shading, projection, and then `groups`; `constants` set the shader's overrides.

    Without a `fragment` it is for passes of depth alone. It is compiled once: a session that is opened anew for another
    scene finds what the one before it has left.
    """
    layouts = [shading_layout(), projection_layout(), *groups]
    stage = {"constants": constants or {}}
    description: dict[str, dict[str, Any]] = {
        "vertex": {"entry_point": vertex, "buffers": list(buffers), **stage},
        "primitive": {"topology": topology, "cull_mode": cull, "front_face": "cw" if mirrored else "ccw"},
        "depth_stencil": {"format": DEPTH_FORMAT, "depth_write_enabled": depth_write, "depth_compare": depth_compare},
        "multisample": {"count": samples},
    }
    if fragment is not None:
        targets = [{"format": form, "write_mask": write_mask} for form in formats]
        description["fragment"] = {"entry_point": fragment, **stage, "targets": targets}

    def make() -> wgpu.GPURenderPipeline:
        layout = get_device().create_pipeline_layout(bind_group_layouts=layouts)
        stages = {name: {"module": module, **description[name]} for name in {"vertex", "fragment"} & set(description)}
        return get_device().create_render_pipeline(layout=layout, **(description | stages))

    return once(("pipeline", str(description), module, *layouts), make)


@dataclass(frozen=True, eq=False)
class ScenePipelines:
    """The scene for one kind of output.

    Parameters
    ----------
    depth, meshes : pipelines
        Diffuse meshes: their depth, in a pass of its own, and then what is nearest, so that each pixel is shaded once.
    plain : pipeline
        The same as `meshes` for those without a texture.
    back_depth, backs : pipelines
        The same of the backs of mirrors, which are diffuse.
    stand_ins : pipeline
        Fronts of mirrors that no method draws.
    sky : pipeline
    """

    depth: wgpu.GPURenderPipeline
    meshes: wgpu.GPURenderPipeline
    plain: wgpu.GPURenderPipeline
    back_depth: wgpu.GPURenderPipeline
    backs: wgpu.GPURenderPipeline
    stand_ins: wgpu.GPURenderPipeline
    sky: wgpu.GPURenderPipeline


OUTPUTS: dict[str, tuple[str, ...]] = {
    "color": (COLOR_FORMAT,),
    "depth": MAP_FORMATS,
    "end": MAP_FORMATS,
    "seen": SEEN_FORMATS,
}
"""What can be drawn, and the targets that it takes; fragment functions are called after it.

Of a frame, shaded colour, and the seen buffers. Of a map, depth with its slopes, from which the map's reader finds the
seen point; and the point and the object at the end of a path."""


@of_device
def scene_pipelines(output: str, samples: int = 1, mirrored: bool = False, sky_image: bool = True) -> ScenePipelines:
    """The scene for one of `OUTPUTS`; `mirrored` for projections whose images are left-handed, as a cube map's are.

    Without a `sky_image` they draw only scenes whose sky is a gradient, and that faster.
    """
    module = shader_module("gpu/scene.wgsl")

    def pipeline(vertex: str, shown: str, textures: bool = True, **settings: Any) -> wgpu.GPURenderPipeline:
        constants: dict[str, float] = {"SKY_IMAGE": int(sky_image), "TEXTURES": int(textures)}
        return make_pipeline(
            module, vertex, f"{shown}_{output}", OUTPUTS[output],
            samples=samples, mirrored=mirrored, constants=constants, **settings,
        )  # fmt: skip

    def depth_pipeline(cull: str) -> wgpu.GPURenderPipeline:
        return make_pipeline(module, "depth_vertex", None, (), samples=samples, mirrored=mirrored, cull=cull)

    return ScenePipelines(
        depth=depth_pipeline("none"),
        meshes=pipeline("scene_vertex", "scene", depth_compare="equal", depth_write=False),
        plain=pipeline("scene_vertex", "scene", textures=False, depth_compare="equal", depth_write=False),
        back_depth=depth_pipeline("front"),
        backs=pipeline("scene_vertex", "scene", textures=False, cull="front", depth_compare="equal", depth_write=False),
        stand_ins=pipeline("scene_vertex", "stand_in", cull="back"),
        sky=pipeline("sky_vertex", "far_sky", buffers=(), depth_compare="greater-equal", depth_write=False),
    )


def bind_scene(render_pass: wgpu.GPURenderPassEncoder, buffers: SceneBuffers, projection: ProjectionUniform) -> None:
    """Bind shading and projection: groups 0 and 1."""
    render_pass.set_bind_group(0, buffers.shading)
    render_pass.set_bind_group(1, projection.group)


def draw_depth(
    render_pass: wgpu.GPURenderPassEncoder,
    pipelines: ScenePipelines,
    buffers: SceneBuffers,
    projection: ProjectionUniform,
    visible: np.ndarray | None = None,
    extra: Callable[[wgpu.GPURenderPassEncoder], None] | None = None,
) -> None:
    """Draw the depth of all that is diffuse, in a pass without colours. The parameters are those of `draw_scene`."""
    bind_scene(render_pass, buffers, projection)
    if extra is not None:
        extra(render_pass)
    render_pass.set_vertex_buffer(0, buffers.vertices)
    render_pass.set_index_buffer(buffers.indices, "uint32")
    present = _present(buffers, visible)
    _draw_ranges(render_pass, pipelines.depth, buffers, runs(present & ~buffers.specular_meshes))
    _draw_ranges(render_pass, pipelines.back_depth, buffers, _mirrors(buffers, present))


def _mirrors(buffers: SceneBuffers, present: np.ndarray) -> list[tuple[int, int]]:
    return [(index, index + 1) for index in buffers.mirrors if present[index]]


def _present(buffers: SceneBuffers, visible: np.ndarray | None) -> np.ndarray:
    return np.ones(len(buffers.first_face) - 1, bool) if visible is None else visible


def draw_scene(
    render_pass: wgpu.GPURenderPassEncoder,
    pipelines: ScenePipelines,
    buffers: SceneBuffers,
    projection: ProjectionUniform,
    replaced: Sequence[int] = (),
    visible: np.ndarray | None = None,
    sky: bool = True,
    extra: Callable[[wgpu.GPURenderPassEncoder], None] | None = None,
) -> None:
    """Draw the diffuse meshes, the mirrors, then the sky. Glass is left to the methods that bend light at it.

    Parameters
    ----------
    render_pass, pipelines, buffers, projection
        The pass keeps the depth that `draw_depth` has left.
    replaced : sequence of int
        The mirrors whose fronts a method draws itself.
    visible : (meshes,) bool, optional
        The meshes that may be in the image.
    sky : bool
        Whether to draw it.
    extra : callable, optional
        Draws before all others, so that nothing behind it is shaded.
    """
    bind_scene(render_pass, buffers, projection)
    if extra is not None:
        extra(render_pass)
    render_pass.set_vertex_buffer(0, buffers.vertices)
    render_pass.set_index_buffer(buffers.indices, "uint32")
    present = _present(buffers, visible)
    diffuse = present & ~buffers.specular_meshes
    _draw_ranges(render_pass, pipelines.meshes, buffers, runs(diffuse & buffers.textured))
    _draw_ranges(render_pass, pipelines.plain, buffers, runs(diffuse & ~buffers.textured))
    mirrors = _mirrors(buffers, present)
    _draw_ranges(render_pass, pipelines.backs, buffers, mirrors)
    _draw_ranges(render_pass, pipelines.stand_ins, buffers, [each for each in mirrors if each[0] not in replaced])
    if sky:
        render_pass.set_pipeline(pipelines.sky)
        render_pass.draw(3)


def draw_mesh(render_pass: wgpu.GPURenderPassEncoder, buffers: SceneBuffers, index: int) -> None:
    """Draw mesh `index` with the current pipeline."""
    start, end = int(buffers.first_face[index]), int(buffers.first_face[index + 1])
    render_pass.set_vertex_buffer(0, buffers.vertices)
    render_pass.set_index_buffer(buffers.indices, "uint32")
    render_pass.draw_indexed(3 * (end - start), 1, 3 * start)


def _draw_ranges(
    render_pass: wgpu.GPURenderPassEncoder,
    pipeline: wgpu.GPURenderPipeline,
    buffers: SceneBuffers,
    ranges: Sequence[tuple[int, int]],
) -> None:
    if ranges:
        render_pass.set_pipeline(pipeline)
    for first, last in ranges:
        start, end = int(buffers.first_face[first]), int(buffers.first_face[last])
        render_pass.draw_indexed(3 * (end - start), 1, 3 * start)


def runs(chosen: np.ndarray) -> list[tuple[int, int]]:
    """The runs, first to last (exclusive), of the numbers that are `chosen`."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def submit(encoder: wgpu.GPUCommandEncoder) -> None:
    """Send recorded passes to the device."""
    get_device().queue.submit([encoder.finish()])


@of_device
def _token() -> wgpu.GPUBuffer:
    return get_device().create_buffer(size=4, usage=wgpu.BufferUsage.COPY_SRC | wgpu.BufferUsage.COPY_DST)


def wait() -> None:
    """Return when the device has finished all that was submitted."""
    # Reading four bytes waits for all earlier work; wgpu 0.32's own call for this raises TypeError.
    get_device().queue.read_buffer(_token())
