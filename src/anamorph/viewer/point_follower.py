"""The point of the world whose reflection points are shown, and these, kept up to date as eye and scene move."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from anamorph.scene.model import Scene
from anamorph.viewer.facts import Reflections
from anamorph.viewer.inspector import Inspector
from anamorph.viewer.point_search import reflections_of
from anamorph.viewer.state import Drawing, State, looking_eye
from anamorph.viewer.worker import Worker

PATIENCE = 0.03
"""Seconds of a frame that a search may take: with the quick ones, the marks move as the image does."""


def with_point(state: State, inspector: Inspector) -> State:
    """The state with the point that is seen at the picked pixel, where its reflection points are to be shown.

    A point that is there stays: the picked pixel of another image shows another.
    """
    if Drawing.REFLECTIONS not in state.drawings or state.point is not None:
        return state
    found = inspector.found_at(state.picked)
    return state if found is None or found.point is None else replace(state, point=found.point)


class PointFollower:
    """The reflection points of a state's point.

    Attributes
    ----------
    reflections : Reflections or None
        Of the point and the eye of the last update; None where nothing is to be shown, and until it is found.
    searching : bool
        Whether they are being searched for.
    """

    def __init__(self) -> None:
        self._worker = Worker[Reflections]()
        self.reflections: Reflections | None = None
        self.searching = False

    def update(self, scene: Scene, state: State, size: tuple[int, int]) -> Reflections | None:
        """Search again where something has changed, and give what is known.

        Parameters
        ----------
        scene : Scene
            As it is shown.
        state : State
        size : (width, height)
            Of the image, pixels.

        Raises
        ------
        AnamorphError
            Once, where there is nothing to search, such as a mirror.
        """
        self.reflections, self.searching = None, False
        if Drawing.REFLECTIONS in state.drawings and state.point is not None:
            eye = looking_eye(state)
            work = partial(reflections_of, scene, eye, size, state.point)
            self.reflections = self._worker.get((scene, eye, size, state.point), work, PATIENCE)
            self.searching = self._worker.busy
        return self.reflections
