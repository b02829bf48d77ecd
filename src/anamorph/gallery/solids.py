"""The solids that the built-in scenes are made of: grids, boxes, lofts, lathes, extrusions and spheres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from anamorph.scene.model import Color, Diffuse, Material, Mesh

Rectangle = tuple[float, float, float, float]
WHOLE: Rectangle = (0.0, 0.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Solid:
    """Triangles without a name or a material yet.

    Parameters
    ----------
    positions, normals, colors : (V, 3) float64
    texcoords : (V, 2) float64
    faces : (F, 3) int
    """

    positions: np.ndarray
    normals: np.ndarray
    texcoords: np.ndarray
    colors: np.ndarray
    faces: np.ndarray

    def moved(self, x: float, y: float, z: float) -> Solid:
        return replace(self, positions=np.add(self.positions, (x, y, z)))

    def turned(self, degrees: float, axis: int = 1) -> Solid:
        """Turned right-handedly about the x, y or z axis (0, 1, 2)."""
        first, second = (axis + 1) % 3, (axis + 2) % 3
        cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        matrix = np.eye(3)
        matrix[[first, first, second, second], [first, second, first, second]] = cosine, -sine, sine, cosine
        return replace(self, positions=self.positions @ matrix.T, normals=self.normals @ matrix.T)

    def painted(self, color: Color) -> Solid:
        return replace(self, colors=self.colors * color)

    def shaded(self, light: np.ndarray) -> Solid:
        """Darkened vertex by vertex: `light` (V,) is the share of light that is left."""
        return replace(self, colors=self.colors * light[:, None])

    def mesh(self, name: str, material: Material) -> Mesh:
        textured = isinstance(material, Diffuse) and material.texture is not None
        return Mesh(
            name=name,
            positions=self.positions.astype(np.float32),
            faces=self.faces.astype(np.int32),
            normals=self.normals.astype(np.float32),
            material=material,
            texcoords=self.texcoords.astype(np.float32) if textured else None,
            colors=None if np.all(self.colors == 1.0) else self.colors.astype(np.float32),
        )


def join(shapes: Sequence[Solid]) -> Solid:
    """All `shapes` as one."""
    offsets = np.cumsum([0, *(len(shape.positions) for shape in shapes[:-1])])
    return Solid(
        positions=np.concatenate([shape.positions for shape in shapes]),
        normals=np.concatenate([shape.normals for shape in shapes]),
        texcoords=np.concatenate([shape.texcoords for shape in shapes]),
        colors=np.concatenate([shape.colors for shape in shapes]),
        faces=np.concatenate([shape.faces + offset for shape, offset in zip(shapes, offsets, strict=True)]),
    )


def creased(
    positions: np.ndarray,
    faces: np.ndarray,
    crease: float = 0.0,
    texcoords: np.ndarray | None = None,
    colors: np.ndarray | None = None,
) -> Solid:
    """Triangles with normals that are smooth across edges bent by less than `crease` degrees.

    `texcoords` (V, 2) and `colors` (V, 3) go with the vertices, or (F, 3, 2) and (F, 3, 3) with the faces' corners.
    Triangles without area are left out.
    """
    positions = np.asarray(positions, float)
    faces = np.asarray(faces)
    corners = positions[faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    kept = np.linalg.norm(area, axis=1) > 1e-12
    faces, corners, area = faces[kept], corners[kept].reshape(-1, 3), np.repeat(area[kept], 3, axis=0)

    _, places = np.unique(np.round(corners, 7), axis=0, return_inverse=True)
    touching = csr_array((np.ones(len(corners)), (np.arange(len(corners)), places.ravel())))
    one, other = (touching @ touching.T).nonzero()
    unit = area / np.linalg.norm(area, axis=1, keepdims=True)
    smooth = np.einsum("nk,nk->n", unit[one], unit[other]) >= np.cos(np.radians(crease)) - 1e-9
    normals = np.zeros_like(area)
    np.add.at(normals, one[smooth], area[other[smooth]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)

    texcoords = np.zeros((len(positions), 2)) if texcoords is None else np.asarray(texcoords, float)
    colors = np.ones((len(positions), 3)) if colors is None else np.asarray(colors, float)
    extras = [table[kept] if table.ndim == 3 else table[faces] for table in (texcoords, colors)]
    table = np.hstack([corners, normals, *(extra.reshape(len(corners), -1) for extra in extras)])
    _, chosen, index = np.unique(np.round(table, 7), axis=0, return_index=True, return_inverse=True)
    rows = table[chosen]
    return Solid(rows[:, :3], rows[:, 3:6], rows[:, 6:8], rows[:, 8:], index.reshape(-1, 3))


def lattice(rows: int, columns: int, closed: bool = False) -> np.ndarray:
    """Faces, (F, 3), of a grid of rows x columns vertices, counter-clockwise where columns run right and rows up.

    `closed` joins the last column to the first.
    """
    row, column = np.meshgrid(np.arange(rows - 1), np.arange(columns if closed else columns - 1), indexing="ij")
    after = (column + 1) % columns
    a, b = (row * columns + column).ravel(), (row * columns + after).ravel()
    c, d = b + columns, a + columns
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def grid(
    corner: Sequence[float],
    right: Sequence[float],
    up: Sequence[float],
    divisions: tuple[int, int] = (1, 1),
    image: Rectangle = WHOLE,
) -> Solid:
    """A parallelogram seen from the side of right x up, showing the part (left, top, right, bottom) of the texture."""
    s, t = np.meshgrid(np.linspace(0, 1, divisions[0] + 1), np.linspace(0, 1, divisions[1] + 1))
    s, t = s.reshape(-1, 1), t.reshape(-1, 1)
    normal = np.cross(right, up)
    left, top, far, bottom = image
    return Solid(
        positions=np.asarray(corner) + s * np.asarray(right) + t * np.asarray(up),
        normals=np.tile(normal / np.linalg.norm(normal), (len(s), 1)),
        texcoords=np.hstack([left + s * (far - left), bottom + t * (top - bottom)]),
        colors=np.ones((len(s), 3)),
        faces=lattice(divisions[1] + 1, divisions[0] + 1),
    )


def box(
    low: Sequence[float],
    high: Sequence[float],
    sides: str = "+x-x+y-y+z-z",
    image: Rectangle = WHOLE,
    divisions: tuple[int, int] = (1, 1),
) -> Solid:
    """A box between two corners; `sides` lists the faces it has."""
    (x, y, z), (w, h, d) = low, np.subtract(high, low)
    faces = {
        "+x": ((x + w, y, z + d), (0, 0, -d), (0, h, 0)),
        "-x": ((x, y, z), (0, 0, d), (0, h, 0)),
        "+y": ((x, y + h, z + d), (w, 0, 0), (0, 0, -d)),
        "-y": ((x, y, z), (w, 0, 0), (0, 0, d)),
        "+z": ((x, y, z + d), (w, 0, 0), (0, h, 0)),
        "-z": ((x + w, y, z), (-w, 0, 0), (0, h, 0)),
    }
    return join([grid(*faces[sides[i : i + 2]], divisions, image) for i in range(0, len(sides), 2)])


def six_sided(low: Sequence[float], high: Sequence[float], divisions: tuple[int, int] = (1, 1)) -> Solid:
    """A box whose sides, front, right, back, left, top and bottom, show six fields of a texture.

    They are the fields in its left three quarters, three across and two down.
    """
    sides = []
    for number, side in enumerate(("+z", "+x", "-z", "-x", "+y", "-y")):
        row, column = divmod(number, 3)
        sides.append(box(low, high, side, (column / 4, row / 2, (column + 1) / 4, (row + 1) / 2), divisions))
    return join(sides)


def loft(rings: np.ndarray, crease: float = 40.0) -> Solid:
    """A skin over `rings` (R, S, 3), whose points turn counter-clockwise seen from where the rings go.

    Texture coordinates run once around and along.
    """
    count, size = rings.shape[:2]
    along, around = np.meshgrid(np.linspace(1, 0, count), np.linspace(0, 1, size), indexing="ij")
    texcoords = np.stack([around.ravel(), along.ravel()], axis=-1)
    return creased(rings.reshape(-1, 3), lattice(count, size, closed=True), crease, texcoords)


def lathe(profile: Sequence[tuple[float, float]], segments: int = 16, crease: float = 40.0) -> Solid:
    """A solid of revolution about the y axis from (radius, height) pairs, listed from the bottom to the top."""
    angle = np.arange(segments) * 2 * np.pi / segments
    radius, height = np.asarray(profile, float).T
    x, z = np.multiply.outer(radius, np.cos(angle)), -np.multiply.outer(radius, np.sin(angle))
    return loft(np.stack([x, np.broadcast_to(height[:, None], x.shape), z], axis=-1), crease)


def cylinder(radius: float, height: float, segments: int = 12) -> Solid:
    """A closed cylinder that stands on the origin."""
    return lathe([(0, 0), (radius, 0), (radius, height), (0, height)], segments)


def globe(rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Angles (V, 2), longitude and latitude in radians, and faces (F, 3) of a whole sphere.

    The seam behind and the poles have several vertices in one place, so that angles are continuous in every triangle.
    """
    latitude, longitude = np.linspace(-np.pi / 2, np.pi / 2, rows + 1), np.linspace(-np.pi, np.pi, columns + 1)
    v, u = np.meshgrid(latitude, longitude, indexing="ij")
    faces = lattice(rows + 1, columns + 1).reshape(rows, columns, 2, 3)
    south, middle, north = faces[0, :, 1], faces[1:-1].reshape(-1, 3), faces[-1, :, 0]
    return np.stack([u.ravel(), v.ravel()], axis=-1), np.concatenate([south, middle, north])


