"""What a scene is to the second tracer: parts with an analytic shape or triangles, and a camera."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

DIFFUSE, MIRROR, GLASS = "diffuse", "mirror", "glass"


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles with normals to interpolate.

    Parameters
    ----------
    positions, normals : (V, 3) float64
        Metres, rounded to float32 as the package's meshes are; unit normals toward the outside.
    faces : (F, 3) int64
        Counter-clockwise seen from outside.
    parameters : (V, 2) float64, optional
        Where on the part's shape the vertices are: longitude and latitude on a sphere, else x and y.
    """

    positions: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    parameters: np.ndarray | None = None

    def __post_init__(self) -> None:
        for name in ("positions", "normals"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), np.float32).astype(float))


@dataclass(frozen=True, eq=False)
class Shape:
    """An analytic surface about its own axes (rows right, up and outward).

    Parameters
    ----------
    kind : str
        "plane", "sphere", "cylinder" or "cone" (both about the outward axis), "toroid" or "asphere".
    origin : (3,) float64
        A sphere's centre; a point of a cylinder's or cone's axis; else the apex.
    axes : (3, 3) float64
    numbers : tuple of float
        Sphere and cylinder: radius. Cone: radius at the origin, and its change along the axis. Toroid: curvature along
        right, of the circle of turning, and along up. Asphere: curvature, conic constant, coefficients of r^4, r^6 ...
    side : float
        1 where the outside is away from a sphere's centre or a cylinder's axis, or else along outward; -1 opposite.
    """

    kind: str
    origin: np.ndarray
    axes: np.ndarray
    numbers: tuple[float, ...] = ()
    side: float = 1.0

    def moved(self, scale: float, offset: np.ndarray) -> Shape:
        powers = {
            "sphere": (1,), "cylinder": (1,), "cone": (1, 0), "toroid": (-1, -1),
            "asphere": (-1, 0, *(-3 - 2 * i for i in range(len(self.numbers) - 2))), "plane": (),
        }[self.kind]  # fmt: skip
        numbers = tuple(value * scale**power for value, power in zip(self.numbers, powers, strict=True))
        return replace(self, origin=scale * np.asarray(self.origin) + offset, numbers=numbers)


@dataclass(frozen=True, eq=False)
class Trim:
    """The prism in which a shape is there.

    Parameters
    ----------
    origin, axes : (3,), (3, 3) float64
        The third axis is the prism's.
    radius : float
        Of the circle, or of that around the polygon; infinite for none.
    low, high : float
        Ends along the axis, from the origin.
    corners : int
        Of the polygon; 0 for a circle.
    phase : float
        The angle of one corner, radians, from the first axis to the second.
    """

    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))
    radius: float = np.inf
    low: float = -np.inf
    high: float = np.inf
    corners: int = 0
    phase: float = 0.0

    def moved(self, scale: float, offset: np.ndarray) -> Trim:
        sizes = {name: scale * getattr(self, name) for name in ("radius", "low", "high")}
        return replace(self, origin=scale * np.asarray(self.origin) + offset, **sizes)


@dataclass(frozen=True, eq=False)
class Part:
    """One object: its mesh, and what the tracer takes instead of it: the shape, or a finer mesh."""

    name: str
    mesh: Mesh
    material: str = DIFFUSE
    index: float = 1.0
    shape: Shape | None = None
    trim: Trim = field(default_factory=Trim)
    finer: Mesh | None = None

    def moved(self, scale: float, offset: np.ndarray) -> Part:
        mesh, finer = (
            None if each is None else replace(each, positions=scale * each.positions + offset)
            for each in (self.mesh, self.finer)
        )
        if self.shape is None:
            return replace(self, mesh=mesh, finer=finer)
        if self.shape.kind != "sphere" and mesh.parameters is not None:
            mesh = replace(mesh, parameters=scale * mesh.parameters)
        return replace(self, mesh=mesh, shape=self.shape.moved(scale, offset), trim=self.trim.moved(scale, offset))


@dataclass(frozen=True)
class Camera:
    """A pinhole; `field_of_view` is the full vertical angle in degrees."""

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    field_of_view: float
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)

    def directions(self, points: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        """Unit directions, (N, 3), through image points (N, 2), in pixels from the top left corner of the image."""
        forward = np.subtract(self.target, self.position)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right = right / np.linalg.norm(right)
        width, height = size
        focal = 0.5 * height / np.tan(np.radians(0.5 * self.field_of_view))
        x, y = points[:, :1] - 0.5 * width, 0.5 * height - points[:, 1:]
        rays = focal * forward + x * right + y * np.cross(right, forward)
        return rays / np.linalg.norm(rays, axis=1, keepdims=True)

    def moved(self, scale: float, offset: np.ndarray) -> Camera:
        places = (tuple((scale * np.asarray(each) + offset).tolist()) for each in (self.position, self.target))
        return Camera(*places, self.field_of_view, self.up)


@dataclass(frozen=True, eq=False)
class Scene:
    """Part number i is object i + 1; object 0 is the sky."""

    name: str
    parts: tuple[Part, ...]
    camera: Camera

    def moved(self, scale: float = 1.0, offset: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Scene:
        """All of it scaled about the origin and then moved, metres."""
        by = scale, np.asarray(offset, float)
        return replace(self, parts=tuple(part.moved(*by) for part in self.parts), camera=self.camera.moved(*by))

    def meshed(self) -> Scene:
        """The same scene without shapes: the meshes are what there is."""
        return replace(self, parts=tuple(replace(part, shape=None, finer=None) for part in self.parts))
