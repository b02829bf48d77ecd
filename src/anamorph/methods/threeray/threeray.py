"""Three-ray cameras: reflections found backward, by what a camera may see, and forward, by what its pixels' rays meet.

Source: Mei, Popescu and Sacks, "A hybrid backward-forward method for interactive reflections" (2007). Every triangle of
a mirror, a lens or a ray mesh is a camera of three rays. It finds in a tree the surfels that it may see, and these are
met by the rays of its pixels. No ray is cast but where a path goes on from one mirror or lens to another.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.targets import Target
from anamorph.gpu.visibility import Rectangle
from anamorph.methods.finding import FindingDrawing
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.stage import Stage
from anamorph.methods.threeray.background import (
    Background,
    are_near,
    body_center,
    least_distances,
    make_background,
    show_behind,
)
from anamorph.methods.threeray.camera_records import records_of
from anamorph.methods.threeray.cameras_seen import Cameras, body_cameras, mesh_cameras
from anamorph.methods.threeray.hiding import Hiding
from anamorph.methods.threeray.meeting import meet
from anamorph.methods.threeray.objects import materials_of
from anamorph.methods.threeray.sample_rays import Samples, interpolate
from anamorph.methods.threeray.scene_triangles import triangles_of
from anamorph.methods.threeray.squares import Squares
from anamorph.methods.threeray.surfel_tree import make_tree
from anamorph.methods.threeray.surfels import Limit, Surfels, about, evenly, magnified, sample
from anamorph.methods.tracing.bounces import DIFFUSE
from anamorph.methods.tracing.launch import EyeRays, FirstRays, GivenRays
from anamorph.methods.tracing.packing import packed
from anamorph.methods.tracing.paths import PathTracer, specular_rectangle
from anamorph.optics.ray_meshes import Line, bodies_of
from anamorph.projection import camera_projection
from anamorph.raymesh import RayMesh
from anamorph.rays.caster import Caster
from anamorph.raytriangle.owners import Places, owners_of, places_of
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

RED_AND_BLUE: tuple[Line, Line] = (0, 2)

POINTS = 100_000
"""Points that are drawn as squares, unless a spacing is given."""

LEAST_RADIUS = 1e-3
"""Of a surfel beside the mirrors, as a share of the scene's size, where the mirrors' own triangles are not larger."""


@dataclass(frozen=True)
class Options:
    """Options of `threeray`.

    Parameters
    ----------
    spacing : float
        The radius of all surfels, metres; 0 takes for each what the mirrors can magnify, and with `splat` one radius
        that makes about 100,000 of them.
    bounces : int
        How many specular interfaces a path may meet: a mirror is one, a lens is two. From the second mirror or lens on
        it is traced; with `splat` it ends at the second.
    antialias : int
        Samples a pixel: 1 or 4.
    dispersion : bool
        Whether red and blue light goes its own way through glass that has an Abbe number; with `splat` it never does.
    splat : int
        0 has pixels' rays meet surfels. 1 and 2 project the surfels' centres and draw them as squares of as many pixels
        a side, as the paper does: samples that get none are holes, and show the sky.
    detail : bool
        Whether, with `splat`, what is less than a pixel wide is one point.
    background : str
        "scene": all of it is seen by the cameras; "map": what is far from a mirror or lens is drawn behind what is near
        by an environment map from its middle.
    near : float
        With a map, how far from the middle the cameras see, metres; 0 takes what keeps the map within half a pixel in
        the session's first view.
    culling : str
        How it is told what of the tree a camera may see: by linear bounds, or by the side walls of what its rays fill,
        as in the paper.
    """

    spacing: float = option(0.0, low=0.0, unit="metres")
    bounces: int = option(8, low=1, high=255)
    antialias: int = option(1, choices=(1, 4))
    dispersion: bool = True
    splat: int = option(0, choices=(0, 1, 2))
    detail: bool = True
    background: str = option("scene", choices=("scene", "map"))
    near: float = option(0.0, low=0.0, unit="metres")
    culling: str = option("bounds", choices=("bounds", "walls"))


class ThreeRayDrawing(FindingDrawing):
    """Finds what an image's three-ray cameras see."""

    def __init__(self, stage: Stage, options: Options) -> None:
        self._bare = not stage.has_pinhole
        self._bodies = () if self._bare else bodies_of(stage.view.scene, stage.geometry)
        disperses = options.dispersion and not options.splat
        self._disperses = disperses and any(side.disperses for body in self._bodies for side in body.sides)
        super().__init__(stage, 3 if self._disperses else 1, options.antialias)
        self._options, self._materials = options, materials_of(stage.view.scene)
        self._samples = Samples.reserved(self.visibility.size)
        corners = self._corners()
        surfels = sample(corners, self._limit(corners))
        self._background: Background | None = None
        if options.background == "map":
            surfels, self._background = self._divided(surfels)
        self._tree = make_tree(surfels, stage.geometry.face_object, points=options.splat > 0)
        self._triangles = triangles_of(corners, stage.geometry.face_object)
        self._hiding = Hiding(self.visibility)
        self._squares: Squares | None = None
        if options.splat:
            self._squares = Squares(stage, self.visibility, self._materials, self._tree, options.splat, options.detail)
        self._work = Counter[str]()

    def _corners(self) -> np.ndarray:
        return np.asarray(self.stage.geometry.positions, float)[self.stage.geometry.faces]

    def _limit(self, corners: np.ndarray) -> Limit:
        if self._options.spacing > 0.0:
            return evenly(corners, self._options.spacing)
        if self._options.splat:
            return about(corners, POINTS)
        camera = self.stage.view.camera
        if isinstance(camera, RayMesh):
            starts = np.asarray(camera.origins, float)[camera.faces]
        else:
            sides = [side for body in self._bodies for side in body.sides]
            starts = np.concatenate(
                [np.zeros((0, 3, 3)), *(side.optics.positions[side.optics.faces] for side in sides)]
            )
        if not len(starts) or not len(corners):
            return lambda center: np.full(len(center), np.inf)
        edges = np.linalg.norm(starts - np.roll(starts, 1, axis=1), axis=2)
        extent = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
        return magnified(np.unique(starts.reshape(-1, 3), axis=0), max(float(edges.mean()), LEAST_RADIUS * extent))

    def _divided(self, surfels: Surfels) -> tuple[Surfels, Background]:
        """The surfels that are near, and a map of the triangles of the others."""
        camera, geometry = self.stage.view.camera, self.stage.geometry
        body = np.zeros(len(self.stage.view.scene.meshes) + 1, np.int64)
        if isinstance(camera, RayMesh):
            centers = [np.asarray(camera.origins, float).mean(axis=0)]
        else:
            centers = [body_center(each) for each in self._bodies]
            for number, each in enumerate(self._bodies):
                body[np.asarray(each.meshes, int) + 1] = number
        center = np.array(centers, float).reshape(-1, 3)
        distances = np.full(len(center), self._options.near)
        if self._options.near == 0.0 and len(center):
            cameras, _, owning = self._looked_at(camera, (0.0, 0.0))
            distances = least_distances(cameras, owning, center, body)
        # The way of light goes on from mirrors and lenses, which no map knows; and it starts inside of its own.
        specular = self._materials.kind[geometry.face_object[surfels.triangle]] != DIFFUSE
        near = specular | are_near(surfels, center, distances)
        far = np.zeros(len(geometry.faces), bool)
        far[surfels.triangle[~near]] = True
        return surfels.chosen(np.flatnonzero(near)), make_background(geometry, far, center, distances, body)

    @cached_property
    def _tracer(self) -> tuple[Caster, PathTracer]:
        """What traces paths that go on, made when the first does."""
        stage, caster = self.stage, Caster(self.stage.geometry)
        truth = "surface" if self._bare else "raymesh"
        return caster, PathTracer(stage.view.scene, stage.geometry, caster, self._options.bounces, truth)

    @property
    def replaced(self) -> tuple[int, ...]:
        """The mirrors and lenses; a ray mesh replaces none."""
        return tuple(mesh for body in self._bodies for mesh in body.meshes)

    def deformed(self, geometry: Geometry) -> None:
        """Fit the boxes of the tree to what has moved."""
        corners = self._corners()
        self._tree, self._triangles = self._tree.moved(corners), triangles_of(corners, geometry.face_object)
        if self._squares is not None:
            self._squares.moved(self._tree)
        if self._background is not None:
            self._background = self._background.moved(geometry)
        if "_tracer" in self.__dict__:
            caster, tracer = self._tracer
            caster.moved(geometry.positions)
            tracer.moved(geometry)

    def prepare(
        self, encoder: wgpu.GPUCommandEncoder, camera: Camera | RayMesh, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Find what each sample's ray meets, in steps, and upload where the paths end."""
        self.visibility.show(None)
        self._work.clear()
        side = self.visibility.side
        rectangle: Rectangle = (0, 0, *self.visibility.size)
        if isinstance(camera, RayMesh):
            self.looked = camera, shift
        else:
            self.look(camera, shift)
            seen = specular_rectangle(self.stage.view.scene, camera, self.stage.view.size)
            if seen is None:
                return encoder
            rectangle = side * seen[0], side * seen[1], side * seen[2], side * seen[3]
        cameras, places, owning = self._looked_at(camera, shift)
        yield from self._find(camera, cameras, places, owning, rectangle, shift)
        if self._squares is not None:
            encoder = yield from self._squares.draw(encoder, cameras, owning, self._samples, self.projection)
        x0, y0, x1, y1 = (end // side for end in rectangle)
        self.visibility.show((x0, y0, x1, y1), 3 if self._disperses else 1)
        return encoder

    def _looked_at(self, camera: Camera | RayMesh, shift: tuple[float, float]) -> tuple[Cameras, Places, np.ndarray]:
        """The cameras of an image, where they are, and the numbers of those that own samples, which know it then."""
        size, bare = self.visibility.size, isinstance(camera, RayMesh)
        if isinstance(camera, RayMesh):
            cameras = mesh_cameras(camera, self.visibility.side, shift)
        else:
            cameras = self._body_cameras(camera, shift, 1)
        places = places_of(cameras.image, size)
        if not bare:
            # From behind, a lens is not looked at: its other side is.
            places.box[~places.front & (cameras.bounces > 1)] = 0
        fronts = None if bare else places.front
        return cameras, places, owners_of(places, size, fronts, self._samples.depth, self._samples.owner)

    def _body_cameras(self, camera: Camera, shift: tuple[float, float], line: Line) -> Cameras:
        eye = camera.eye(self.stage.view.size)
        return body_cameras(self._bodies, self.stage.geometry, eye, self.visibility.side, shift, line)

    def _find(
        self,
        camera: Camera | RayMesh,
        cameras: Cameras,
        places: Places,
        owning: np.ndarray,
        rectangle: Rectangle,
        shift: tuple[float, float],
    ) -> Generator[None, None, None]:
        """Fill the rectangle of all lines."""
        x0, y0, x1, y1 = rectangle
        records, going = yield from self._records(camera, cameras, places, owning, rectangle)
        lines = [records]
        if self._disperses and isinstance(camera, Camera):
            meshes = self.stage.view.scene.meshes
            spreads = np.array([False, *(getattr(mesh.material, "abbe", None) is not None for mesh in meshes)])
            spreading = owning[spreads[cameras.item[owning]]]
            for line in RED_AND_BLUE:
                own = self._body_cameras(camera, shift, line)
                lines.append((yield from self._records(camera, own, places, spreading, rectangle))[0])
        ends = [packed(line) for line in lines]
        if len(going):
            yield from self._trace(camera, records, going, rectangle, shift, ends)
        for number, texels in enumerate(ends):
            self.visibility.write(rectangle, texels.reshape(2, y1 - y0, x1 - x0, 4), number)

    def _records(
        self, camera: Camera | RayMesh, cameras: Cameras, places: Places, chosen: np.ndarray, rectangle: Rectangle
    ) -> Generator[None, None, tuple[np.ndarray, np.ndarray]]:
        """What the samples of the chosen cameras meet: records and which of them go on, as `records_of` has them."""
        shown = np.zeros(len(places.box), bool)
        shown[chosen] = True
        samples, materials = self._samples, self._materials
        if self._squares is None:
            work = yield from meet(
                cameras, places, self._tree, self._triangles, materials, samples, shown, rectangle,
                self._options.culling,
            )  # fmt: skip
            self._work.update(work)
        else:
            interpolate(cameras, places, samples, rectangle)
        eye = np.asarray(camera.position) if isinstance(camera, Camera) else None
        records, going = records_of(
            cameras, places, self._triangles, materials, samples, rectangle, eye, self._options.bounces, shown
        )
        if self._background is not None:
            going = show_behind(self._background, samples, rectangle, records, going)
        return records, going

    def _trace(
        self,
        camera: Camera | RayMesh,
        records: np.ndarray,
        going: np.ndarray,
        rectangle: Rectangle,
        shift: tuple[float, float],
        ends: list[np.ndarray],
    ) -> Generator[None, None, None]:
        """Put the ends of paths that go on in their places among `ends`."""
        x0, y0, x1, _ = rectangle
        side = self.visibility.side
        rays: FirstRays
        if isinstance(camera, Camera):
            row, column = np.divmod(going, x1 - x0)
            pixels = np.stack([x0 + column, y0 + row], axis=1)
            rays = EyeRays(camera, self.visibility.size, pixels, (1, 1), (side * shift[0], side * shift[1]))
        else:
            rays = GivenRays(records[going, :3].astype(float), records[going, 4:7].astype(float))
        _, tracer = self._tracer
        traced = yield from tracer.tracing(rays)
        ends[0][:, going] = packed(traced)
        if len(ends) > 1:
            spread = traced.view(np.uint32)
            for texels, line in zip(ends[1:], (yield from tracer.tracing_colors(rays, traced)), strict=True):
                texels[:, going] = 0
                texels[:, going[spread[:, 14] > 0]] = packed(line)

    def find(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Camera | RayMesh, shift: tuple[float, float]
    ) -> None:
        """Empty the samples before whose mirror or lens something stands."""
        if isinstance(camera, Camera) and self.visibility.rectangle is not None:
            side, nearest = self.visibility.side, self.depth_of(encoder, target)
            x0, y0, x1, y1 = (side * end for end in self.visibility.rectangle)
            # The projection's depth is this number over the depth in metres.
            near = camera_projection(camera, self.stage.view.size).clip[2, 3]
            depth = near * self._samples.depth
            self._hiding.draw(encoder, nearest, depth, (x0, y0, x1, y1), self.projection, self.stage.buffers)

    def figures(self) -> dict[str, float]:
        """What finding the last frame took: its cameras, those of them that looked, and `meeting.WORK`.

        Over all lines of light; what was traced is not counted. With `splat`, what `Squares` tells.
        """
        return dict(self._work) if self._squares is None else self._squares.figures()

    def diagnostics(self) -> Mapping[str, Any]:
        """The tree over the surfels."""
        return {"tree": self._tree}


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by three-ray cameras."""
    check_options("threeray", options)
    if options.near > 0.0 and options.background == "scene":
        raise AnamorphError("threeray: near is for a map behind; leave it out, or give background=map")
    if options.splat and options.culling == "walls":
        raise AnamorphError("threeray: culling is for surfels that rays meet; leave it out, or give splat=0")
    if not options.splat and not options.detail:
        raise AnamorphError("threeray: detail is for points; leave it out, or give splat=1 or splat=2")
    stage = Stage(view)
    middles = partial(open_session, view, replace(options, antialias=1))
    return Session(stage, ThreeRayDrawing(stage, options), options.antialias, middles)


METHOD = Method(
    name="threeray",
    summary="the surfels that each triangle of a mirror may see, met by the rays of its own pixels",
    source="Mei, Popescu and Sacks 2007",
    options=Options,
    open=open_session,
    refracts=True,
    ray_meshes=True,
)
