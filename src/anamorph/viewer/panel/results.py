"""The panel's sections that tell: what is seen at a pixel, how wrong the halves are, and how long it took."""

from __future__ import annotations

import numpy as np
from imgui_bundle import imgui

from anamorph.measure.errors import Statistics
from anamorph.viewer.facts import Facts, Inspection, Request
from anamorph.viewer.panel import theme
from anamorph.viewer.panel.reflected import reflections_table
from anamorph.viewer.panel.sheet import Sheet, button, caption, field_width, row, section, wrapped
from anamorph.viewer.panel.wording import (
    NOT_MEASURED,
    figure,
    method_text,
    name_text,
    number_text,
    point_text,
    size_text,
)
from anamorph.viewer.remembered import LEAST
from anamorph.viewer.state import Aspect, Drawing, State, with_picked

SAVED = (
    (Request.SAVE_IMAGE, "Image", "The image as it is seen, without the panel"),
    (Request.SAVE_SCENE, "Scene file", "A scene file that opens this very view again"),
    (
        Request.SAVE_TURNTABLE,
        "Turntable",
        "A video in which the eye swings to either side; from outside, it goes all the way round",
    ),
    (Request.SAVE_TURNTABLE_SERIES, "Turntable PNGs", "The turntable as numbered images in a folder"),
    (Request.SAVE_PATH, "Path", "A video in which the eye goes through the remembered views, one after the other"),
    (Request.SAVE_PATH_SERIES, "Path PNGs", "The path as numbered images in a folder"),
    (Request.SAVE_COMPARISON, "Comparison", "A page that compares the methods on this view, with error maps"),
)

PATHS = Request.SAVE_PATH, Request.SAVE_PATH_SERIES
TOO_FEW = "A path needs two remembered views (K)."

UNASKED = "Choose Error above, or click into the image, to have them measured."


def inspection_section(sheet: Sheet, state: State, facts: Facts) -> State:
    """What is seen at the pixel that is looked into."""
    fresh = _newly_picked(state)
    if fresh:
        imgui.set_next_item_open(True)
    if not section(sheet, "section/inspection", "Looked-into pixel"):
        return state
    if fresh:
        imgui.set_scroll_here_y(0.0)
    if state.picked and Drawing.REFLECTIONS in state.drawings:
        reflections_table(facts)
    if facts.inspection is None:
        caption("Measuring …" if state.picked else "Click into the image to look into a pixel.")
    else:
        _inspection(facts.inspection)
    if state.picked and button(sheet, "inspection/clear", "Clear"):
        state = with_picked(state, None)
    return state


def figures_section(sheet: Sheet, state: State, facts: Facts) -> None:
    """How wrong the halves are."""
    if not section(sheet, "section/figures", "Errors of the halves" if state.split else "Errors of the image"):
        return
    figures = tuple(facts.figures)[: len(state.halves)]
    if not any(figures):
        asked = any(half.aspect is Aspect.ERROR for half in state.halves)
        caption("Measured when nothing moves." if asked or state.picked else UNASKED)
        return
    if len(figures) > 1:
        row("", "left", "right")
    unit = "px" if state.unit == "px" else "mrad"
    none = Statistics(None, None, None)
    of = [none if each is None else each.pixels if unit == "px" else each.angular_mrad for each in figures]
    row(f"median, {unit}", *(figure(each.median) for each in of))
    row(f"95 %, {unit}", *(figure(each.p95) for each in of))
    row(f"maximum, {unit}", *(figure(each.max) for each in of))
    row("other object, %", *(figure(None if each is None else each.other_object_percent) for each in figures))
    for name in dict.fromkeys(name for each in figures if each for name in each.status_percent):
        shares = (f"{each.status_percent.get(name, 0.0):.1f}" if each else NOT_MEASURED for each in figures)
        row(f"{name_text(name)}, %", *shares)


def save_section(sheet: Sheet, state: State, facts: Facts) -> None:
    """What can be saved."""
    if not section(sheet, "section/save", "Save", opened=False):
        return
    width = (field_width() - 6.0) / 2.0
    few = len(state.views) < LEAST
    for number, (request, text, summary) in enumerate(SAVED):
        if number % 2:
            imgui.same_line(0.0, 6.0)
        imgui.begin_disabled(facts.progress is not None or (few and request in PATHS))
        if button(sheet, request, text, TOO_FEW if few and request in PATHS else summary, width):
            sheet.requests.append(request)
        imgui.end_disabled()
    if few:
        caption(TOO_FEW)


def timing_section(sheet: Sheet, facts: Facts) -> None:
    """How long the images take, and what draws them."""
    if not section(sheet, "section/timing", "Timing", opened=False):
        return
    row("an image", f"{facts.frame_ms:.1f} ms" if facts.frame_ms else NOT_MEASURED)
    row("images a second", f"{1000.0 / facts.frame_ms:.0f}" if facts.frame_ms else NOT_MEASURED)
    for phase, time in facts.phases_ms.items():
        row(f"   {phase}", f"{time:.1f} ms")
    if all(facts.image):
        row("drawn", size_text(facts.image))
        row("at rest", size_text(facts.full))
        if facts.samples_total > 1:
            row("samples", f"{facts.samples_done} of {facts.samples_total}")
    row("adapter", facts.adapter)


def _newly_picked(state: State) -> bool:
    """Whether another pixel is looked into than at the frame before; not where the sections have just come up."""
    kept, known = imgui.get_state_storage(), imgui.get_id("picked")
    x, y = state.picked or (-1.0, 0.0)
    mixed = float(np.float32(x + 7.0 * y))
    before = kept.get_float(known, -1.0)
    kept.set_float(known, mixed)
    return state.picked is not None and mixed != before and not imgui.is_window_appearing()


def _inspection(seen: Inspection) -> None:
    row("pixel", f"{seen.pixel[0]}, {seen.pixel[1]}")
    row("method", method_text(seen.method))
    row("sees", seen.seen)
    row("in truth", seen.reference)
    if seen.reference != seen.seen:
        wrapped("Another object than the reference.", theme.WARNING)
    row("point, m", NOT_MEASURED if seen.point is None else point_text(seen.point))
    row("along the path", NOT_MEASURED if seen.distance is None else number_text(seen.distance, 3, "m"))
    row("status", name_text(seen.status))
    if seen.angular_mrad is None:
        row("error", "not measured")
    else:
        row("error", f"{figure(seen.angular_mrad)} mrad, {figure(seen.pixels)} px")
    if seen.silhouette:
        wrapped("At a silhouette: its error counts apart.", theme.FAINT)
    caption("True path, m")
    for number, stop in enumerate(seen.path):
        row(f"{'→ ' if number else ''}{stop.name}", point_text(stop.point))
