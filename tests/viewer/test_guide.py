"""What the viewer's guide says of keys, gestures, colours, scales, modules and reports is what the code has."""

from __future__ import annotations

import re
import runpy
from dataclasses import dataclass
from pathlib import Path

import pytest
from scenes import CAMERA, scene_with, spherical_mirror
from viewer_hand import Hand

from anamorph.frame import View
from anamorph.measure.status import STATUS_NAMES
from anamorph.methods import METHODS, Method, Session, Specification
from anamorph.methods.options import option
from anamorph.viewer import gestures, shortcuts
from anamorph.viewer.counting import COUNT_COLORS
from anamorph.viewer.facts import Facts
from anamorph.viewer.fluency import RESOLUTIONS, SLOWEST
from anamorph.viewer.measured import ERROR_COLORS, STATUS_COLORS, scale_ticks
from anamorph.viewer.panel.methods import DRAWINGS, UNITS
from anamorph.viewer.panel.results import SAVED
from anamorph.viewer.snapshot import snapshot
from anamorph.viewer.starting import start_of
from anamorph.viewer.state import Half, State
from anamorph.viewer.tasks import SWING
from anamorph.viewer.turntable import LEG, RATE

ROOT = Path(__file__).resolve().parents[2]
GUIDE = (ROOT / "docs" / "viewer.md").read_text()
PROSE = " ".join(GUIDE.split())


def table(title: str) -> list[list[str]]:
    """The cells of the table whose first heading is `title`, without its headings."""
    rows = GUIDE.split(f"\n| {title} |")[1].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("| ").split(" | ")] for row in rows[: rows.index("")]]


def test_every_key_is_listed_as_in_help():
    assert table("key") == [[" or ".join(each.keys), each.group, each.summary] for each in shortcuts.SHORTCUTS]


def test_every_gesture_is_listed_as_in_help():
    assert table("gesture") == [list(each) for each in gestures.GESTURES]


def test_the_scales_are_those_that_are_drawn():
    ends = [[unit, *(scale_ticks(unit)[end][1] for end in (0, -1))] for unit, _ in UNITS]
    assert [row[:3] for row in table("unit")] == ends


def test_every_color_status_and_drawing_is_explained():
    errors, statuses, counts = (row for row in GUIDE.split("\n| colour | ")[1:])
    assert errors.startswith("error") and statuses.startswith("status") and counts.startswith("count")
    assert re.findall(r"^\| \w+ \| ([a-z ]+) \|", errors.split("\n\n")[0], re.M) == list(ERROR_COLORS)
    listed = re.findall(r"^\| [a-z ]+ \| ([a-z ]+) \|", statuses.split("\n\n")[0], re.M)
    assert listed == [STATUS_NAMES[status] for status in STATUS_COLORS]
    assert re.findall(r"^\| \w+ \| ([\w ]+) \|$", counts.split("\n\n")[0], re.M) == list(COUNT_COLORS)
    assert [row[0] for row in table("drawing")] == [title.lower() for _, title, _ in DRAWINGS]


def test_what_can_be_saved_is_listed():
    assert [row[0] for row in table("what")] == [title for _, title, _ in SAVED]
    assert f"swings {SWING:g} degrees" in PROSE
    assert f"in {LEG / RATE:g} seconds from one to the next" in PROSE


def test_numbers_of_fluency_are_the_codes():
    shares = [f"{100.0 * resolution:g}" for resolution in RESOLUTIONS]
    assert f"{', '.join(shares[:-1])} and {shares[-1]} percent" in PROSE
    assert f"than {SLOWEST:g} ms" in PROSE


def test_every_module_has_its_place():
    rows = GUIDE.split("| modules of ")[1].split("\n\n")[0].splitlines()[2:]
    listed = [name for row in rows for name in re.findall(r"`([\w/]+)`", row)]
    room = ROOT / "src" / "anamorph" / "viewer"
    there = [
        path.relative_to(room).with_suffix("").as_posix() for path in room.rglob("*.py") if path.stem != "__init__"
    ]
    assert sorted(listed) == sorted(there)


def test_the_snapshot_has_the_fields_that_are_listed():
    facts = Facts(scene_with(spherical_mirror()), (800, 600), (524, 576), (524, 576), "none")
    known = snapshot(
        facts,
        State(CAMERA, Half(Specification.parse("pervertex")), Half(Specification.parse("raytrace"))),
        None,
        0,
        True,
    )
    listed = GUIDE.split("For developers")[1].split("`/snapshot.json`")[1].split("\n\n")[0].split(":", 1)[1]
    assert sorted(re.findall(r"`(\w+)`", listed)) == sorted(known)


@dataclass(frozen=True)
class Strengths:
    """What a method might have.

    Parameters
    ----------
    strength : int
        How strong it is.
    kind : str
        Of which kind.
    """

    strength: int = option(3, low=1, high=9)
    kind: str = option("plain", choices=("plain", "fancy"))


def test_a_method_that_is_added_appears_with_its_options_and_is_drawn(monkeypatch):
    reference, opened = METHODS["raytrace"], []

    def open_session(view: View, options: Strengths) -> Session:
        opened.append(options)
        return reference.open(view, reference.options())

    added = Method("added", "draws as the reference does", "nowhere", Strengths, open_session, refracts=True)
    monkeypatch.setitem(METHODS, "added", added)
    hand = Hand(start_of("flat-mirror"))
    try:
        hand.click(*hand.widget("first/method"))
        hand.draw(3)
        hand.click(*hand.widget("first/method/added"))
        hand.draw(3)
        assert str(hand.viewer.state.first.method) == "added"
        hand.click(*hand.widget("first/options", 0.2))
        hand.draw(3)
        hand.click(*hand.widget("first/strength", 0.99))
        assert {"first/strength", "first/kind"} <= hand.viewer.snapshot()["rectangles"].keys()
        hand.settle()
        assert str(hand.viewer.state.first.method) == "added:strength=9" and opened[-1] == Strengths(9)
        hand.key("2")
        hand.settle()
        figures = hand.viewer.snapshot()["figures"][0]
        assert figures["other_object_percent"] == 0.0 and figures["angular_mrad"]["median"] < 0.01
    finally:
        hand.close()


@pytest.fixture(scope="module")
def shots():
    """What the script of the images makes."""
    return runpy.run_path(str(ROOT / "docs" / "make_viewer.py"))["SHOTS"]


def test_every_image_is_one_that_the_script_makes(shots):
    kept = {path.stem for path in (ROOT / "docs" / "images" / "viewer").iterdir()}
    assert kept == set(shots)
