"""Looking into a pixel: what is seen at the picked place, kept up to date as the picture changes."""

from __future__ import annotations

from dataclasses import replace

from anamorph.scene.camera import Camera
from anamorph.viewer.facts import Inspection
from anamorph.viewer.inspection import inspect, trace_path
from anamorph.viewer.measured import Measured
from anamorph.viewer.showing import Showing
from anamorph.viewer.space import Space
from anamorph.viewer.state import TRUTH, State, looking_eye

Size = tuple[int, int]


class Looking:
    """What is seen at the picked pixel.

    What the eye has looked into stays when an observer looks on, to see its path from outside; the path then follows
    eye and mirror.

    Attributes
    ----------
    inspection : Inspection or None
        What was found last, until there are newer frames; None where nothing is picked.
    """

    def __init__(self) -> None:
        self.inspection: Inspection | None = None
        self._picked: tuple[float, float] | None = None
        self._measured: Measured | None = None
        self._by_eye = False
        self._size: Size = (0, 0)
        self._traced: tuple[Space, Camera] | None = None

    def update(self, space: Space, state: State, size: Size, showing: Showing) -> Inspection | None:
        """Look again where something has changed, and give what is known.

        Parameters
        ----------
        space : Space
            Of the scene as it is shown.
        state : State
        size : (width, height)
            Of the picture, pixels.
        showing : Showing
        """
        if state.picked is None:
            self.inspection = self._picked = None
        elif self.inspection is not None and self._by_eye and state.observer and state.picked == self._picked:
            self._follow(space, looking_eye(state))
        elif showing.at_rest:
            self._look(space, state, size, showing)
        return self.inspection

    def _follow(self, space: Space, eye: Camera) -> None:
        """Trace the eye's path anew where it, or the scene, is another: of errors there is no word until it looks."""
        if self._traced != (space, eye) and self.inspection is not None:
            path = trace_path(space, eye, self._size, self.inspection.pixel)
            found = replace(self.inspection, path=path, truth=path[-1].name, angular_mrad=None, pixels=None)
            self.inspection, self._traced = found, (space, eye)

    def _look(self, space: Space, state: State, size: Size, showing: Showing) -> None:
        assert state.picked is not None
        x, y = state.picked
        beyond = state.split and x >= state.divider
        method = (state.second if beyond else state.first).method
        measured = showing.measured.get(method)
        if measured is None or (measured is self._measured and state.picked == self._picked):
            return
        camera, truth = state.observer or looking_eye(state), showing.frames[TRUTH]
        pixel = min(int(x * size[0]), size[0] - 1), min(int(y * size[1]), size[1] - 1)
        self.inspection = inspect(space, camera, size, pixel, method, measured.frame, truth, measured.maps)
        self._picked, self._measured, self._size = state.picked, measured, size
        self._by_eye, self._traced = state.observer is None, (space, camera)
