"""What a method is: a name, its options, and a session that draws frames.

To add another: a module beside this one that ends in `METHOD = Method(...)`, its shader beside it under the same
name, and a line in `methods/__init__.py`. The command line, the comparison and the tests find it in the registry.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
import wgpu

from anamorph.frame import Frame, View
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera


class Session(Protocol):
    """One scene, size and set of options, ready to draw: everything that can be made once has been."""

    @property
    def texture(self) -> wgpu.GPUTexture:
        """Where frames are drawn, on the device: linear, rgba16float, the last one in it."""
        ...

    def draw(self, camera: Camera | RayMesh, shift: tuple[float, float] = (0.0, 0.0)) -> None:
        """Submit one frame; `shift` moves its sample points by a fraction of a pixel, right and down.

        The camera is of the kind, pinhole or ray mesh, that the session was opened with.
        """
        ...

    def deform(self, positions: np.ndarray, normals: np.ndarray) -> None:
        """Move the scene's vertices, for every frame to come; `positions` and `normals` are (V, 3) float32.

        They are numbered as `scene.geometry.flatten` does, and the triangles between them stay. Specular meshes stay
        where they are, because their exact surfaces do.
        """
        ...

    def wait(self) -> None:
        """Return when every submitted frame is finished on the device."""
        ...

    def frame(self, seen: bool = False) -> Frame:
        """Read the last frame back; its seen buffers, if asked for, are drawn in passes of their own."""
        ...

    def phases(self) -> Mapping[str, float]:
        """Where a frame's time goes, milliseconds by phase; empty before the first frame.

        Of the last draw, one after the other on the processor: "prepare" (rays, and maps planned), "record" (passes
        recorded and submitted) and "mend" (what the method does once it is drawn, the device's part included). Beside
        them "device": what the device needed for the last frame that was waited for, where it tells.
        """
        ...


@runtime_checkable
class Stepwise(Protocol):
    """A session that draws in steps what takes long; others draw it at once."""

    def drawing(self, camera: Camera | RayMesh, shift: tuple[float, float] = (0.0, 0.0)) -> Generator[None, None, None]:
        """`Session.draw`, as a generator that yields every few milliseconds.

        Until it ends, the texture holds the frame before. It may be closed at any step, and the next frame is drawn as
        if it had never begun; nothing else may be asked of the session meanwhile.
        """
        ...


def drawing(
    session: Session, camera: Camera | RayMesh, shift: tuple[float, float] = (0.0, 0.0)
) -> Generator[None, None, None]:
    """Draw a frame in the steps that a session has."""
    if isinstance(session, Stepwise):
        yield from session.drawing(camera, shift)
    else:
        session.draw(camera, shift)


@dataclass(frozen=True)
class Method:
    """A registered method.

    Parameters
    ----------
    name : str
    summary : str
        One line for lists.
    source : str
        The paper and sections it builds on.
    options : type
        A frozen dataclass whose fields have defaults and are bool, int, float or str. Those that `options.option`
        makes say what they may be, which `options.check_options` holds them to, and its docstring says what they mean.
    open : callable
        (View, options) -> Session.
    refracts : bool
        Whether it draws scenes with glass.
    ray_meshes : bool
        Whether its camera may be a ray mesh.
    """

    name: str
    summary: str
    source: str
    options: type
    open: Callable[[View, Any], Session]
    refracts: bool = False
    ray_meshes: bool = False
