"""Virtual objects: every triangle of the scene looks for where the eye sees it in mirrors and lenses.

Source: Estalella, Martin, Drettakis, Tost, Devillers and Cazals, "Accurate interactive specular reflections on curved
objects" (2005).
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from functools import partial

import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.own_ray import bind_exact
from anamorph.gpu.targets import Target
from anamorph.methods.finding import FindingDrawing
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.doubt import DoubtTracer
from anamorph.methods.tracing.paths import specular_rectangle
from anamorph.methods.virtual.grid_search import GridKind
from anamorph.methods.virtual.leaving_rays import LeavingRays
from anamorph.methods.virtual.meeting_rays import MeetingRays
from anamorph.methods.virtual.moving_scene import MovingScene
from anamorph.methods.virtual.virtual_meshes import VirtualMeshes
from anamorph.optics.exact_sides import exact_sides
from anamorph.optics.ray_meshes import bodies_of
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry


@dataclass(frozen=True)
class Options:
    """Options of `virtual`.

    Parameters
    ----------
    bounces : int
        How many specular interfaces a path may meet: a mirror is one, a lens is two. From the second mirror or lens on
        it is traced.
    antialias : int
        Samples a pixel: 1 or 4.
    search : str
        "tiles": triangles look for the tiles of samples whose own rays may meet them. "cubemap": vertices look for
        their one reflection point on each mirror, which is convex or concave and closed, as the paper has it; lenses
        are traced.
    iterations : int
        Steps of the search on cube maps.
    start : str
        Where that search starts. "bisector": as the paper has it, whatever was drawn before. "last": from what it found
        for the last frame, so that fewer steps suffice while little moves.
    face : int
        Texels along each side of the cube maps' faces.
    grid : str
        With the paper's search, which vertices are searched for. "none": all. "regular": the corners of a grid around
        each mesh, between which its vertices are interpolated. "adaptive": grids that divide themselves until that is
        right to half a pixel.
    share : float
        The cells of a regular grid, as a share of its mesh's vertices.
    """

    bounces: int = option(8, low=1, high=255)
    antialias: int = option(1, choices=(1, 4))
    search: str = option("tiles", choices=("tiles", "cubemap"))
    iterations: int = option(9, low=0, high=1000)
    start: str = option("bisector", choices=("bisector", "last"))
    face: int = option(128, low=4, high=1024)
    grid: str = option("none", choices=("none", "regular", "adaptive"))
    share: float = option(0.096, low=1e-6, high=1.0)


class VirtualDrawing(FindingDrawing):
    """Finds for each triangle of the scene where mirrors and lenses show it."""

    def __init__(self, stage: Stage, options: Options) -> None:
        scene, geometry = stage.view.scene, stage.geometry
        bodies = bodies_of(scene, geometry)
        refracts = {mesh for body in bodies for side in body.sides if side.refracts for mesh in side.meshes}
        disperses = {mesh for body in bodies for side in body.sides if side.disperses for mesh in side.meshes}
        super().__init__(stage, 3 if disperses else 1, options.antialias)
        sides = exact_sides(scene, geometry, bodies)
        meshes: dict[int, dict[str, float]] = {
            mesh: {
                "LENS": int(mesh in refracts),
                "SURFACE": int(sides.kinds[mesh, 0]),
                "FAR_SURFACE": int(sides.kinds[mesh, 1]),
                "MOST_BOUNCES": options.bounces,
            }
            for body in bodies
            for mesh in body.meshes
        }
        dispersing = {mesh: constants for mesh, constants in meshes.items() if mesh in disperses}
        self._meshes = [meshes, dispersing, dispersing]
        exact, size = bind_exact(sides), self.visibility.size
        self._moving = MovingScene(scene, geometry)
        self._lines = []
        for line in range(len(self.visibility.textures)):
            leaving = LeavingRays(stage.buffers, exact, size, line)
            self._lines.append((leaving, MeetingRays(stage, leaving, *self._moving.buffers, size)))
        self._objects: VirtualMeshes | None = None
        if options.search == "cubemap":
            kind = GridKind(options.grid, options.share, options.iterations, options.start == "last")
            self._objects = VirtualMeshes(stage, bodies, self._lines[0][0], size, options.face, kind)
        self._caster = Caster(geometry)
        self._doubt = DoubtTracer(stage, self.visibility, self._caster, options.bounces)
        # What was looked at when rays left, and when they met what stands still.
        self._left: tuple[Camera, tuple[float, float]] | None = None
        self._kept = False

    @property
    def replaced(self) -> tuple[int, ...]:
        """All mirrors and lenses."""
        return tuple(self._meshes[0])

    def deformed(self, geometry: Geometry) -> None:
        """Have the next frame look for the triangles that have moved."""
        self._caster.moved(geometry.positions)
        self._doubt.moved(geometry)
        if self._objects is not None:
            self._objects.moved(geometry)
        others = self._moving.moved(geometry)
        self._kept = self._kept and not others

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, shift: tuple[float, float]) -> None:
        """Set the projection."""
        self.look(camera, shift)
        rectangle = specular_rectangle(self.stage.view.scene, camera, self.stage.view.size)
        self.visibility.show(rectangle, len(self._lines))

    def find(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Camera, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """Find what each sample sees, in steps; what cannot be found so is traced."""
        if self.visibility.rectangle is None:
            return None
        find = self._finding if self._objects is None else self._drawing
        return find(encoder, target, camera, shift)

    def _drawing(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Camera, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Draw virtual objects of the vertices that the paper's search finds."""
        assert self._objects is not None
        self._lines[0][0].leave(encoder, self.projection, self._meshes[0])
        depth = self.depth_of(encoder, target)
        self._objects.draw(encoder, self.projection, camera, self.visibility, depth)
        return (yield from self._doubt.tracing(encoder, depth, self.projection, camera, shift))

    def _finding(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Camera, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        assert self.visibility.rectangle is not None
        side, recorder = self.visibility.side, self.stage.recorder
        x0, y0, x1, y1 = (side * end for end in self.visibility.rectangle)
        moves = len(self._moving.moving.order) > 0
        leaves = self._left != (camera, shift)
        keeps = moves and (leaves or not self._kept)
        # If it is closed at a step, the next frame begins again.
        self._left, self._kept = None, False
        for (leaving, meeting), meshes in zip(self._lines, self._meshes, strict=False):
            if leaves:
                leaving.leave(encoder, self.projection, meshes)
                encoder = yield from leaving.bounding(encoder, recorder, (x0, y0, x1, y1))
            if keeps:
                yield from meeting.keeping(encoder, self.projection, self._moving.still, (x0, y0, x1, y1))
        self._left, self._kept = (camera, shift), moves
        depth = self.depth_of(encoder, target)
        triangles = self._moving.moving if moves else self._moving.still
        for line, (_, meeting) in enumerate(self._lines):
            yield from meeting.ending(encoder, self.projection, triangles, self.visibility, depth, line, moves)
        return (yield from self._doubt.tracing(encoder, depth, self.projection, camera, shift))

    def figures(self) -> dict[str, float]:
        """How many triangles tiles were asked of or points searched for, and how many samples were traced."""
        traced = {"traced": float(self._doubt.traced)}
        if self._objects is not None:
            return {"searches": float(self._objects.searches), **traced}
        return {"asked": float(sum(meeting.asked for _, meeting in self._lines)), **traced}


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by virtual objects."""
    check_options("virtual", options)
    for name in ("iterations", "start", "face", "grid", "share"):
        if options.search != "cubemap" and getattr(options, name) != getattr(Options, name):
            raise AnamorphError(f"virtual: {name} is for the paper's search; leave it out, or give search=cubemap")
    if options.grid == "adaptive" and options.start == "last":
        raise AnamorphError(
            "virtual: adaptive grids are divided anew for each eye; leave start out, or give another grid"
        )
    if options.grid != "regular" and options.share != Options.share:
        raise AnamorphError("virtual: share is for regular grids; leave it out, or give grid=regular")
    stage = Stage(view)
    middles = partial(open_session, view, replace(options, antialias=1))
    return Session(stage, VirtualDrawing(stage, options), options.antialias, middles)


METHOD = Method(
    name="virtual",
    summary="every triangle of the scene looks for where mirrors and lenses show it",
    source="Estalella et al. 2005",
    options=Options,
    open=open_session,
    refracts=True,
)
