"""Points drawn as the paper draws them: projected by the cameras' cubics, as squares of one or two pixels.

What a camera may see is found on the processor. The device projects it, and draws each projection that is valid; of
several in one sample the one with the shortest way from the mirror stays. A sample without a point is a hole, and
shows the sky along its own ray.

Source: Mei, Popescu and Sacks 2007, sections 5 and 6. Deviation: cameras that may see a point more than once, by the
sweeping triangle, draw all of its projections.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import Status
from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of
from anamorph.gpu.buffers import grown_buffer, storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import Target, begin_pass, make_target, read_texture
from anamorph.gpu.visibility import TEXEL_FORMAT, VisibilityBuffer
from anamorph.methods.stage import Stage
from anamorph.raytriangle.camera_frames import Frames, frames_of
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.points_seen import areas_of, pairs_seen, point_tree
from anamorph.methods.threeray.sample_rays import Samples
from anamorph.methods.threeray.splat_records import (
    OWNER,
    POINT,
    PROJECTED,
    camera_records,
    owner_records,
    point_records,
)
from anamorph.methods.threeray.surfel_tree import SurfelTree
from anamorph.raytriangle.on_device import packed_rays
from anamorph.raytriangle.scaled import scaled_rays
from anamorph.raytriangle.sweeping import sees_once

WORKGROUP = 64

BLOCK = 2**16
"""Projections that the device is given space for at once: it projects a few million pairs in a second."""

SEVERAL = 3
"""Projections that a point can have in one camera."""


@of_device
def _ray_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(UNIFORM, STORAGE, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _pair_layout() -> wgpu.GPUBindGroupLayout:
    written = {"buffer": {"type": "storage"}}
    return layout_of(*5 * [STORAGE], written, written, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _square_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(*7 * [STORAGE], stages=wgpu.ShaderStage.VERTEX)


@of_device
def _projecting(roots: int) -> wgpu.GPUComputePipeline:
    layout = get_device().create_pipeline_layout(bind_group_layouts=[_ray_layout(), _pair_layout()])
    module = shader_module("methods/threeray/projected.wgsl")
    stage = {"module": module, "entry_point": "project_pairs", "constants": {"ROOTS": roots}}
    return get_device().create_compute_pipeline(layout=layout, compute=stage)


class Squares:
    """Draws the points that an image's cameras see.

    Parameters
    ----------
    stage : Stage
    visibility : VisibilityBuffer
        What is drawn into.
    materials : Materials
    tree : SurfelTree
        Its surfels' centres are the points.
    side : int
        Of a square, pixels.
    detail : bool
        Whether nodes of the tree that are less than a pixel wide are points.

    Raises
    ------
    AnamorphError
        The device has no space for so many points.
    """

    def __init__(
        self,
        stage: Stage,
        visibility: VisibilityBuffer,
        materials: Materials,
        tree: SurfelTree,
        side: int,
        detail: bool,
    ) -> None:
        self._stage, self._visibility, self._materials, self._detail = stage, visibility, materials, detail
        most = get_device().limits["max-storage-buffer-binding-size"] // POINT.itemsize
        if len(tree.surfels) > most:
            raise AnamorphError(
                f"threeray: splat draws at most {most} points on this device, and there are {len(tree.surfels)}; "
                "give a larger spacing"
            )
        self._middle = np.asarray(stage.geometry.positions, float).mean(axis=0) if len(tree.surfels) else np.zeros(3)
        width, height = visibility.size
        usage = wgpu.BufferUsage.COPY_SRC
        self._zeros = get_device().create_buffer(size=16, usage=wgpu.BufferUsage.UNIFORM)
        self._points = storage_buffer(np.zeros(max(len(tree.surfels), 1), POINT))
        self._pairs = storage_buffer(np.zeros((BLOCK, 2), np.uint32))
        self._projected = storage_buffer(np.zeros(BLOCK, PROJECTED))
        self._owners = storage_buffer(np.zeros(width * height, OWNER))
        self._counts = storage_buffer(np.zeros(3, np.uint32), usage)
        self._held: list[wgpu.GPUBuffer | None] = [None, None]
        self._groups: list[wgpu.GPUBindGroup] = []
        depth = make_target(visibility.size, ()).depth
        views = tuple(texture.create_view() for texture in visibility.textures[0])
        self._target = Target(visibility.size, visibility.textures[0], views, (None, None), depth, 1)
        self._instances = (side * visibility.side) ** 2
        self._pipelines = {
            roots: make_pipeline(
                shader_module("methods/threeray/squares.wgsl"), "square_vertex", "square_end",
                (TEXEL_FORMAT, TEXEL_FORMAT), buffers=(), groups=(_square_layout(),), topology="point-list",
                constants={"ROOTS": roots, "SIDE": side * visibility.side},
            )
            for roots in (1, SEVERAL)
        }  # fmt: skip
        self._work: dict[str, float] = {}
        self._samples = 0
        self.moved(tree)

    def moved(self, tree: SurfelTree) -> None:
        """Follow the points."""
        self._tree = point_tree(tree)
        face_object = self._stage.geometry.face_object
        records = point_records(tree.surfels, face_object, self._materials, self._middle)
        if len(records):
            get_device().queue.write_buffer(self._points, 0, records)

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        cameras: Cameras,
        chosen: np.ndarray,
        samples: Samples,
        projection: ProjectionUniform,
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Draw what the chosen cameras see over what the visibility buffer has, in steps.

        Parameters
        ----------
        encoder : encoder
            To record into; the one to go on with is returned.
        cameras : Cameras
        chosen : (N,) int64
            Those that own samples and have rays.
        samples : Samples
        projection : ProjectionUniform
            The eye's, for an image whose pixels are samples.
        """
        frames = frames_of(cameras.origins[chosen], cameras.directions[chosen])
        once = self._see_once(cameras, chosen, frames)
        # Those that see each point once come first, so that their pairs do.
        order = np.argsort(~once, kind="stable")
        chosen, frames = chosen[order], Frames(*(each[order] for each in frames))
        singles = int(np.count_nonzero(once))
        areas = areas_of(cameras.image[chosen])
        pairs = yield from pairs_seen(frames, self._tree, areas, self._detail)
        shown = np.zeros(len(cameras.item), bool)
        shown[chosen] = True
        self._samples = int(np.count_nonzero(shown[samples.owner[samples.owner >= 0]]))
        self._work = {"cameras": len(chosen), "points": len(self._tree.center), "pairs": len(pairs)}
        self._work["seeing_once_percent"] = 100.0 * singles / max(len(chosen), 1)
        queue = get_device().queue
        queue.write_buffer(self._counts, 0, np.zeros(3, np.uint32))
        if not len(pairs):
            return encoder
        self._upload(camera_records(cameras, chosen, self._materials), cameras, chosen)
        queue.write_buffer(self._owners, 0, owner_records(cameras, samples, shown))
        split = int(np.searchsorted(pairs[:, 0], singles))
        first = True
        for roots, part in ((1, pairs[:split]), (SEVERAL, pairs[split:])):
            for start in range(0, len(part), BLOCK // roots):
                some = part[start : start + BLOCK // roots]
                queue.write_buffer(self._pairs, 0, np.ascontiguousarray(some))
                queue.write_buffer(self._counts, 8, np.array([len(some)], np.uint32))
                self._record(encoder, roots, len(some), projection, first)
                encoder, first = self._stage.recorder.part(encoder), False
                yield
        return encoder

    def _see_once(self, cameras: Cameras, chosen: np.ndarray, frames: Frames) -> np.ndarray:
        """Which of the chosen cameras see every point once, (N,) bool."""
        if not len(chosen) or not len(self._tree.center):
            return np.ones(len(chosen), bool)
        # From the origin, no point is farther than the far corner of the box around all.
        far = np.abs(frames.origin - self._tree.middle[0]) + self._tree.half[0]
        wide = frames.reach[:, 2] <= 0.0
        with np.errstate(divide="ignore"):
            reach = np.linalg.norm(far, axis=1) + frames.size
            last = np.where(wide, 0.0, reach / np.where(wide, 1.0, frames.reach[:, 2]))
        return ~wide & sees_once(cameras.origins[chosen], cameras.directions[chosen], cameras.near[chosen], last)

    def _upload(self, records: np.ndarray, cameras: Cameras, chosen: np.ndarray) -> None:
        """Give the device the cameras, and their rays for the cubics."""
        rays = packed_rays(scaled_rays(cameras.origins[chosen], cameras.directions[chosen]), self._middle)
        contents = [rays, records]
        held = [grown_buffer(buffer, data.nbytes) for buffer, data in zip(self._held, contents, strict=True)]
        if held != self._held:
            self._held = list(held)
            scene = [self._stage.buffers.vertices, self._stage.buffers.indices]
            shared = [*scene, held[1], self._points, self._pairs, self._projected]
            self._groups = [
                bind(_ray_layout(), [self._zeros, held[0]]),
                bind(_pair_layout(), [*shared, self._counts]),
                bind(_square_layout(), [*shared, self._owners]),
            ]
        for buffer, data in zip(held, contents, strict=True):
            get_device().queue.write_buffer(buffer, 0, data)

    def _record(
        self, encoder: wgpu.GPUCommandEncoder, roots: int, count: int, projection: ProjectionUniform, first: bool
    ) -> None:
        """Project `count` pairs, and draw what they have."""
        compute_pass = encoder.begin_compute_pass()
        compute_pass.set_pipeline(_projecting(roots))
        for number in range(2):
            compute_pass.set_bind_group(number, self._groups[number])
        compute_pass.dispatch_workgroups(-(-count // WORKGROUP))
        compute_pass.end()
        render_pass = begin_pass(encoder, self._target, clear=first, keep_color=True)
        bind_scene(render_pass, self._stage.buffers, projection)
        render_pass.set_pipeline(self._pipelines[roots])
        render_pass.set_bind_group(2, self._groups[2])
        render_pass.draw(roots * count, self._instances)
        render_pass.end()

    def figures(self) -> dict[str, float]:
        """Of the last frame: cameras, and which share of them sees each point once; points; pairs that were projected,
        projections that were valid as a share of these, and pairs with several as a share of those with any; samples
        that got no point as a share of those that might, the sky's among them."""
        if not self._work:
            return {}
        valid, several, _ = np.frombuffer(get_device().queue.read_buffer(self._counts), np.uint32).tolist()
        flags = read_texture(self._visibility.textures[0][1])[..., 2]
        holes = int(np.count_nonzero((flags >> 16) & 0xFF == Status.SKY))
        return self._work | {
            "valid_percent": 100.0 * valid / max(self._work["pairs"], 1),
            "several_percent": 100.0 * several / max(valid, 1),
            "holes_percent": 100.0 * holes / max(self._samples, 1),
        }
