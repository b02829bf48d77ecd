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
from anamorph.methods.tracing.launch import Launch, along_rays, from_eye
from anamorph.methods.tracing.vertex_rays import vertex_rays
from anamorph.optics.dispersion import line_indices
from anamorph.optics.ray_meshes import Line, bodies_of
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry
from anamorph.scene.model import Glass, Mirror, Scene
from anamorph.surfaces.intersection import pack

Rectangle = tuple[int, int, int, int]

GRAIN = 8192

Tracing = Generator[None, None, np.ndarray]
"""Paths that are traced in steps; returns their records."""


class PathTracer:
    """Traces the light paths of a picture's pixels, on all the cores.

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
        self._red, self._green, self._blue = _worlds(scene, geometry, caster.near, max_bounces)
        self.disperses = bool(self._green.disperses.any())
        self._geometry = geometry
        self._bodies = bodies_of(scene, geometry) if truth == "raymesh" else None
        self._thread = threading.local()

    def moved(self, geometry: Geometry) -> None:
        """Follow the scene's vertices to where they are in `geometry`; its caster has followed already."""
        self._red, self._green, self._blue = (
            world._replace(positions=geometry.positions, normals=geometry.normals, near=self._caster.near)
            for world in (self._red, self._green, self._blue)
        )

    def tracing(
        self,
        camera: Camera,
        size: tuple[int, int],
        rectangle: Rectangle | None = None,
        shift: tuple[float, float] = (0.0, 0.0),
        records: np.ndarray | None = None,
    ) -> Tracing:
        """Trace one path for every pixel of a part of the picture, in steps.

        Parameters
        ----------
        camera : Camera
        size : (width, height)
            Of the whole picture.
        rectangle : (x0, y0, x1, y1), optional
            The part, in pixels, its ends left out; the whole picture by default.
        shift : (right, down)
            Moves the rays from the pixels' centres, in pixels.
        records : (pixels, 16) float32, optional
            To be filled again, instead of a new array.

        Returns
        -------
        records : (pixels, 16) float32
            64 bytes a pixel, row by row:

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
            TOTAL_REFLECTION where some reflection was total, else SKY, DIRECT (no bounce) or TRACED.

            Light is that of the d line: what glass that disperses does to green.
        """
        x0, y0, x1, y1 = rectangle or (0, 0, *size)
        tile = max(x1 - x0, 0), max(y1 - y0, 0)
        return self.tracing_tiles(camera, size, np.array([[x0, y0]]), tile, shift, records)

    def tracing_tiles(
        self,
        camera: Camera,
        size: tuple[int, int],
        corners: np.ndarray,
        tile: tuple[int, int],
        shift: tuple[float, float] = (0.0, 0.0),
        records: np.ndarray | None = None,
    ) -> Tracing:
        """Trace one path for every pixel of tiles of the picture, tile by tile, each row by row; see `tracing`.

        Parameters
        ----------
        camera, size, shift, records
            As in `tracing`.
        corners : (T, 2) int
            The first column and row of each tile.
        tile : (columns, rows)
            The size of all tiles.
        """
        launch = from_eye(camera, size, corners, tile, shift)
        rays = self._vertex_rays(camera, size, 1)
        return self._tracing(self._green, launch, len(corners) * tile[0] * tile[1], rays, records)

    def tracing_rays(self, origins: np.ndarray, directions: np.ndarray, records: np.ndarray | None = None) -> Tracing:
        """Trace one path along each given ray; see `tracing`.

        Parameters
        ----------
        origins, directions : (N, 3) float64
            Directions may have any length; one of (0, 0, 0) is no ray. What lies at the origin itself is met: there
            is no near plane but the place where a ray begins. Mirrors bend the rays at their surface in either truth.
        records
            As in `tracing`.

        Returns
        -------
        records : (N, 16) float32
            Where there is no ray, the status is OUTSIDE, and origin, direction and throughput are zero.
        """
        return self._tracing(self._green, along_rays(origins, directions), len(origins), NO_RAYS, records)

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
        launch, rows = along_rays(np.atleast_2d(origin), np.atleast_2d(direction)), []
        for bounces in range(self._green.max_bounces + 1):
            world = self._green._replace(max_bounces=bounces)
            rows.append(drain(self._tracing(world, launch, 1, NO_RAYS, None)))
            if rows[-1].view(np.uint32)[0, 7] >> 16 & 0xFF != Status.OUTSIDE:
                break
        return np.concatenate(rows)

    def tracing_colors(
        self,
        camera: Camera,
        size: tuple[int, int],
        corners: np.ndarray,
        tile: tuple[int, int],
        shift: tuple[float, float],
        records: np.ndarray,
    ) -> Tracing:
        """Trace red and blue light, of the C and F lines, for the pixels whose path has met glass that disperses.

        Parameters
        ----------
        camera, size, corners, tile, shift
            As for `tracing_tiles`.
        records : (pixels, 16) float32
            What `tracing_tiles` returned. Word 14 is set to the row of the pixel's paths in the result, counted from 1.

        Returns
        -------
        colors : (2, pixels that disperse, 16) float32
            Records of red light, then of blue, in the order of `records`.
        """
        numbers = self._numbered(records)
        columns, rows = tile
        number, place = np.divmod(numbers, columns * rows)
        row, column = np.divmod(place, columns)
        pixels = np.asarray(corners)[number] + np.stack([column, row], axis=-1)
        launch = from_eye(camera, size, pixels, (1, 1), shift)
        return self._tracing_lines(
            launch, len(numbers), self._vertex_rays(camera, size, 0), self._vertex_rays(camera, size, 2)
        )

    def tracing_ray_colors(self, origins: np.ndarray, directions: np.ndarray, records: np.ndarray) -> Tracing:
        """The same for the `origins` and `directions` for which `tracing_rays` returned `records`."""
        numbers = self._numbered(records)
        return self._tracing_lines(along_rays(origins[numbers], directions[numbers]), len(numbers), NO_RAYS, NO_RAYS)

    def _numbered(self, records: np.ndarray) -> np.ndarray:
        """The rows of paths that disperse, counted from 1 in their word 14."""
        words = records.view(np.uint32)
        numbers = np.flatnonzero(words[:, 14]) if self.disperses else np.zeros(0, np.int64)
        words[numbers, 14] = np.arange(1, len(numbers) + 1)
        return numbers

    def _tracing_lines(self, launch: Launch, count: int, red: VertexRays, blue: VertexRays) -> Tracing:
        """Red and blue light of `count` paths, (2, count, 16)."""
        colors = np.empty((2, count, WORDS), np.float32)
        for world, rays, own in zip((self._red, self._blue), (red, blue), colors, strict=True):
            yield from self._tracing(world, launch, count, rays, own)
        return colors

    def _tracing(
        self,
        world: World,
        launch: Launch,
        count: int,
        rays: VertexRays,
        records: np.ndarray | None,
    ) -> Tracing:
        """Trace `count` paths; `rays` are those of the ray meshes that the first bounce sends on."""
        if records is None or records.shape != (count, WORDS):
            records = np.empty((count, WORDS), np.float32)
        words = records.view(np.uint32)

        def work(first: int, stop: int) -> None:
            paths, turn, bending = self._room(), 0, rays
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

    def _room(self) -> Paths:
        """The calling thread's own arrays."""
        if not hasattr(self._thread, "paths"):
            self._thread.paths = Paths.room(GRAIN)
        return self._thread.paths

    def _cast(self, paths: Paths, count: int, coherent: bool) -> None:
        self._caster.fill(
            paths.origin[:count], paths.direction[:count], paths.near[:count], coherent,
            paths.distance[:count], paths.triangle[:count], paths.barycentric[:count],
        )  # fmt: skip

    def _vertex_rays(self, camera: Camera, size: tuple[int, int], line: Line) -> VertexRays:
        """The rays of the ray meshes; none for surface truth."""
        if self._bodies is None:
            return NO_RAYS
        return vertex_rays(self._bodies, self._geometry, camera.eye(size), line)


