"""The panel's sections on what is there: the eye, and the scene's parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import groupby

import numpy as np

from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer.controls import Control, eye_controls, scene_controls
from anamorph.viewer.facts import Facts
from anamorph.viewer.fields import number
from anamorph.viewer.home import first_observer
from anamorph.viewer.sheet import Sheet, button, caption, checkbox, choice, section
from anamorph.viewer.state import EyeSide, State
from anamorph.viewer.wording import curvature_text

SIDES = ((EyeSide.LEFT, "Left"), (EyeSide.MIDDLE, "Middle"), (EyeSide.RIGHT, "Right"))

cached_controls = lru_cache(maxsize=4)(scene_controls)
"""A scene's controls; they are the same at every frame."""


def eye_section(sheet: Sheet, state: State, facts: Facts) -> State:
    """Where the eye is, which of the two looks, and whether somebody else looks at it."""
    if not section(sheet, "section/eye", "Eye"):
        return state
    camera, home = state.camera, facts.scene.camera
    for control, default in zip(_eye_controls(camera, facts.scene), _eye_controls(home, facts.scene), strict=True):
        value = _field(sheet, f"eye/{control.key}", control, control.default, default.default)
        if value != control.default:
            camera = with_eye(camera, control.key, value)
    state = replace(state, camera=camera)
    caption("Which eye looks: they are 65 mm apart")
    state = replace(state, eye=EyeSide(choice(sheet, "eye/side", state.eye, SIDES)))
    outside = checkbox(
        sheet, "eye/observer", "Look on from outside", state.observer is not None,
        "Take the picture from aside, to see the eye, the mirror and the rays between them",
    )  # fmt: skip
    if outside != (state.observer is not None):
        state = replace(state, observer=first_observer(facts.scene, camera) if outside else None)
    if (camera != home or state.eye is not EyeSide.MIDDLE) and button(sheet, "eye/reset", "Reset the eye"):
        state = replace(state, camera=home, eye=EyeSide.MIDDLE)
    return state


def with_eye(camera: Camera, key: str, value: float) -> Camera:
    """The camera with another x, y, z or field of view; the same one where it could then see nothing."""
    if key == "field_of_view":
        return replace(camera, field_of_view=value)
    x, y, z = (value if axis == key else was for axis, was in zip("xyz", camera.position, strict=True))
    toward = np.subtract(camera.target, (x, y, z))
    across, away = float(np.linalg.norm(np.cross(toward, camera.up))), float(np.linalg.norm(toward))
    return replace(camera, position=(x, y, z)) if across > 1e-6 * max(1.0, away) else camera


def scene_section(sheet: Sheet, state: State, facts: Facts) -> State:
    """The controls that the scene's parts have."""
    if not section(sheet, "section/scene", "Scene"):
        return state
    controls = cached_controls(facts.scene)
    if not controls:
        caption("Nothing in this scene can be turned: it has no mirror and no lens with controls.")
        return state
    values = dict(state.values)
    for group, members in groupby(controls, lambda control: control.group):
        caption(group)
        for control in members:
            was = values.get(control.key, control.default)
            new = _field(sheet, control.key, control, was, control.default)
            if new != was:
                values[control.key] = new
            if new == control.default:
                values.pop(control.key, None)
    if values and button(sheet, "reset", "Reset all of the scene"):
        values = {}
    return _with_values(state, values)


def _with_values(state: State, values: Mapping[str, float]) -> State:
    return state if values == dict(state.values) else replace(state, values=values)


def _eye_controls(camera: Camera, scene: Scene) -> tuple[Control, ...]:
    return eye_controls(camera, scene)


def _field(sheet: Sheet, key: str, control: Control, value: float, default: float) -> float:
    return number(
        sheet,
        key,
        control.label,
        value,
        (control.low, control.high),
        default=default,
        step=control.step,
        unit=control.unit,
        summary=control.summary,
        logarithmic=control.logarithmic,
        shown=curvature_text if control.unit == "1/m" else None,
    )
