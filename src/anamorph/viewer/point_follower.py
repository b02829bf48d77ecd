"""The point of the world whose reflection points are shown, and these, kept up to date as eye and scene move."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np

from anamorph.base.vectors import Vector
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer.facts import Reflections
from anamorph.viewer.inspector import Inspector
from anamorph.viewer.point_search import reflections_of
from anamorph.viewer.state import Drawing, State, looking_eye
from anamorph.viewer.worker import Worker

PATIENCE = 0.03
"""Seconds of a frame that a search may take. Scenes in which it takes longer are searched when nothing moves: it would
take these seconds from images that move, and be late for them."""


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
        self._seconds = np.inf

    def update(self, scene: Scene, state: State, size: tuple[int, int], at_rest: bool) -> Reflections | None:
        """Search again where something has changed, and give what is known.

        Parameters
        ----------
        scene : Scene
            As it is shown.
        state : State
        size : (width, height)
            Of the image, pixels.
        at_rest : bool
            Whether nothing moves.

        Raises
        ------
        AnamorphError
            Once, where there is nothing to search, such as a mirror.
        """
        self.reflections, self.searching = None, False
        if Drawing.REFLECTIONS in state.drawings and state.point is not None:
            self.searching = True
            if at_rest or self._seconds <= PATIENCE:
                key = scene, looking_eye(state), size, state.point
                self.reflections = self._worker.get(key, partial(self._search, *key), PATIENCE)
                self.searching = self._worker.busy
        return self.reflections

    def _search(self, scene: Scene, eye: Camera, size: tuple[int, int], point: Vector) -> Reflections:
        began = perf_counter()
        found = reflections_of(scene, eye, size, point)
        self._seconds = perf_counter() - began
        return found
