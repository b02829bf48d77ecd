"""What goes into a method, and what comes out: View and Frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.output import save_image
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene


class Status(IntEnum):
    """How a pixel got its value."""

    DIRECT = 0
    WARPED = 1
    PROVED = 2
    TRACED = 3
    SKY = 4
    TOTAL_REFLECTION = 5
    OUTSIDE = 6
    PROJECTED = 7
    DOUBTFUL = 8


@dataclass(frozen=True, eq=False)
class View:
    """A scene as one camera sees it.

    Parameters
    ----------
    scene : Scene
    camera : Camera or RayMesh
        A ray mesh is itself the whole image: what none of its triangles covers is black, with `Status.OUTSIDE`.
    size : (width, height)
        Pixels.
    samples : int
        The image averages samples x samples shifted images; the seen buffers are those of pixel centres.
    """

    scene: Scene
    camera: Camera | RayMesh
    size: tuple[int, int]
    samples: int = 1

    @property
    def pinhole_camera(self) -> Camera:
        """The camera, for what can only see from one point."""
        if isinstance(self.camera, RayMesh):
            raise AnamorphError("camera: is a ray mesh, and what is asked for needs a pinhole camera; give a Camera")
        return self.camera


@dataclass(frozen=True, eq=False)
class Frame:
    """An image, and on request what each of its pixels sees.

    Parameters
    ----------
    color : (H, W, 3) float32
        Linear Rec. 709.
    position : (H, W, 3) float32, optional
        World point seen at the end of the pixel's path; where `object_id` is 0 (sky), the unit direction seen. Float64
        in a scene far from the origin.
    object_id : (H, W) uint32, optional
        The object seen at the end of the path: index into `Scene.meshes` plus one, or 0 for the sky.
    specular : (H, W) uint32, optional
        The object number of the specular surface that the pixel looks at; 0 for none.
    status : (H, W) uint8, optional
        A `Status` each.
    deviation : (H, W) float32, optional
        The angle between the pixel's own ray and the direction to the point that it shows, radians: what the method
        itself knows of its error.
    ray_origin, ray_direction : (H, W, 3) float32, optional
        The last ray of each pixel's path, from methods that have one for every pixel; the direction is zero where there
        is none. Origins are float64 in a scene far from the origin.
    ray_mesh : bool
        Whether the camera was a ray mesh.
    figures : mapping of str to float
        What the method tells of itself, with the seen buffers: see `SpecularDrawing.figures`.
    """

    color: np.ndarray
    position: np.ndarray | None = None
    object_id: np.ndarray | None = None
    specular: np.ndarray | None = None
    status: np.ndarray | None = None
    deviation: np.ndarray | None = None
    ray_origin: np.ndarray | None = None
    ray_direction: np.ndarray | None = None
    ray_mesh: bool = False
    figures: Mapping[str, float] = field(default_factory=dict)

    def save(self, path: str | Path, seen: Iterable[str] = ()) -> None:
        """Write the image, whole or not at all, in the format that the suffix of `path` names.

        `seen` names buffers of this frame that an .exr file holds besides, as layers of their names: whole numbers as
        uint32, others as float32.
        """
        layers = {name: getattr(self, name) for name in seen}
        if missing := [name for name, buffer in layers.items() if buffer is None]:
            raise AnamorphError(f"{path}: the frame was drawn without {', '.join(missing)}; draw it with seen buffers")
        save_image(Path(path), self.color, layers)