def _worlds(scene: Scene, geometry: Geometry, near: float, max_bounces: int) -> tuple[World, World, World]:
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
    red, green, blue = constant
    middle = World(
        geometry.positions, geometry.normals, parameters, geometry.faces, geometry.face_object,
        material, tint, green, red != blue, surface, np.concatenate(numbers), np.cumsum([0, *map(len, numbers)]),
        near, max_bounces,
    )  # fmt: skip
    return middle._replace(constant=red), middle, middle._replace(constant=blue)


def specular_rectangle(scene: Scene, camera: Camera, size: tuple[int, int]) -> Rectangle | None:
    """The part of the picture outside which no pixel looks at a specular mesh.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    size : (width, height)

    Returns
    -------
    (x0, y0, x1, y1) or None
        Pixels, the ends left out, a pixel wider than the meshes on each side; the whole picture where one of them
        reaches the plane of the eye; None where none is in the picture.
    """
    width, height = size
    axes, eye = camera.axes(), np.asarray(camera.position)
    focal = height / (2.0 * np.tan(np.radians(camera.field_of_view) / 2.0))
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for mesh in scene.meshes:
        if not mesh.specular or not len(mesh.positions):
            continue
        across, up, depth = axes @ (np.asarray(mesh.positions, float) - eye).T
        if depth.max() <= 0.0:
            continue
        if depth.min() <= 1e-6 * depth.max():
            return 0, 0, width, height
        x, y = width / 2.0 + focal * across / depth, height / 2.0 - focal * up / depth
        low = np.minimum(low, [x.min(), y.min()])
        high = np.maximum(high, [x.max(), y.max()])
    # Clipped first, because a vertex close to the plane of the eye projects beyond any integer.
    x0, y0 = (int(value) for value in np.floor(np.clip(low - 1.0, 0, size)))
    x1, y1 = (int(value) for value in np.ceil(np.clip(high + 1.0, 0, size)))
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None
