"""What a method draws on: the scene on the device, and the eye's projection."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.limits import MOST_PIXELS
from anamorph.frame import View
from anamorph.gpu.buffers import SceneBuffers, pack_vertices, upload_scene, upload_vertices
from anamorph.gpu.device import maximum_size
from anamorph.gpu.drawing import ProjectionUniform
from anamorph.gpu.recording import Recorder
from anamorph.optics.tessellation import outlined_scene
from anamorph.projection import camera_projection
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry, flatten
from anamorph.scene.nearness import moved_scene, origin_of


class Stage:
    """What a method draws on: the scene on the device and the eye's projection.

    Attributes
    ----------
    recorder : Recorder
    view : View
        What to draw, near the origin: coordinates in it are the world's less `origin`. Its mirrors and lenses have the
        outlines of their exact surfaces, as the camera of the view sees them, or if that is a ray mesh, the scene's.
    origin : (3,) float64
        Zeros, but for a scene far from the origin, metres.
    has_pinhole : bool
        Whether the camera is one. If it is a ray mesh, only the image's size in the projection means something, and
        the session leaves all drawing to the method.
    """

    def __init__(self, view: View) -> None:
        sides = view.size if isinstance(view.size, Sequence | np.ndarray) else ()
        if len(sides) != 2 or not all(isinstance(side, int | np.integer) for side in sides):
            raise AnamorphError(f"size is {view.size}; give two whole numbers of pixels, like (1024, 768)")
        if min(view.size) < 1 or max(view.size) > maximum_size():
            width, height = view.size
            raise AnamorphError(f"size {width}x{height}: give a width and height from 1 to {maximum_size()}")
        if view.size[0] * view.size[1] > MOST_PIXELS:
            width, height = view.size
            raise AnamorphError(
                f"size {width}x{height}: is more than {MOST_PIXELS / 1e6:.0f} million pixels; give fewer"
            )
        self.origin = origin_of(view.scene)
        self._moved: tuple[Camera | RayMesh, Camera | RayMesh] | None = None
        scene, camera = moved_scene(view.scene, -self.origin), self.local(view.camera)
        scene = outlined_scene(scene, camera if isinstance(camera, Camera) else scene.camera, view.size)
        self.view = replace(view, scene=scene, camera=camera)
        self.recorder = Recorder()
        self.has_pinhole = isinstance(camera, Camera)
        self._counts = [len(mesh.positions) for mesh in view.scene.meshes]
        self.geometry: Geometry = flatten(self.view.scene)
        self.buffers: SceneBuffers = upload_scene(self.view.scene, self.geometry)
        self.projection: ProjectionUniform = ProjectionUniform()

    def local(self, camera: Camera | RayMesh) -> Camera | RayMesh:
        """A camera of the world as the stage has it; the same one for the same."""
        if not self.origin.any():
            return camera
        if self._moved is None or self._moved[0] is not camera:
            self._moved = camera, camera.moved(-self.origin)
        return self._moved[1]

    def look(self, camera: Camera | RayMesh, shift: tuple[float, float]) -> None:
        """Set the projection."""
        if isinstance(camera, RayMesh) is self.has_pinhole:
            raise AnamorphError("camera: is of another kind than the session was opened with; open one for it")
        eye = self.view.scene.camera if isinstance(camera, RayMesh) else camera
        self.projection.write(camera_projection(eye, self.view.size, shift), self.view.size)

    @cached_property
    def _vertices(self) -> np.ndarray:
        return pack_vertices(self.geometry)

    def deform(self, positions: np.ndarray, normals: np.ndarray) -> None:
        """Move the vertices, here and on the device. See `Session.deform`."""
        self.geometry = replace(
            self.geometry,
            positions=self._checked("positions", positions, self.geometry.positions, self.origin),
            normals=self._checked("normals", normals, self.geometry.normals, np.zeros(3)),
        )
        self._vertices["position"], self._vertices["normal"] = self.geometry.positions, self.geometry.normals
        upload_vertices(self.buffers, self._vertices)

    def _checked(self, name: str, given: np.ndarray, before: np.ndarray, origin: np.ndarray) -> np.ndarray:
        if np.shape(given) != (sum(self._counts), 3):
            raise AnamorphError(f"deform: {name} have the shape {np.shape(given)}; give {(sum(self._counts), 3)}")
        values = before.copy()
        parts = np.split(np.subtract(given, origin), np.cumsum(self._counts)[:-1])
        for first, part in zip(self.geometry.first_vertex, parts, strict=False):
            # Where a mesh has been refined, its old vertices come first.
            values[first : first + len(part)] = part
        if not np.isfinite(values).all():
            raise AnamorphError(f"deform: {name} are not all finite; give numbers")
        refined = np.diff(self.geometry.first_vertex) != self._counts
        for index in np.union1d(self.buffers.specular, np.flatnonzero(refined)):
            own = slice(*self.geometry.first_vertex[index : index + 2])
            # Far from the origin, given positions are rounded.
            if np.abs(values[own] - before[own]).max(initial=0.0) > 2.0**-23 * np.abs(origin).max():
                mesh = self.view.scene.meshes[index].name
                raise AnamorphError(
                    f"deform: {name} of {mesh!r} differ, which is specular or a lens's edge; leave its vertices alone"
                )
        return values
