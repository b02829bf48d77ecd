"""From a view and a method to a frame."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.files.opening import open_scene
from anamorph.files.scene_file import Settings
from anamorph.frame import Frame, View
from anamorph.methods import METHODS, Method, Specification
from anamorph.methods.averaging import averaging
from anamorph.raymesh import RayMesh, check_ray_mesh
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_contents, check_scene
from anamorph.scene.model import Scene

Drawn = Callable[[int, int], None]
"""Told the shifted images that are drawn, and their number."""


def draw_frame(
    view: View, specification: Specification, seen: bool = False, report: Drawn = lambda done, total: None
) -> Frame:
    """Draw the mean of the shifted images that `view.samples` asks for; seen buffers are those of pixel centres."""
    session = specification.open(view)
    color = drain(averaging(session, view.camera, view.samples), lambda drawn: report(*drawn))
    if not seen:
        return Frame(color, ray_mesh=isinstance(view.camera, RayMesh))
    if view.samples > 1:
        session.draw(view.camera)
    return session.frame(seen=True, color=color)


def render(
    scene: Scene | str | Path,
    method: str | Specification | None = None,
    camera: Camera | RayMesh | None = None,
    size: tuple[int, int] | None = None,
    samples: int = 1,
    seen: bool = False,
    **options: Any,
) -> Frame:
    """Draw a scene.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, the name of a built-in one, or the path of a scene file or a model file.
    method : str or Specification, optional
        "name" or "name:option=value,…"; auto unless a scene file says otherwise.
    camera : Camera or RayMesh, optional
        The scene's own by default. A ray mesh is itself the whole image, for the methods that can see through one.
    size : (width, height), optional
        Pixels; 1024 x 768 unless a scene file says otherwise. For a ray mesh, the least size that holds its image.
    samples : int
        The image averages samples x samples a pixel.
    seen : bool
        Whether the frame carries its seen buffers.
    **options
        Options of the method, by name.

    Returns
    -------
    Frame
    """
    opened, settings = (scene, Settings()) if isinstance(scene, Scene) else open_scene(scene)
    chosen = Specification.parse(method or settings.method).with_options(**options)
    if isinstance(camera, RayMesh):
        _check_sees(chosen.method, camera)
        view = View(check_contents(opened), camera, size or camera.least_size(), samples)
    else:
        # What has been opened by its name has been checked with its own camera.
        if opened is scene or camera is not None:
            opened = check_scene(dataclasses.replace(opened, camera=camera or opened.camera))
        view = View(opened, opened.camera, size or settings.size, samples)
    return draw_frame(view, chosen, seen)


def _check_sees(method: Method, camera: RayMesh) -> None:
    """Refuse a method that cannot see through a ray mesh, and a ray mesh through which none can."""
    if not method.ray_meshes:
        able = " or ".join(name for name, each in METHODS.items() if each.ray_meshes)
        raise AnamorphError(f"camera: {method.name} cannot see through a ray mesh; give {able}")
    check_ray_mesh(camera, "camera")
