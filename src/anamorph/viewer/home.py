"""Where a viewer of a scene starts, and what its resets return to."""

from __future__ import annotations

from dataclasses import dataclass, replace

from anamorph.methods import METHODS
from anamorph.scene.model import Scene
from anamorph.viewer.observer import first_observer
from anamorph.viewer.state import State


@dataclass(frozen=True, eq=False)
class Home:
    """Where a viewer starts.

    Parameters
    ----------
    state : State
    scene : Scene
        As it was opened.
    """

    state: State
    scene: Scene

    @property
    def methods(self) -> tuple[str, ...]:
        """The names of the methods that can draw the scene."""
        return tuple(name for name, method in METHODS.items() if method.refracts or not self.scene.refracts)


def reset_view(state: State, home: Home) -> State:
    """The camera back at its start, and the observer, if one looks, at where it starts."""
    camera = home.state.camera
    observer = None if state.observer is None else first_observer(home.scene, camera)
    return replace(state, camera=camera, observer=observer)