def ball(subdivisions: int, radius: float, middle: Sequence[float]) -> Solid:
    """A plain ball of triangles that are about alike."""
    points, faces = icosphere(subdivisions)
    return Solid(points * radius + middle, points, np.zeros((len(points), 2)), np.ones_like(points), faces)


def icosphere(subdivisions: int) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors (V, 3) and faces (20 * 4 ** subdivisions, 3) of an icosahedron, refined."""
    golden = (1 + 5**0.5) / 2
    short = np.array([[0, i, j * golden] for i in (-1, 1) for j in (-1, 1)])
    points = np.concatenate([np.roll(short, shift, axis=1) for shift in range(3)]) / np.hypot(1, golden)
    near = np.linalg.norm(points[:, None] - points, axis=-1) < 1.2
    faces = np.array(
        [[a, b, c] for a in range(12) for b in range(a) for c in range(b) if near[a, b] and near[b, c] and near[c, a]]
    )
    inward = np.linalg.det(points[faces]) < 0
    faces[inward] = faces[inward][:, ::-1]
    for _ in range(subdivisions):
        corners = points[faces]
        middles = corners + np.roll(corners, -1, axis=1)
        middles /= np.linalg.norm(middles, axis=-1, keepdims=True)
        (a, b, c), (d, e, f) = np.moveaxis(corners, 1, 0), np.moveaxis(middles, 1, 0)
        triangles = np.concatenate([np.stack(three, axis=1) for three in ((a, d, f), (d, b, e), (f, e, c), (d, e, f))])
        points, index = np.unique(np.round(triangles.reshape(-1, 3), 12), axis=0, return_inverse=True)
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        faces = index.reshape(-1, 3)
    return points, faces
