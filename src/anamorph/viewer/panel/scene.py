"""The panel's sections on what is there: the eye, and the scene's parts."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import groupby

from anamorph.base.errors import AnamorphError
from anamorph.scene.camera import Camera
from anamorph.viewer.controls import Control, eye_controls, reading, scene_controls, with_eye
from anamorph.viewer.facts import Facts
from anamorph.viewer.observer import first_observer
from anamorph.viewer.panel.fields import number
from anamorph.viewer.panel.sheet import Sheet, button, caption, checkbox, choice, fold, section
from anamorph.viewer.panel.wording import decimals, number_text
from anamorph.viewer.state import EyeSide, State, with_observer

SIDES = ((EyeSide.LEFT, "Left"), (EyeSide.MIDDLE, "Middle"), (EyeSide.RIGHT, "Right"))


def scene_section(sheet: Sheet, state: State, facts: Facts) -> State:
    """The controls that the scene's parts have."""
    if not section(sheet, "section/scene", "Scene"):
        return state
    controls = scene_controls(facts.scene)
    if not controls:
        caption("Nothing to turn here: the scene has no mirror and no lens.")
        sheet.note("scene/empty")
        return state
    values = dict(state.values)
    groups = [(name, list(members)) for name, members in groupby(controls, lambda control: control.group)]
    for name, members in groups:
        if not fold(sheet, f"part/{name}", name, name == groups[0][0]):
            continue
        for control in members:
            was = values.get(control.key, control.default)
            new = _field(sheet, control, was)
            if new != was:
                values[control.key] = new
            if new == control.default:
                values.pop(control.key, None)
    if values and button(sheet, "reset", "Reset all of the scene"):
        values = {}
    return state if values == dict(state.values) else replace(state, values=values)


def eye_section(sheet: Sheet, state: State, facts: Facts) -> State:
    """Where the eye is, which of the two looks, and whether somebody else looks at it."""
    if not section(sheet, "section/eye", "Eye"):
        return state
    camera, home = state.camera, facts.home or facts.scene.camera
    values = (*camera.position, camera.field_of_view)
    for control, was in zip(eye_controls(camera, facts.scene), values, strict=True):
        new = _field(sheet, control, was)
        if new != was:
            camera = _moved(camera, control.key, new)
    caption("Which eye looks: they are 65 mm apart")
    state = replace(state, camera=camera, eye=EyeSide(choice(sheet, "eye/side", state.eye, SIDES)))
    outside = checkbox(
        sheet,
        "eye/observer",
        "Look on from outside",
        state.observer is not None,
        "Take the image from aside, to see the eye, the mirror and the rays between them",
    )
    if outside != (state.observer is not None):
        state = with_observer(state, first_observer(facts.scene, camera) if outside else None)
    if (camera != home or state.eye is not EyeSide.MIDDLE) and button(sheet, "eye/reset", "Reset the eye"):
        state = replace(state, camera=home, eye=EyeSide.MIDDLE)
    return state


def _moved(camera: Camera, key: str, value: float) -> Camera:
    """The eye with one of its controls set; as it was where it could then see nothing, straight above its target."""
    try:
        return with_eye(camera, key, value)
    except AnamorphError:
        return camera


def curvature_text(control: Control, curvature: float) -> str:
    """A curvature with its radius, in as many digits as tell apart what its slider can be set to."""
    return f"{number_text(curvature, max(3, decimals(control.step)))} 1/m, {reading(control, curvature)}"


def _field(sheet: Sheet, control: Control, value: float) -> float:
    return number(
        sheet,
        control.key,
        control.label,
        value,
        (control.low, control.high),
        default=control.default,
        step=control.step,
        unit=control.unit.removeprefix("1"),
        summary=control.summary,
        shown=partial(curvature_text, control) if control.unit == "1/m" else None,
    )
