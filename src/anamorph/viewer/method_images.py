"""One method's images of one scene: at the sizes that moving and resting need, and their mean at rest."""

from __future__ import annotations

from collections.abc import Generator, Mapping

import wgpu

from anamorph.frame import Frame, View
from anamorph.methods import Session, Specification
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer.compose import Average
from anamorph.viewer.failures import failure_text

Size = tuple[int, int]

KEPT_SIZES = 4
"""Sessions that stay open: for images that move, for false-colour images that move, for what rests and for what comes
before."""


class MethodImages:
    """Images of a scene by the method with its options, each drawn in the steps that the method has.

    One is drawn at a time; one that is left in the midst shows nothing, and the next is begun anew.

    Attributes
    ----------
    failure : str
        Why the last image that was asked for could not be drawn; empty where it was. What failed is not tried
        again, nor finer, but from elsewhere.
    phases : mapping of str to float
        What the time of the last image that was waited for went to, milliseconds: only of these the device tells.
    """

    def __init__(self, scene: Scene, specification: Specification) -> None:
        self._scene, self._specification = scene, specification
        self._sessions: dict[Size, Session] = {}
        self._last: Session | None = None
        self._refined: Session | None = None
        self._average: Average | None = None
        self._shown_from: Camera | None = None
        self._failed: tuple[Camera, Size, str] | None = None
        self.failure = ""
        self.phases: Mapping[str, float] = {}

    @property
    def texture(self) -> wgpu.GPUTexture | None:
        """What there is to show: the mean of the images at rest, or the last one that was drawn."""
        if self._average is not None and self._average.count:
            return self._average.texture
        return None if self._last is None else self._last.texture

    def drawing(self, camera: Camera, size: Size) -> Generator[None, None, None]:
        """Draw one image, and show it in place of all before; where it fails, one of another size stays."""
        session = yield from self._drawing(camera, size, (0.0, 0.0))
        if self._average is not None:
            self._average.restart()
        if session is not None or camera != self._shown_from:
            self._last, self._shown_from = session, camera

    def refining(self, camera: Camera, size: Size, shift: tuple[float, float]) -> Generator[None, None, None]:
        """Draw an image shifted by a fraction of a pixel, for `refine`."""
        self._refined = None
        self._refined = yield from self._drawing(camera, size, shift)

    def refine(self) -> None:
        """Show the mean of all images of `refining` since the last `drawing`."""
        if self._refined is None:
            return
        self._last, size = self._refined, self._refined.texture.size[:2]
        if self._average is None or self._average.texture.size[:2] != size:
            self._average = Average(size)
        self._average.add(self._last.texture)

    def seeing(self, camera: Camera, size: Size) -> Generator[None, None, Frame | None]:
        """What each pixel sees, of an unshifted image; the image that is shown stays."""
        session = yield from self._drawing(camera, size, (0.0, 0.0))
        try:
            return None if session is None else session.frame(seen=True)
        except Exception as error:
            self._fail(error, camera, size)
            return None

    def wait(self) -> None:
        """Return when the device has drawn the last image."""
        if self._last is not None:
            self._last.wait()
            self.phases = self._last.phases()

    def _drawing(self, camera: Camera, size: Size, shift: tuple[float, float]) -> Generator[None, None, Session | None]:
        if self._failed is not None and self._failed[0] == camera and self._failed[1] <= size:
            self.failure = self._failed[2]
            return None
        self.failure = ""
        try:
            session = self.session(camera, size)
            yield from session.drawing(camera, shift)
        except Exception as error:
            self._fail(error, camera, size)
            return None
        return session

    def _fail(self, error: Exception, camera: Camera, size: Size) -> None:
        """Say why, whatever a method raises: the viewer goes on without it."""
        self.failure = failure_text(error, f"method {self._specification}")
        self._failed = camera, size, self.failure

    def session(self, camera: Camera, size: Size) -> Session:
        """The one that draws images of a size, opened where there is none."""
        session = self._sessions.pop(size, None)
        if session is None:
            while len(self._sessions) >= KEPT_SIZES:
                self._sessions.pop(next(iter(self._sessions)))
            session = self._specification.open(View(self._scene, camera, size))
        # The one used last is the last to go.
        self._sessions[size] = session
        return session
