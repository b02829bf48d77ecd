"""What a viewer opens: a scene and the state it starts in, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from anamorph.errors import AnamorphError
from anamorph.methods import METHODS, parse
from anamorph.scene.cad import FaceChoice
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_scene
from anamorph.scene.model import Scene
from anamorph.scene.opening import open_scene
from anamorph.scene.scenefile import Settings
from anamorph.viewer.showing import TRUTH
from anamorph.viewer.state import Half, State

NOTHING = Scene("nothing opened", (), Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)))


@dataclass(frozen=True, eq=False)
class Source:
    """What names a scene: as on the command line."""

    name: str
    choice: FaceChoice | None = None
    mirror_of: str | None = None


@dataclass(frozen=True, eq=False)
class Opened:
    """A scene to look at.

    Parameters
    ----------
    scene : Scene
        Without meshes where it could not be opened.
    state : State
        What the viewer starts with, and what its resets return to.
    source : Source or None
        None for a scene made in Python.
    message : str
        Why it could not be opened; empty where it could.
    """

    scene: Scene
    state: State
    source: Source | None = None
    message: str = ""


def open_source(source: Source | str | Path | Scene, method: str | None = None) -> Opened:
    """Open whatever names a scene, or a scene itself, first seen by `method`; a failure is told in the message."""
    named = source if isinstance(source, Source | Scene) else Source(str(source))
    try:
        if isinstance(named, Scene):
            scene, settings = check_scene(named), Settings()
        else:
            scene, settings = open_scene(named.name, named.choice, named.mirror_of)
        specification = method or settings.method
        drawn, _ = parse(specification)
        if scene.refracts and not drawn.refracts:
            able = ", ".join(name for name, each in METHODS.items() if each.refracts)
            raise AnamorphError(f"method {drawn.name}: draws mirrors alone, and the scene has glass; give {able}")
        message = ""
    except (AnamorphError, OSError) as error:
        scene, specification, message = NOTHING, Settings.method, str(error)
    state = State(scene.camera, Half(specification), Half(TRUTH))
    return Opened(scene, state, None if isinstance(named, Scene) else named, message)
