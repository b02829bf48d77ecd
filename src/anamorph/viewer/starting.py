"""What a viewer starts with: a scene and a state, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from anamorph.base.errors import AnamorphError
from anamorph.files.scene_file import Settings
from anamorph.files.source import Source
from anamorph.files.source_words import source_in
from anamorph.files.view_file import Opened, open_view
from anamorph.methods import METHODS, Specification
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_scene
from anamorph.scene.model import Scene
from anamorph.viewer.observer import first_observer
from anamorph.viewer.state import Half, State
from anamorph.viewer.view_table import state_of

NOTHING = Scene("nothing opened", (), Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)))
"""What is shown of a scene that could not be opened."""


@dataclass(frozen=True, eq=False)
class Start:
    """Where a viewer starts.

    Parameters
    ----------
    opened : Opened
        Its scene has no meshes where it could not be opened.
    state : State
        What the viewer starts with, and what its resets return to.
    message : str
        Why it could not be opened; empty where it could.
    """

    opened: Opened
    state: State
    message: str = ""

    @property
    def scene(self) -> Scene:
        """As it was opened."""
        return self.opened.scene

    @property
    def methods(self) -> tuple[str, ...]:
        """The names of the methods that can draw the scene."""
        return tuple(name for name, method in METHODS.items() if method.refracts or not self.scene.refracts)


def reset_view(state: State, start: Start) -> State:
    """The camera back at its start, and the observer, if one looks, at where it starts."""
    camera = start.state.camera
    observer = None if state.observer is None else first_observer(start.scene, camera)
    return replace(state, camera=camera, observer=observer)


def start_of(source: Source | Scene | str | Path, method: str | Specification | None = None) -> Start:
    """Open a scene, or whatever names one, seen first by `method`; a failure is told in the message.

    A text may say more of a CAD file, in the words of the command line: "mirror.step --scene car-mirror --flip".
    """
    try:
        opened = _open(source)
        if method is not None:
            opened = replace(opened, settings=replace(opened.settings, method=str(Specification.parse(method))))
        state = state_of(opened)
        drawn = state.first.method.method
        if opened.scene.refracts and not drawn.refracts:
            able = ", ".join(name for name, each in METHODS.items() if each.refracts)
            raise AnamorphError(f"method {drawn.name}: draws mirrors alone, and the scene has glass; give {able}")
        return Start(opened, state)
    except (AnamorphError, OSError) as error:
        nothing = Opened(NOTHING, Settings(), NOTHING.camera)
        return Start(nothing, state_of(nothing), str(error))


def carried_over(state: State, start: Start) -> State:
    """The state in which a viewer goes on with another scene: what is set of the old one's image stays.

    Parameters
    ----------
    state : State
        Of the old scene.
    start : Start
        Of the new one. A view that a file keeps is shown as it was; a method that cannot draw the scene is left.
    """
    if start.opened.settings.view is not None:
        return start.state
    able = start.methods

    def half(old: Half, new: Half) -> Half:
        return old if old.method.method.name in able else replace(old, method=new.method)

    return replace(
        state,
        camera=start.state.camera,
        first=half(state.first, start.state.first),
        second=half(state.second, start.state.second),
        observer=None,
        values=start.state.values,
        picked=None,
        picked_outside=False,
        point=None,
        views=start.state.views,
        opening=None,
    )


def _open(source: Source | Scene | str | Path) -> Opened:
    if isinstance(source, Scene):
        scene = check_scene(source)
        return Opened(scene, Settings(), scene.camera)
    if isinstance(source, str) and " --" in source and not Path(source).exists():
        source = source_in(source)
    if isinstance(source, Source):
        return open_view(source.name, source.choice, source.mirror_of, source.units, source.axes)
    return open_view(source)
