"""What is seen at the picked pixel, kept up to date as the image changes."""

from __future__ import annotations

from dataclasses import replace

from anamorph.frame import View
from anamorph.methods import Specification
from anamorph.rendering import draw_frame
from anamorph.scene.camera import Camera
from anamorph.viewer.facts import Inspection
from anamorph.viewer.inspection import inspect, trace_path
from anamorph.viewer.measured import Measured, measure_half
from anamorph.viewer.showing import Showing
from anamorph.viewer.space import PreparedScene
from anamorph.viewer.state import REFERENCE, State, looking_eye, shown_camera

Size = tuple[int, int]


class Inspector:
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
        self._traced: tuple[PreparedScene, Camera] | None = None

    def update(self, space: PreparedScene, state: State, size: Size, showing: Showing) -> Inspection | None:
        """Look again where something has changed, and give what is known.

        Parameters
        ----------
        space : Space
            Of the scene as it is shown.
        state : State
        size : (width, height)
            Of the image, pixels.
        showing : Showing
        """
        if state.picked is None:
            self.inspection = self._picked = None
        elif state.observer is not None and not state.picked_outside:
            if self._by_eye and state.picked == self._picked:
                self._follow(space, looking_eye(state))
            elif showing.at_rest:
                self._look_by_eye(space, state, size)
        elif showing.at_rest:
            measured = showing.measured.get(_method(state))
            if measured is not None and not (measured is self._measured and state.picked == self._picked):
                self._found(space, state, shown_camera(state), size, measured)
        return self.inspection

    def found_at(self, picked: tuple[float, float] | None) -> Inspection | None:
        """What was seen at a picked pixel; None until that one has been looked into."""
        return self.inspection if picked is not None and picked == self._picked else None

    def _follow(self, space: PreparedScene, eye: Camera) -> None:
        """Trace the eye's path anew where it, or the scene, is another: of errors there is no word until it looks."""
        if self._traced != (space, eye) and self.inspection is not None:
            path = trace_path(space, eye, self._size, self.inspection.pixel)
            found = replace(self.inspection, path=path, reference=path[-1].name, angular_mrad=None, pixels=None)
            self.inspection, self._traced = found, (space, eye)

    def _look_by_eye(self, space: PreparedScene, state: State, size: Size) -> None:
        """Look from outside into a pixel of the eye's, for which its image is drawn once: a saved view opens so."""
        # What fails is told of once, and not tried again at every frame.
        self.inspection, self._picked, self._by_eye = None, state.picked, True
        method, eye = _method(state), looking_eye(state)
        view = View(space.scene, eye, size)
        frames = {each: draw_frame(view, each, seen=True) for each in (REFERENCE, method)}
        self._found(space, state, eye, size, measure_half(frames[REFERENCE], frames[method]))

    def _found(self, space: PreparedScene, state: State, camera: Camera, size: Size, seen: Measured) -> None:
        assert state.picked is not None
        x, y = state.picked
        pixel = min(int(x * size[0]), size[0] - 1), min(int(y * size[1]), size[1] - 1)
        self.inspection = inspect(space, camera, pixel, _method(state), seen)
        self._picked, self._measured, self._size = state.picked, seen, size
        self._by_eye, self._traced = not state.picked_outside, (space, camera)


def _method(state: State) -> Specification:
    """Of the half that is looked into."""
    assert state.picked is not None
    beyond = state.split and state.picked[0] >= state.divider
    return (state.second if beyond else state.first).method
