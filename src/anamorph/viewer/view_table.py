"""The viewer's state as the [view] table of a scene file, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal
from typing import Any

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector
from anamorph.editing.edit import Edit
from anamorph.files.scene_file import camera_of
from anamorph.files.tables import Table
from anamorph.files.view_file import Opened, eye_values, views_of
from anamorph.methods import Specification
from anamorph.methods.averaging import MAXIMUM_SAMPLES
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_camera
from anamorph.viewer.controls import MOVES, SHAPES, TURNS
from anamorph.viewer.state import REFERENCE, Aspect, Drawing, EyeSide, Half, State

UNITS = ("mrad", "px")
MOST_RESOLUTION = 4.0
FAR = (-np.inf, np.inf)
ORIGIN = (0.0, 0.0, 0.0)


def view_of(state: State) -> dict[str, Any]:
    """What a [view] table keeps: the state but eye, method and values, which the scene file has elsewhere."""
    view: dict[str, Any] = {
        "aspect": state.first.aspect.value,
        "second": str(state.second.method),
        "second_aspect": state.second.aspect.value,
        "split": state.split,
        "divider": float(state.divider),
        "eye": state.eye.value,
        "unit": state.unit,
        "drawings": sorted(drawing.value for drawing in state.drawings),
        "samples": state.samples,
        "resolution": float(state.resolution),
        "panel": state.panel,
        "help": state.help,
    }
    if state.observer is not None:
        view["observer"] = eye_values(state.observer)
    if state.picked is not None:
        view |= {"picked": [float(share) for share in state.picked], "picked_outside": state.picked_outside}
        if state.point is not None:
            view["point"] = [float(value) for value in state.point]
    if state.views:
        view["views"] = [eye_values(each) for each in state.views]
    return view


def state_of(opened: Opened) -> State:
    """The state that a viewer starts with: as the file's [view] says, and plain where it says nothing.

    Raises
    ------
    AnamorphError
        With file, line and key, where the table holds something else than `view_of` writes.
    """
    first = Half(Specification.parse(opened.settings.method))
    table = opened.settings.view
    plain = State(opened.camera, first, Half(REFERENCE), values=values_of(opened.edits))
    if table is None:
        return plain
    table.only(*view_of(plain), "observer", "picked", "picked_outside", "point", "views")
    return replace(
        plain,
        first=Half(first.method, Aspect(table.choice("aspect", Aspect, Aspect.IMAGE))),
        second=Half(_method(table), Aspect(table.choice("second_aspect", Aspect, Aspect.IMAGE))),
        split=table.flag("split", plain.split),
        divider=table.number("divider", plain.divider, 0.0, 1.0),
        eye=EyeSide(table.choice("eye", EyeSide, plain.eye)),
        observer=_observer(table),
        unit=table.choice("unit", UNITS, plain.unit),
        drawings=frozenset(map(Drawing, table.words("drawings", Drawing))),
        samples=table.whole("samples", plain.samples, 1, MAXIMUM_SAMPLES),
        resolution=table.number("resolution", plain.resolution, 0.0, MOST_RESOLUTION),
        panel=table.flag("panel", plain.panel),
        help=table.flag("help", plain.help),
        picked=_picked(table),
        picked_outside=_picked_outside(table),
        point=_point(table),
        views=views_of(table),
    )


def values_of(edits: Mapping[str, Edit]) -> dict[str, float]:
    """The values of controls that make these changes; a turn or a move by nothing is none."""
    values: dict[str, float] = {}
    for name, by in edits.items():
        turned = {f"{name}/{what}": angle for what, angle in zip(TURNS, by.turn, strict=True) if angle}
        moved = {f"{name}/{what}": _millimetres(way) for what, way in zip(MOVES, by.move, strict=True) if way}
        shaped = {f"{name}/{what}": getattr(by, what) for what in SHAPES if getattr(by, what) is not None}
        values |= turned | moved | shaped
    return values


def _millimetres(metres: float) -> float:
    """What a control was set to that moves by `metres`: the roundest of the numbers that come to just that."""
    product = 1e3 * metres
    near = (float(Decimal(repr(metres)).scaleb(3)), product, *(float(np.nextafter(product, side)) for side in FAR))
    return next((value for value in near if 1e-3 * value == metres), product)


def _method(table: Table) -> Specification:
    try:
        return Specification.parse(table.text("second", str(REFERENCE)))
    except AnamorphError as error:
        table.wrong("second", str(error))


def _observer(table: Table) -> Camera | None:
    observer = table.table("observer")
    if observer is None:
        return None
    camera = camera_of(observer)
    check_camera(camera, f"{table.path}: observer")
    return camera


def _picked(table: Table) -> tuple[float, float] | None:
    given = table.values.get("picked")
    if given is None:
        return None
    if not isinstance(given, list) or len(given) != 2 or not all(type(share) in (int, float) for share in given):
        table.wrong("picked", f"picked is {given!r}; give two shares of the image's width and height, as [0.5, 0.5]")
    x, y = (float(share) for share in given)
    if not (0.0 <= x <= 1.0 and 0.0 <= y <= 1.0):
        table.wrong("picked", f"picked is {given!r}; give shares from 0 to 1")
    return (x, y)


def _picked_outside(table: Table) -> bool:
    outside = table.flag("picked_outside")
    missing = [key for key in ("picked", "observer") if key not in table.values]
    if outside and missing:
        table.wrong("picked_outside", f"picked_outside needs {missing[0]}; give it too, or leave picked_outside out")
    return outside


def _point(table: Table) -> Vector | None:
    if "point" not in table.values:
        return None
    if "picked" not in table.values:
        table.wrong("point", "point needs picked; give it too, or leave point out")
    return table.vector("point", ORIGIN)
