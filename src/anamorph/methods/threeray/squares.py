"""Points drawn as the paper draws them: projected by the cameras' cubics, as squares of one or two pixels.

What a camera may see is found on the processor. The device projects it, and draws each projection that is valid; of
several in one sample the one with the shortest way from the mirror stays. A sample without a point is a hole, and
shows the sky along its own ray.

Source: Mei, Popescu and Sacks 2007, sections 5 and 6. Deviation: cameras that may see a point more than once, by the
sweeping triangle, draw all of its projections.
"""

from __future__ import annotations

from collections.abc import Generator
from time import perf_counter

import numpy as np
import wgpu

from anamorph.frame import Status
from anamorph.gpu.bindings import STORAGE, bind, layout_of
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import Target, begin_pass, make_target, read_texture
from anamorph.gpu.visibility import TEXEL_FORMAT, VisibilityBuffer
from anamorph.methods.stage import Stage
from anamorph.methods.threeray.camera_bases import bases_of
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.points_seen import pairs_seen, stand_ins
from anamorph.methods.threeray.projector import BLOCK, SEVERAL, Projector
from anamorph.methods.threeray.sample_rays import Samples
from anamorph.methods.threeray.splat_records import OWNER, owner_records, point_records
from anamorph.methods.threeray.surfel_tree import SurfelTree
from anamorph.raytriangle.camera_frames import Frames, frames_of
from anamorph.raytriangle.sweeping import sees_once


@of_device
def _layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(*7 * [STORAGE], stages=wgpu.ShaderStage.VERTEX)


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
        Whether nodes of the tree that are less than a square wide are points.

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
        self._stage, self._visibility, self._materials = stage, visibility, materials
        self._wide = float(side * visibility.side) if detail else 0.0
        middle = np.asarray(stage.geometry.positions, float).mean(axis=0)
        self._projector = Projector(stage.buffers, len(tree.surfels), middle)
        width, height = visibility.size
        self._owners = storage_buffer(np.zeros(width * height, OWNER))
        self._group: wgpu.GPUBindGroup | None = None
        depth = make_target(visibility.size, ()).depth
        views = tuple(texture.create_view() for texture in visibility.textures[0])
        self._target = Target(visibility.size, visibility.textures[0], views, (None, None), depth, 1)
        self._instances = (side * visibility.side) ** 2
        self._pipelines = {
            roots: make_pipeline(
                shader_module("methods/threeray/squares.wgsl"), "square_vertex", "square_end",
                (TEXEL_FORMAT, TEXEL_FORMAT), buffers=(), groups=(_layout(),), topology="point-list",
                constants={"ROOTS": roots, "SIDE": side * visibility.side},
            )
            for roots in (1, SEVERAL)
        }  # fmt: skip
        self._work: dict[str, float] = {}
        self._samples = 0
        self.moved(tree)

    def moved(self, tree: SurfelTree) -> None:
        """Follow the points."""
        self._tree, self._stand_ins = tree, stand_ins(tree)
        face_object = self._stage.geometry.face_object
        self._projector.place(point_records(tree.surfels, face_object, self._materials, self._projector.middle))

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        cameras: Cameras,
        owning: np.ndarray,
        samples: Samples,
        projection: ProjectionUniform,
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Draw what cameras see over what the visibility buffer has, in steps.

        Parameters
        ----------
        encoder : encoder
            To record into; the one to go on with is returned.
        cameras : Cameras
        owning : (N,) int64
            Those that own samples. Of these, those draw that have rays.
        samples : Samples
        projection : ProjectionUniform
            The eye's, for an image whose pixels are samples.
        """
        rays = cameras.directions[owning].any(axis=(1, 2)) & ~cameras.traced[owning]
        chosen, frames, singles = self._ordered(cameras, owning[rays])
        bases, began = bases_of(cameras, chosen), perf_counter()
        pairs = yield from pairs_seen(frames, bases, self._tree.nodes, self._stand_ins, self._wide)
        culling = 1000.0 * (perf_counter() - began)
        shown = np.zeros(len(cameras.item), bool)
        shown[chosen] = True
        self._samples = int(np.count_nonzero(shown[samples.owner[samples.owner >= 0]]))
        self._work = {
            "cameras": len(chosen),
            "seeing_once_percent": 100.0 * singles / max(len(chosen), 1),
            "points": len(self._tree.surfels),
            "pairs": len(pairs),
            "culling_ms": culling,
        }
        if not len(pairs):
            return encoder
        if self._projector.look(cameras, chosen, self._materials) or self._group is None:
            self._group = bind(_layout(), [*self._projector.buffers, self._owners])
        get_device().queue.write_buffer(self._owners, 0, owner_records(cameras, samples, shown))
        split = int(np.searchsorted(pairs[:, 0], singles))
        first = True
        for roots, part in ((1, pairs[:split]), (SEVERAL, pairs[split:])):
            for start in range(0, len(part), BLOCK // roots):
                some = part[start : start + BLOCK // roots]
                self._projector.record(encoder, some, roots)
                self._record(encoder, roots, len(some), projection, first)
                encoder, first = self._stage.recorder.part(encoder), False
                yield
        return encoder

    def _ordered(self, cameras: Cameras, chosen: np.ndarray) -> tuple[np.ndarray, Frames, int]:
        """Cameras, those first that see every point once: their numbers, their frames, and how many of them do."""
        frames = frames_of(cameras.origins[chosen], cameras.directions[chosen])
        once = np.zeros(len(chosen), bool)
        if len(chosen) and len(self._tree.surfels):
            # No point is farther from an origin than the far corner of the box around all.
            far = np.linalg.norm(np.abs(frames.origin - self._tree.middle[0]) + self._tree.half[0], axis=1)
            slab = frames.reach[:, 2] > 0.0
            last = np.where(slab, (far + frames.size) / np.where(slab, frames.reach[:, 2], 1.0), 0.0)
            once = slab & sees_once(cameras.origins[chosen], cameras.directions[chosen], cameras.near[chosen], last)
        order = np.argsort(~once, kind="stable")
        return chosen[order], Frames(*(each[order] for each in frames)), int(np.count_nonzero(once))

    def _record(
        self, encoder: wgpu.GPUCommandEncoder, roots: int, count: int, projection: ProjectionUniform, first: bool
    ) -> None:
        """Draw what `count` pairs have."""
        render_pass = begin_pass(encoder, self._target, clear=first, keep_color=True)
        bind_scene(render_pass, self._stage.buffers, projection)
        render_pass.set_pipeline(self._pipelines[roots])
        render_pass.set_bind_group(2, self._group)
        render_pass.draw(roots * count, self._instances)
        render_pass.end()

    def figures(self) -> dict[str, float]:
        """Of the last frame: cameras, and which share of them sees each point once; points; pairs that were projected,
        and how long they were looked for; projections that were valid as a share of these, and pairs with several as a
        share of the projections; samples that got no point as a share of those that might, the sky's among them."""
        if not self._work:
            return {}
        valid, several = self._projector.counts()
        flags = read_texture(self._visibility.textures[0][1])[..., 2]
        holes = int(np.count_nonzero((flags >> 16) & 0xFF == Status.SKY))
        return self._work | {
            "valid_percent": 100.0 * valid / max(self._work["pairs"], 1),
            "several_percent": 100.0 * several / max(valid, 1),
            "holes_percent": 100.0 * holes / max(self._samples, 1),
        }
