"""The panel's section on the image: which methods draw it, with which options, and how finely."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

from anamorph.methods import METHODS, Specification
from anamorph.scene.model import Scene
from anamorph.scene.parts import specular_parts
from anamorph.viewer.controls import OptionControl, option_controls
from anamorph.viewer.facts import Facts
from anamorph.viewer.panel.fields import Choice, number, text, word
from anamorph.viewer.panel.sheet import Sheet, button, caption, checkbox, choice, fold, section
from anamorph.viewer.panel.wording import size_text
from anamorph.viewer.state import REFERENCE, Aspect, Drawing, Half, State

ASPECTS = ((Aspect.IMAGE, "Image"), (Aspect.ERROR, "Error"), (Aspect.STATUS, "Status"), (Aspect.COUNTS, "Counts"))
UNITS = (("mrad", "mrad"), ("px", "pixels"))
SAMPLES = (("1", "1"), ("2", size_text((2, 2))), ("4", size_text((4, 4))), ("8", size_text((8, 8))))
RESOLUTIONS = (("0.0", "auto"), ("1.0", "100 %"), ("0.75", "75 %"), ("0.5", "50 %"), ("0.25", "25 %"))
DRAWINGS = (
    (Drawing.WIREFRAME, "Wireframe", "The triangles of mirrors and lenses"),
    (Drawing.HITS, "Hit balls", "A ball where the ray of each vertex meets the scene"),
    (Drawing.VIEWPOINT, "Virtual viewpoint", "The point that the bent rays come nearest to, and these rays"),
    (Drawing.VOLUME, "View volume", "What the map taken from the virtual viewpoint holds"),
    (Drawing.REFLECTIONS, "Reflection points", "Where mirrors show the point that is clicked, all of them"),
)

WIDE = 20.0
"""Options that may be larger than this move in coarser steps."""

SPREAD = 50.0
"""Options whose highest value is so many times the lowest have a logarithmic slider: small ones are used most."""

UNIT_SIGNS = {"degrees": "°", "pixels": "px"}

BOUNCES = "bounces"
"""What methods call the option of how many mirrors and faces of lenses a path may meet."""


def image_section(sheet: Sheet, state: State, facts: Facts) -> State:
    """What the halves show, and how finely."""
    if not section(sheet, "section/image", "Image"):
        return state
    if state.split:
        caption("Left half")
    state = replace(state, first=_half(sheet, "first", state.first, facts))
    split = checkbox(sheet, "split", "Compare with a second half", state.split)
    state = replace(state, split=split)
    if state.split:
        caption("Right half")
        state = replace(state, second=_half(sheet, "second", state.second, facts))
    if any(half.aspect is Aspect.ERROR for half in state.halves):
        caption("Errors in")
        state = replace(state, unit=choice(sheet, "unit", state.unit, UNITS))
    return state


def quality_section(sheet: Sheet, state: State) -> State:
    """How finely the image is drawn, at rest and while it moves."""
    if not section(sheet, "section/quality", "Quality", opened=False):
        return state
    caption("Samples a pixel, at rest")
    state = replace(state, samples=int(choice(sheet, "samples", str(state.samples), SAMPLES)))
    caption("Resolution while moving")
    resolution = choice(sheet, "resolution", str(float(state.resolution)), RESOLUTIONS)
    return replace(state, resolution=float(resolution))


def space_section(sheet: Sheet, state: State) -> State:
    """What is drawn into space."""
    if not section(sheet, "section/space", "In space", opened=False):
        return state
    drawings = set(state.drawings)
    for drawing, title, summary in DRAWINGS:
        if checkbox(sheet, f"space/{drawing}", title, drawing in drawings, summary):
            drawings.add(drawing)
        else:
            drawings.discard(drawing)
    return replace(state, drawings=frozenset(drawings))


def few_bounces(options: Any, scene: Scene) -> str:
    """What to say of options that follow light over fewer mirrors and faces of lenses than the reference does."""
    shown, true = getattr(options, BOUNCES, None), getattr(REFERENCE.options, BOUNCES)
    if shown is None or shown >= true or not _sees_itself(scene):
        return ""
    followed = f"Follows light over {shown} mirrors or faces of lenses, the reference over {true}"
    return f"{followed}: see {BOUNCES} in the options."


@lru_cache(maxsize=4)
def _sees_itself(scene: Scene) -> bool:
    """Whether there may be a mirror or lens in a mirror or lens."""
    return len(specular_parts(scene.meshes)) > 1


def _half(sheet: Sheet, key: str, half: Half, facts: Facts) -> Half:
    method = half.method.method
    chosen = word(sheet, f"{key}/method", "method", method.name, _methods(facts), method.summary)
    half = half if chosen == method.name else replace(half, method=Specification.parse(chosen))
    half = replace(half, aspect=Aspect(choice(sheet, f"{key}/aspect", half.aspect, ASPECTS)))
    method, options = half.method.method, half.method.options
    if few := few_bounces(options, facts.scene):
        caption(few)
    if not fold(sheet, f"{key}/options", "Options", False):
        return half
    was = options
    for control in option_controls(method):
        value = _option(sheet, f"{key}/{control.name}", control, getattr(options, control.name))
        options = replace(options, **{control.name: value})
    if options != method.options() and button(sheet, f"{key}/reset", "Reset the options"):
        options = method.options()
    return half if options == was else replace(half, method=Specification(method, options))


def _methods(facts: Facts) -> tuple[Choice, ...]:
    glass = "This scene has glass, and {} does not refract: it cannot draw it"
    return tuple(
        Choice(
            name,
            f"{name} (the reference)" if name == REFERENCE.method.name else name,
            method.summary,
            glass.format(name) if facts.scene.refracts and not method.refracts else "",
        )
        for name, method in METHODS.items()
    )


def _option(sheet: Sheet, key: str, control: OptionControl, value: Any) -> Any:
    label = control.name.replace("_", " ")
    if control.kind == "flag":
        return checkbox(sheet, key, label, value, control.summary)
    if control.kind == "choice":
        choices = tuple(Choice(str(each), str(each)) for each in control.choices)
        return type(value)(word(sheet, key, label, str(value), choices, control.summary))
    if control.kind == "word":
        return text(sheet, key, label, value, control.summary)
    whole = control.kind == "whole"
    new = number(
        sheet,
        key,
        label,
        float(value),
        (-math.inf if control.low is None else control.low, math.inf if control.high is None else control.high),
        default=float(control.default),
        step=1.0 if whole else 0.5 if control.high is not None and control.high > WIDE else 0.01,
        unit=UNIT_SIGNS.get(control.unit, control.unit),
        summary=control.summary,
        logarithmic=bool(control.low and control.high and control.high >= SPREAD * control.low > 0.0),
    )
    return round(new) if whole else new
