"""What is there: meshes, materials, lights and sky, as frozen data.

Arrays follow CONVENTIONS.md: metres, right-handed, y up, texture coordinates from the top left,
linear colours but for textures, which are stored as 8-bit sRGB.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from anamorph.scene.camera import Camera
from anamorph.surfaces.base import Surface
from anamorph.surfaces.similarity import Similarity

Color = tuple[float, float, float]
Wrap = Literal["repeat", "clamp", "mirror"]
WHITE: Color = (1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Texture:
    """An image on surfaces.

    Parameters
    ----------
    pixels : (H, W, 4) uint8
        sRGB with linear alpha, row 0 on top.
    wraps : two of "repeat", "clamp" and "mirror"
        What lies beyond its edges, across and down: the image again, the texels of the edge, or the image turned over.
    """

    pixels: np.ndarray
    wraps: tuple[Wrap, Wrap] = ("repeat", "repeat")


@dataclass(frozen=True, eq=False)
class LinearImage:
    """An image of light, as bright as it may be: `pixels` (H, W, 3) float32, linear Rec. 709, row 0 on top."""

    pixels: np.ndarray


@dataclass(frozen=True, eq=False)
class Diffuse:
    """A diffuse material: linear `color`, multiplied by the texture and the vertex colours."""

    color: Color = (0.8, 0.8, 0.8)
    texture: Texture | None = None


@dataclass(frozen=True, eq=False)
class Mirror:
    """A polished metal: `tint` times Schlick's reflectance, which is `reflectance` at normal incidence.

    The back of a mirror is diffuse, of linear colour `back`.
    """

    tint: Color = WHITE
    reflectance: float = 0.9
    back: Color = (0.02, 0.02, 0.02)


@dataclass(frozen=True, eq=False)
class Glass:
    """A clear dielectric of refractive `index` inside, 1 outside; `tint` is applied at each crossing.

    `abbe` is its Abbe number; without one, light of all colours goes one way.
    """

    index: float = 1.5
    tint: Color = WHITE
    abbe: float | None = None


Material = Diffuse | Mirror | Glass


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one material: one object of the scene.

    Parameters
    ----------
    name : str
        What commands, scene files and messages call this part.
    positions : (V, 3) float64 or float32
        Vertices, metres. They are rounded to float32 when the scene is drawn, after it has been moved to the origin.
    faces : (F, 3) int32
        Vertex indices, counter-clockwise seen from outside.
    normals : (V, 3) float32
        Unit normals, pointing outside.
    material : Diffuse, Mirror or Glass
    texcoords : (V, 2) float32, optional
        (0, 0) is the top left of the texture.
    colors : (V, 3) float32, optional
        Linear vertex colours, multiplied into the diffuse colour.
    surface : Surface, optional
        The exact shape that the mesh approximates.
    parameters : (V, 2) float64, optional
        The (u, v) of each vertex on `surface`.
    """

    name: str
    positions: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    material: Material = field(default_factory=Diffuse)
    texcoords: np.ndarray | None = None
    colors: np.ndarray | None = None
    surface: Surface | None = None
    parameters: np.ndarray | None = None

    @classmethod
    def exact(
        cls,
        name: str,
        surface: Surface,
        parameters: np.ndarray,
        faces: np.ndarray,
        material: Material,
        toward: np.ndarray | None = None,
        decimals: int | None = None,
    ) -> Mesh:
        """A mesh all of whose vertices lie on an exact surface.

        Parameters
        ----------
        name, surface, faces, material
            As of `Mesh`.
        parameters : (V, 2) float64
            Where on the surface the vertices are.
        toward : (3,) float64, optional
            Normals are on the side to which this points; by default they are the surface's own.
        decimals : int, optional
            To which positions are rounded, so that neighbours get the same along a border that they share.
        """
        positions = surface.position(parameters)
        normals = surface.normal(parameters) if toward is None else surface.normals_toward(parameters, toward[None])
        return cls(
            name=name,
            positions=positions if decimals is None else np.round(positions, decimals),
            faces=faces.astype(np.int32),
            normals=normals.astype(np.float32),
            material=material,
            surface=surface,
            parameters=parameters,
        )

    @property
    def specular(self) -> bool:
        """Whether light goes on from this mesh (mirror or glass) and does not end there."""
        return not isinstance(self.material, Diffuse)

    @property
    def side(self) -> float:
        """1 where the exact surface's own normals point out of the mesh, -1 where they point into it."""
        assert self.surface is not None and self.parameters is not None
        return 1.0 if np.sum(self.surface.normal(self.parameters) * self.normals) > 0.0 else -1.0

    def exact_positions(self) -> np.ndarray:
        """Where the vertices are on the exact surface, (V, 3) float64, metres."""
        assert self.surface is not None and self.parameters is not None
        return self.surface.position(self.parameters)

    def moved(self, by: Similarity) -> Mesh:
        """The mesh moved, with its exact surface."""
        surface, parameters = self.surface, self.parameters
        if surface is not None and surface.metric and parameters is not None:
            parameters = by.scale * parameters
        return replace(
            self,
            positions=by.points(self.positions),
            normals=by.directions(self.normals).astype(np.float32),
            surface=None if surface is None else surface.moved(by),
            parameters=parameters,
        )


@dataclass(frozen=True)
class DirectionalLight:
    """Parallel light: unit vector `toward` the light, linear `color` (irradiance over pi)."""

    toward: tuple[float, float, float]
    color: Color = WHITE


@dataclass(frozen=True)
class PointLight:
    """Light from `position` (metres): linear `color` at one metre, falling with the distance squared."""

    position: tuple[float, float, float]
    color: Color = WHITE


@dataclass(frozen=True)
class AmbientLight:
    """Light from all around: `sky` from straight above, blending to `ground` from straight below."""

    sky: Color = (0.5, 0.5, 0.5)
    ground: Color = (0.5, 0.5, 0.5)


Light = DirectionalLight | PointLight | AmbientLight


@dataclass(frozen=True, eq=False)
class Sky:
    """What a ray that hits nothing sees.

    Linear colours blend from `zenith` (straight up) to `horizon`, and to `nadir` (straight down).
    An equirectangular `image` (its centre at -z, its left edge at +z, its top row straight up) replaces them.
    """

    zenith: Color = (0.25, 0.45, 0.85)
    horizon: Color = (0.75, 0.85, 0.95)
    nadir: Color = (0.35, 0.35, 0.35)
    image: Texture | LinearImage | None = None


DEFAULT_LIGHTS: tuple[Light, ...] = (
    DirectionalLight(toward=(0.4, 0.8, 0.45), color=(0.85, 0.82, 0.75)),
    AmbientLight(sky=(0.45, 0.5, 0.55), ground=(0.25, 0.23, 0.2)),
)


@dataclass(frozen=True, eq=False)
class Scene:
    """Meshes under lights and a sky, and the camera from which they are meant to be seen.

    Mesh number i of `meshes` is object i + 1 in every frame; object 0 is the sky.
    """

    name: str
    meshes: tuple[Mesh, ...]
    camera: Camera
    lights: tuple[Light, ...] = DEFAULT_LIGHTS
    sky: Sky = field(default_factory=Sky)

    @property
    def refracts(self) -> bool:
        """Whether some mesh is of glass."""
        return any(isinstance(mesh.material, Glass) for mesh in self.meshes)
