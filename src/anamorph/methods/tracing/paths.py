"""The reference's light paths: a ray for every pixel, or given rays, bent at every mirror and glass that they meet."""

from __future__ import annotations

import threading
from collections.abc import Generator

import numpy as np

from anamorph.base.compiled import steps_over_all_cores
from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.frame import Status
from anamorph.methods.tracing.bounces import DIFFUSE, GLASS, MIRROR, NO_RAYS, WORDS, Paths, VertexRays, World, advance
from anamorph.methods.tracing.launch import FirstRays, GivenRays, Rectangle
from anamorph.methods.tracing.vertex_rays import vertex_rays
from anamorph.optics.dispersion import line_indices
from anamorph.optics.ray_meshes import Line, bodies_of
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry
from anamorph.scene.lens_pairs import lens_pairs
from anamorph.scene.model import Glass, Mirror, Scene
from anamorph.surfaces.intersection import pack

GRAIN = 8192

Tracing = Generator[None, None, np.ndarray]
"""Paths that are traced in steps; returns their records."""


class PathTracer:
    """Traces the light paths of an image's pixels, on all the cores.

    Parameters
    ----------
    scene : Scene
    geometry : Geometry
        Of that scene.
    caster : Caster
        Over that geometry.
    max_bounces : int
        Bounces after which a path ends where it is.
    truth : str
        "surface": rays bend at the exact surface, or at the interpolated normal of a mesh that has none.
        "raymesh": the first bounce sends on the interpolated ray of the ray mesh of the mirror, or of the lens, which
        leaves its far face; later ones are as above. Where a corner's ray does not leave the lens there, because it is
        reflected totally or meets the edge, the first bounce is as above, too.

    Attributes
    ----------
    disperses : bool
        Whether some glass of the scene sends colours different ways.
    """

    def __init__(
        self, scene: Scene, geometry: Geometry, caster: Caster, max_bounces: int = 8, truth: str = "surface"
    ) -> None:
        if truth not in ("surface", "raymesh"):
            raise AnamorphError(f"truth is {truth!r}; choose surface or raymesh")
        if not 0 <= max_bounces <= 255:
            raise AnamorphError(f"max_bounces is {max_bounces}; choose 0 to 255")
        self._caster = caster
        self._worlds = _worlds(scene, geometry, max_bounces)
        self.disperses = bool(self._worlds[1].disperses.any())
        self._geometry = geometry
        self._bodies = bodies_of(scene, geometry) if truth == "raymesh" else None
        self._thread = threading.local()

    def moved(self, geometry: Geometry) -> None:
        """Follow the scene's vertices to where they are in `geometry`; its caster has followed already."""
        self._worlds = [
            world._replace(positions=geometry.positions, normals=geometry.normals) for world in self._worlds
        ]

    def tracing(self, first: FirstRays, records: np.ndarray | None = None) -> Tracing:
        """Trace one path for every ray, in steps.

        Parameters
        ----------
        first : EyeRays or GivenRays
            Mirrors bend given rays at their surface in either truth.
        records : (N, 16) float32, optional
            To be filled again, instead of a new array.

        Returns
        -------
        records : (N, 16) float32
            64 bytes a ray:

            ======= ==========================================================================================
            0:3     origin of the path's last ray, metres
            3       triangle at the path's end (int32 bits), -1 for the sky
            4:7     unit direction of the last ray
            7       flags (uint32 bits): the first specular object in bits 0-15 (0: none), the `Status` in
                    bits 16-23, the number of bounces in bits 24-31
            8:11    throughput: what share of the light at the path's end arrives, by colour
            11      distance along the last ray, metres; infinite for the sky
            12:14   weights of the end triangle's second and third vertex
            14      1 (uint32 bits) where the path has met glass that disperses, else 0; see `tracing_colors`
            15      zero
            ======= ==========================================================================================

            Status is OUTSIDE where the bounce limit ended the path (on the specular triangle it had reached), else
            TOTAL_REFLECTION where some reflection was total, else SKY, DIRECT (no bounce) or TRACED. Where there is no
            ray, it is OUTSIDE, and origin, direction and throughput are zero.

            Light is that of the d line: what glass that disperses does to green.
        """
        return self._tracing(self._worlds[1], first, self._vertex_rays(first, 1), records)

    def tracing_colors(self, first: FirstRays, records: np.ndarray, start: int = 0) -> Tracing:
        """Trace red and blue light, of the C and F lines, for the rays whose path has met glass that disperses.

        Parameters
        ----------
        first : EyeRays or GivenRays
        records : (N, 16) float32
            What `tracing` returned for some of them. Word 14 is set to the row of the ray's paths in the result,
            counted from 1.
        start : int
            The number of the ray whose record is the first.

        Returns
        -------
        colors : (2, rays that disperse, 16) float32
            Records of red light, then of blue, in the order of `records`.
        """
        words = records.view(np.uint32)
        numbers = np.flatnonzero(words[:, 14]) if self.disperses else np.zeros(0, np.int64)
        words[numbers, 14] = np.arange(1, len(numbers) + 1)
        colors = np.empty((2, len(numbers), WORDS), np.float32)
        lines: tuple[Line, Line] = (0, 2)
        for line, own in zip(lines, colors, strict=True):
            rays = self._vertex_rays(first, line)
            yield from self._tracing(self._worlds[line], first.chosen(start + numbers), rays, own)
        return colors

    def follow(self, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Trace one path, and tell of each of its rays.

        Parameters
        ----------
        origin, direction : (3,) float64

        Returns
        -------
        records : (S, 16) float32
            As in `tracing`, of the path ended after 0, 1, ... bounces: row i has the ray after i bounces and what it
            meets; the last row is the whole path's.
        """
        first, rows = GivenRays(np.atleast_2d(origin), np.atleast_2d(direction)), []
        for bounces in range(self._worlds[1].max_bounces + 1):
            world = self._worlds[1]._replace(max_bounces=bounces)
            rows.append(drain(self._tracing(world, first, NO_RAYS, None)))
            if rows[-1].view(np.uint32)[0, 7] >> 16 & 0xFF != Status.OUTSIDE:
                break
        return np.concatenate(rows)

    def _tracing(self, world: World, first_rays: FirstRays, rays: VertexRays, records: np.ndarray | None) -> Tracing:
        """Trace paths; `rays` are those of the ray meshes that the first bounce sends on."""
        count, launch = len(first_rays), first_rays.launch()
        if records is None or records.shape != (count, WORDS):
            records = np.empty((count, WORDS), np.float32)
        words = records.view(np.uint32)

        def work(first: int, stop: int) -> None:
            paths, turn, bending = self._reserved(), 0, rays
            own, own_words = records[first:stop], words[first:stop]
            going = launch(paths, first, stop - first, own, own_words)
            while going:
                # Rays of neighbouring pixels keep together until the second bounce.
                self._cast(paths, going, coherent=turn < 2)
                going = advance(world, paths, going, bending, own, own_words)
                bending = NO_RAYS
                turn += 1

        yield from steps_over_all_cores(work, count, GRAIN)
        return records

    def _reserved(self) -> Paths:
        """The calling thread's own arrays."""
        if not hasattr(self._thread, "paths"):
            self._thread.paths = Paths.reserved(GRAIN)
        return self._thread.paths

    def _cast(self, paths: Paths, count: int, coherent: bool) -> None:
        self._caster.fill(
            paths.origin[:count], paths.direction[:count], paths.near[:count], coherent,
            paths.distance[:count], paths.triangle[:count], paths.barycentric[:count],
        )  # fmt: skip

    def _vertex_rays(self, first: FirstRays, line: Line) -> VertexRays:
        """The rays of the ray meshes as the eye sees them; none for surface truth, and for given rays."""
        if self._bodies is None or isinstance(first, GivenRays):
            return NO_RAYS
        return vertex_rays(self._bodies, self._geometry, first.camera.eye(first.size), line)


def _worlds(scene: Scene, geometry: Geometry, max_bounces: int) -> list[World]:
    """The scene for red, green and blue light."""
    count = len(scene.meshes) + 1
    material, surface = np.full((2, count), DIFFUSE, np.int64)
    tint, constant = np.ones((count, 3)), np.zeros((3, count))
    numbers = [np.zeros(0)] * count
    parameters = np.zeros((len(geometry.positions), 2))
    for number, mesh in enumerate(scene.meshes, start=1):
        match mesh.material:
            case Mirror(tint=color, reflectance=value):
                material[number], tint[number], constant[:, number] = MIRROR, color, value
            case Glass(tint=color, index=value, abbe=abbe):
                material[number], tint[number], constant[:, number] = GLASS, color, line_indices(value, abbe)
        if mesh.specular and mesh.parameters is not None:
            surface[number], numbers[number] = pack(mesh.surface)
            parameters[geometry.first_vertex[number - 1] : geometry.first_vertex[number]] = mesh.parameters
    world = World(
        geometry.positions, geometry.normals, parameters, geometry.faces, geometry.face_object,
        material, tint, constant[1], constant[0] != constant[2], surface,
        np.concatenate(numbers), np.cumsum([0, *map(len, numbers)]), _lenses(scene), max_bounces,
    )  # fmt: skip
    return [world._replace(constant=line) for line in constant]


def _lenses(scene: Scene) -> np.ndarray:
    """The number of the lens that each object belongs to, (objects + 1,) int64: of those that an edge closes."""
    numbers = np.zeros(len(scene.meshes) + 1, np.int64)
    for number, lens in enumerate(lens_pairs(scene.meshes), start=1):
        if lens.edge is not None:
            numbers[[lens.front + 1, lens.back + 1, lens.edge + 1]] = number
    return numbers


def specular_rectangle(scene: Scene, camera: Camera, size: tuple[int, int]) -> Rectangle | None:
    """The part of the image outside which no pixel looks at a specular mesh.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    size : (width, height)

    Returns
    -------
    (x0, y0, x1, y1) or None
        Pixels, the ends left out, a pixel wider than the meshes on each side; the whole image where one of them
        reaches the plane of the eye; None where none is in the image.
    """
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for mesh in scene.meshes:
        if not mesh.specular or not len(mesh.positions):
            continue
        image = camera.image(mesh.positions, size)
        depth = image[:, 2]
        if depth.max() <= 0.0:
            continue
        if depth.min() <= 1e-6 * depth.max():
            return 0, 0, *size
        places = image[:, :2] / depth[:, None]
        low, high = np.minimum(low, places.min(axis=0)), np.maximum(high, places.max(axis=0))
    # Clipped first, because a vertex close to the plane of the eye projects beyond any integer.
    x0, y0 = (int(value) for value in np.floor(np.clip(low - 1.0, 0, size)))
    x1, y1 = (int(value) for value in np.ceil(np.clip(high + 1.0, 0, size)))
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None
