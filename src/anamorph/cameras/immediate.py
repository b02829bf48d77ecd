"""Surfaces to see from, given vertex by vertex, as OpenGL was given what to draw.

Source: Vallance and Calder, "Multi-perspective images for visualisation" (2001), appendix F of Vallance, "Trilinear
projection", section 3. Deviation: what is to be seen is a `Scene`, so that there is no geometry to begin and end; and
the paper prints the viewport's numbers in two orders.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.grid import Size, checked_count, checked_size, from_grid
from anamorph.cameras.ray_sets import from_triangles
from anamorph.cameras.surface import from_surface
from anamorph.raymesh import RayMesh
from anamorph.surfaces.bezier import BezierPatch

CONTROL_POINTS = 16


class RaySurface:
    """Surfaces given in immediate mode; `ray_mesh` is the camera that they make together.

    Each surface fills the viewport that is set when it ends: several are images side by side.

    ::

        surface = RaySurface((320, 320))
        surface.begin_surface("rays", columns=2)
        surface.normal(0.0, 0.0, -1.0)
        for x, y in ((-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)):
            surface.vertex(x, y, 2.0)
        surface.end_surface()
        camera = surface.ray_mesh()

    Parameters
    ----------
    size : (width, height)
        Of the image, pixels.
    """

    def __init__(self, size: Size) -> None:
        self._size = checked_size(size)
        self._corner, self._extent = (0, 0), self._size
        self._end: Callable[[Size], RayMesh] | None = None
        self._normal: tuple[float, float, float] | None = None
        self._vertices: list[tuple[float, float, float]] = []
        self._normals: list[tuple[float, float, float]] = []
        self._surfaces: list[RayMesh] = []

    def viewport(self, left: float, top: float, right: float, bottom: float) -> None:
        """What part of the image surfaces fill from now on, to the nearest pixel.

        The numbers are shares of the image's width and height, from its top left.
        """
        if not (0.0 <= left < right <= 1.0 and 0.0 <= top < bottom <= 1.0):
            raise AnamorphError(
                f"camera: viewport is ({left}, {top}, {right}, {bottom}); "
                "give left, top, right and bottom as shares of the image, from 0 to 1"
            )
        (width, height), (x, y) = self._size, (round(left * self._size[0]), round(top * self._size[1]))
        extent = round(right * width) - x, round(bottom * height) - y
        if min(extent) < 1:
            raise AnamorphError(f"camera: viewport of {extent[0]} x {extent[1]} pixels; give a pixel or more each way")
        self._corner, self._extent = (x, y), extent

    def begin_surface(self, kind: str = "rays", columns: int = 2, quads: int = 16) -> None:
        """Begin a surface: what its vertices mean is its kind.

        Parameters
        ----------
        kind : str
            "rays": each vertex with its normal is a ray, row by row from the top left, at least two rows.
            "triangles": three vertices with their normals are a triangle each; the surface lies in the viewport as in
            `from_triangles`. "patch": 16 vertices are the control points of a Bezier patch, row by row from the top
            left, whose own normals are the rays.
        columns : int
            Of "rays", how many there are in a row.
        quads : int
            Of "patch", how many there are across, and as many down.
        """
        if self._end is not None:
            raise AnamorphError("camera: begin_surface comes within a surface; call end_surface first")
        if kind == "rays":
            across = checked_count("columns", columns, 2)
            self._end = lambda size: self._rays(size, across)
        elif kind == "triangles":
            self._end = self._triangles
        elif kind == "patch":
            count = checked_count("quads", quads)
            self._end = lambda size: self._patch(size, count)
        else:
            raise AnamorphError(f"camera: kind of surface is {kind!r}; give rays, triangles or patch")
        self._vertices, self._normals = [], []

    def normal(self, x: float, y: float, z: float) -> None:
        """The direction of the rays of the vertices to come, of any length but 0."""
        if not (x or y or z):
            raise AnamorphError("camera: normal is (0, 0, 0); give the way that the ray goes")
        self._normal = x, y, z

    def vertex(self, x: float, y: float, z: float) -> None:
        """A vertex of the surface, metres, with the current normal."""
        if self._end is None:
            raise AnamorphError("camera: vertex comes outside a surface; call begin_surface first")
        self._vertices.append((x, y, z))
        self._normals.append(self._normal or (0.0, 0.0, 0.0))

    def end_surface(self) -> None:
        """End the surface: from now on the image shows what it sees."""
        if self._end is None:
            raise AnamorphError("camera: end_surface has no begin_surface; call that first")
        end, self._end = self._end, None
        mesh = end(self._extent)
        mesh.image[:, :2] += self._corner
        self._surfaces.append(mesh)

    def ray_mesh(self) -> RayMesh:
        """The camera of all surfaces; where they lie over each other the first is seen."""
        if self._end is not None:
            raise AnamorphError("camera: a surface is not ended; call end_surface first")
        if not self._surfaces:
            raise AnamorphError("camera: there is no surface; call begin_surface, vertex and end_surface first")
        surfaces = self._surfaces
        first = np.cumsum([0, *(len(mesh.image) for mesh in surfaces)])
        return RayMesh(
            image=np.concatenate([mesh.image for mesh in surfaces]),
            origins=np.concatenate([mesh.origins for mesh in surfaces]),
            directions=np.concatenate([mesh.directions for mesh in surfaces]),
            faces=np.concatenate([mesh.faces + offset for mesh, offset in zip(surfaces, first, strict=False)]),
            status=np.concatenate([mesh.status for mesh in surfaces]),
        )

    def _rays(self, size: Size, columns: int) -> RayMesh:
        rows, left = divmod(len(self._vertices), columns)
        if left or rows < 2:
            raise AnamorphError(
                f"camera: a surface of {len(self._vertices)} rays has no two rows of {columns}; "
                "give more, or other columns"
            )
        origins, directions = (np.reshape(each, (rows, columns, 3)) for each in (self._vertices, self._with_normals()))
        return from_grid(origins, directions, size)

    def _triangles(self, size: Size) -> RayMesh:
        count = len(self._vertices)
        if not count or count % 3:
            raise AnamorphError(f"camera: a surface of triangles has {count} vertices; give three for each triangle")
        return from_triangles(self._vertices, self._with_normals(), np.arange(count).reshape(-1, 3), size)

    def _patch(self, size: Size, quads: int) -> RayMesh:
        if len(self._vertices) != CONTROL_POINTS:
            raise AnamorphError(f"camera: a patch has {len(self._vertices)} control points; give {CONTROL_POINTS}")
        # In the patch v runs upward, so that its rays, which leave the onlooker, go against its normals.
        control = np.reshape(self._vertices, (4, 4, 3))[::-1].transpose(1, 0, 2)
        return from_surface(BezierPatch(control), size, inward=True, rows=quads, columns=quads)

    def _with_normals(self) -> list[tuple[float, float, float]]:
        if (0.0, 0.0, 0.0) in self._normals:
            raise AnamorphError("camera: a vertex comes before any normal; call normal first")
        return self._normals
