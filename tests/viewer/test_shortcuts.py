"""What the keys do."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest
from scenes import CAMERA, scene_with, spherical_mirror
from viewer_hand import home_of

from anamorph import gallery
from anamorph.methods import METHODS, Specification
from anamorph.methods.protocol import Method
from anamorph.scene.camera import Camera
from anamorph.viewer.facts import Request
from anamorph.viewer.navigation import orbit, zoom
from anamorph.viewer.observer import first_observer
from anamorph.viewer.shortcuts import NEARER, SHORTCUTS, TURN, press
from anamorph.viewer.starting import reset_view
from anamorph.viewer.state import Aspect, Drawing, EyeSide, Half, State

STATE = State(
    CAMERA, Half(Specification.parse("pervertex:field=60"), Aspect.ERROR), Half(Specification.parse("raytrace"))
)
HOME = home_of(STATE, scene_with(spherical_mirror()))
MOVED = replace(STATE, camera=Camera((2.0, 1.0, 2.0), (0.0, 0.5, 0.0)))


def key(name, *modifiers):
    return {"event_type": "key_down", "key": name, "modifiers": modifiers}


def after(name, *modifiers, state=STATE, home=HOME):
    changed, requests = press(key(name, *modifiers), state, home)
    assert requests == ()
    return changed


@pytest.mark.parametrize(
    ("event", "change"),
    [
        (key("F1"), {"help": True}),
        (key("?"), {"help": True}),
        (key("?", "Shift"), {"help": True}),
        (key("/", "Shift"), {"help": True}),
        (key("Tab"), {"panel": False}),
        (key("o", "Control"), {"opening": ""}),
        (key("o", "Meta"), {"opening": ""}),
        (key("s"), {"split": True}),
        (key("x"), {"first": STATE.second, "second": STATE.first}),
        (key("k"), {"views": (CAMERA,)}),
        (key("u"), {"unit": "px"}),
        (key("w"), {"drawings": {Drawing.WIREFRAME}}),
        (key("h"), {"drawings": {Drawing.HITS}}),
        (key("v"), {"drawings": {Drawing.VIEWPOINT}}),
        (key("b"), {"drawings": {Drawing.VOLUME}}),
        (key("B"), {"drawings": {Drawing.VOLUME}}),
        (key("1"), {"first": Half(Specification.parse("pervertex:field=60"), Aspect.IMAGE)}),
        (key("2"), {}),
        (key("3"), {"first": Half(Specification.parse("pervertex:field=60"), Aspect.STATUS)}),
        (key("4"), {"second": Half(Specification.parse("raytrace"), Aspect.IMAGE), "split": True}),
        (key("5"), {"second": Half(Specification.parse("raytrace"), Aspect.ERROR), "split": True}),
        (key("6"), {"second": Half(Specification.parse("raytrace"), Aspect.STATUS), "split": True}),
        (key("ArrowLeft"), {"camera": orbit(CAMERA, -TURN, 0.0)}),
        (key("ArrowRight"), {"camera": orbit(CAMERA, TURN, 0.0)}),
        (key("ArrowUp"), {"camera": orbit(CAMERA, 0.0, TURN)}),
        (key("ArrowDown"), {"camera": orbit(CAMERA, 0.0, -TURN)}),
        (key("+", "Shift"), {"camera": zoom(CAMERA, NEARER)}),
        (key("="), {"camera": zoom(CAMERA, NEARER)}),
        (key("=", "Shift"), {"camera": zoom(CAMERA, NEARER)}),
        (key("-"), {"camera": zoom(CAMERA, 1.0 / NEARER)}),
        (key("q"), {}),
        (key("s", "Alt"), {}),
        (key("x", "Control"), {}),
        (key("Shift", "Shift"), {}),
        ({"event_type": "key_down"}, {}),
    ],
)
def test_a_key_changes_one_thing(event, change):
    changed, requests = press(event, STATE, HOME)
    assert changed == replace(STATE, **change) and requests == ()


@pytest.mark.parametrize("name", ["F1", "Tab", "s", "x", "u", "w", "o"])
def test_the_same_key_again_undoes_it(name):
    assert after(name) != STATE
    assert after(name, state=after(name)) == STATE


def test_saving_is_asked_for_and_changes_nothing():
    for event, request in [
        (key("p"), Request.SAVE_IMAGE),
        (key("s", "Control"), Request.SAVE_SCENE),
        (key("s", "Meta"), Request.SAVE_SCENE),
    ]:
        assert press(event, STATE, HOME) == (STATE, (request,))


def test_methods_follow_each_other_and_keep_their_layer():
    state, seen = STATE, []
    for _ in METHODS:
        state = after("m", state=state)
        seen.append(state.first.method.method.name)
        assert state.first.aspect is Aspect.ERROR and not state.split
    assert sorted(seen) == sorted(METHODS) and seen[-1] == "pervertex"
    second = after("M", "Shift")
    assert second == replace(STATE, second=Half(Specification.parse("environment")), split=True)
    assert after("M") == after("m"), "caps lock is no shift"


def test_methods_that_cannot_draw_the_scene_are_passed_over():
    lens = home_of(STATE, gallery.make("magnifier"))
    assert lens.methods == tuple(name for name, method in METHODS.items() if method.refracts) != HOME.methods
    state = STATE
    for _ in METHODS:
        state = after("m", state=state, home=lens)
        assert state.first.method.method.refracts
    lost = replace(STATE, first=Half(Specification.parse("environment")))
    assert after("m", state=lost, home=lens).first.method.method.name == lens.methods[0]


@dataclass(frozen=True)
class Nothing:
    """Of a method that has no options."""


def test_a_method_that_comes_later_appears(monkeypatch):
    last = list(METHODS)[-1]
    monkeypatch.setitem(METHODS, "another", Method("another", "", "", Nothing, lambda view, options: None))
    assert after("m", state=replace(STATE, first=Half(Specification.parse(last)))).first.method.method.name == "another"


def test_the_eyes_take_turns():
    state, seen = STATE, []
    for _ in EyeSide:
        state = after("e", state=state)
        seen.append(state.eye)
    assert set(seen) == set(EyeSide) and state == STATE


def test_escape_closes_help_before_it_drops_the_point():
    state = replace(STATE, help=True, picked=(0.5, 0.5))
    first = after("Escape", state=state)
    assert first == replace(state, help=False)
    assert after("Escape", state=first) == STATE


@pytest.mark.parametrize("name", ["r", "Home"])
def test_the_view_resets_alone(name):
    state = replace(MOVED, split=True, values={"a": 1.0}, observer=None)
    assert after(name, state=state) == replace(state, camera=CAMERA)
    outside = replace(state, observer=Camera((9.0, 9.0, 9.0), (0.0, 0.0, 0.0)))
    assert after(name, state=outside).observer == first_observer(HOME.scene, CAMERA)
    assert reset_view(STATE, HOME) == STATE


def test_everything_resets_but_the_panel():
    state = replace(MOVED, panel=False, split=True, divider=0.9, values={"a": 1.0}, unit="px", picked=(0.1, 0.2))
    state = replace(state, views=(CAMERA, MOVED.camera))
    assert after("R", "Shift", state=state) == replace(STATE, panel=False)


def test_from_outside_keys_move_the_observer():
    outside = after("o", state=MOVED)
    assert outside == replace(MOVED, observer=first_observer(HOME.scene, MOVED.camera))
    assert after("ArrowLeft", state=outside) == replace(outside, observer=orbit(outside.observer, -TURN, 0.0))


def test_no_two_shortcuts_share_a_key_and_each_does_something():
    keys = [each for shortcut in SHORTCUTS for each in shortcut.keys]
    assert len(set(keys)) == len(keys)
    assert all(shortcut.summary and shortcut.group for shortcut in SHORTCUTS)
    assert all((shortcut.change is None) is not (shortcut.request is None) for shortcut in SHORTCUTS)
    groups = [shortcut.group for shortcut in SHORTCUTS]
    assert groups == sorted(groups, key=groups.index), "those of one heading stand together"
