"""Frames in steps: whole however they are cut, and a session that is left in the midst draws the next as if new."""

from __future__ import annotations

import threading
from collections.abc import Generator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import anamorph as an
from anamorph.base import compiled, steps
from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain, mapped, timed
from anamorph.frame import Frame, View
from anamorph.gallery import make
from anamorph.gpu.recording import Recorder
from anamorph.gpu.targets import read_texture
from anamorph.methods import METHODS, Session, Specification, session
from anamorph.methods.averaging import averaging
from anamorph.methods.trilinear import beams, plan, visibility
from anamorph.methods.trilinear.beams import making_beams
from anamorph.viewer.turntable import turntable

SIZE = (48, 32)
STEPPED = ("trilinear:bounces=3", "trilinear:antialias=4", "trilinear:edges=straight", "raytrace")
SCENE = make("facing-mirrors")


def opened(specification: str, scene: an.Scene = SCENE) -> Session:
    return Specification.parse(specification).open(View(scene, scene.camera, SIZE))


def seen_from(number: int) -> an.Camera:
    return replace(SCENE.camera, position=tuple(np.add(SCENE.camera.position, 0.02 * number)))


def same(one: Frame, other: Frame) -> bool:
    names = ("color", "position", "object_id", "specular", "status", "deviation")
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in names)


@pytest.fixture
def small_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """So small that a small image takes many, and always as many."""
    monkeypatch.setattr(compiled, "cores", lambda: 1)
    monkeypatch.setattr(visibility, "AT_ONCE", 3 * 8)
    monkeypatch.setattr(beams, "AT_ONCE", 3)
    monkeypatch.setattr(plan, "LARGEST_SHARE", 2)
    monkeypatch.setattr("anamorph.methods.tracing.paths.GRAIN", 100)


def whole_frame(specification: str, number: int) -> Frame:
    """Of a session that draws nothing else."""
    drawn = opened(specification)
    drawn.draw(seen_from(number))
    return drawn.frame(seen=True)


@pytest.mark.parametrize("specification", STEPPED)
def test_a_frame_is_the_same_in_however_many_steps(specification: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = whole_frame(specification, 0)
    monkeypatch.setattr(visibility, "AT_ONCE", 3 * 5)
    monkeypatch.setattr(beams, "AT_ONCE", 2)
    monkeypatch.setattr(plan, "LARGEST_SHARE", 1)
    monkeypatch.setattr("anamorph.methods.tracing.paths.GRAIN", 77)
    assert same(whole_frame(specification, 0), whole)


@pytest.mark.usefixtures("small_steps")
@pytest.mark.parametrize("specification", STEPPED)
def test_a_session_left_at_any_step_shows_the_frame_before_and_draws_the_next_as_if_new(specification: str) -> None:
    drawn = opened(specification)
    drawn.draw(seen_from(0))
    before = read_texture(drawn.texture)
    count = sum(1 for _ in opened(specification).drawing(seen_from(1)))
    assert count > 10
    for taken in (1, 2, count // 3, 2 * count // 3, count - 1):
        left = drawn.drawing(seen_from(1))
        assert sum(1 for _ in islice(left, taken)) == taken
        left.close()
        assert np.array_equal(read_texture(drawn.texture), before)
    drawn.draw(seen_from(2))
    assert same(drawn.frame(seen=True), whole_frame(specification, 2))
    again = drawn.drawing(seen_from(1))
    next(again)
    again.close()
    drawn.draw(seen_from(1), (0.25, -0.25))
    drawn.draw(seen_from(1))
    assert same(drawn.frame(seen=True), whole_frame(specification, 1))


def test_quick_methods_draw_at_once() -> None:
    for specification in ("pervertex", "environment"):
        assert not list(opened(specification).drawing(seen_from(0)))


@pytest.mark.parametrize("specification", METHODS)
def test_phases_leave_out_what_is_done_between_steps(specification: str, monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = 0.0
    for module in (session, steps):
        monkeypatch.setattr(module, "perf_counter", lambda: seconds)
    drawn = opened(specification)
    for _ in drawn.drawing(seen_from(0)):
        seconds += 10.0
    phases = dict(drawn.phases())
    assert phases == {"prepare": 0.0, "find": 0.0, "record": 0.0}


def test_the_device_s_time_is_that_of_all_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    class Clock:
        def begin(self, encoder: object) -> None: ...

        def end(self, encoder: object) -> None: ...

        def wait(self) -> float:
            return 2.0

    monkeypatch.setattr("anamorph.gpu.recording.device_timer", Clock)
    recorder = Recorder()
    for parts in (2, 0):
        encoder = recorder.begin()
        for _ in range(parts):
            encoder = recorder.part(encoder)
        recorder.submit(encoder)
        assert recorder.wait() == recorder.wait() == 2.0 * (parts + 1)


def test_a_mean_can_be_left_in_the_midst_of_an_image() -> None:
    told = list(averaging(opened("raytrace"), SCENE.camera, 2))
    assert told == sorted(told) and told[-1] == (4, 4)
    assert told.count((0, 4)) >= 1 and set(told) == {(done, 4) for done in range(5)}


@pytest.mark.usefixtures("small_steps")
def test_a_turntable_left_in_the_midst_of_an_image_leaves_nothing_behind(tmp_path: Path) -> None:
    saving = turntable(tmp_path / "round", SCENE, Specification.parse("raytrace"), [SCENE.camera] * 3, SIZE)
    told = [step for step, _ in zip(saving, range(12), strict=False)]
    saving.close()
    assert {step.done for step in told} == {0} and told[-1].total == 3
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("cores", [1, 3])
@given(count=st.integers(0, 200), grain=st.integers(1, 70), taken=st.integers(0, 250))
def test_every_piece_is_worked_on_once_and_none_after_the_end(cores: int, count: int, grain: int, taken: int) -> None:
    worked, lock, ended = np.zeros(count, int), threading.Lock(), False

    def work(start: int, stop: int) -> None:
        assert 0 < stop - start <= grain and not ended
        with lock:
            worked[start:stop] += 1

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled, "cores", lambda: cores)
        going = compiled.steps_over_all_cores(work, count, grain)
        took = sum(1 for _ in islice(going, taken))
        going.close()
    ended = True
    assert worked.max(initial=0) <= 1
    if took < taken:
        assert worked.all()


def test_a_piece_that_fails_is_told_when_no_other_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "cores", lambda: 2)
    running = 0
    lock = threading.Lock()

    def work(start: int, stop: int) -> None:
        nonlocal running
        with lock:
            running += 1
        try:
            if start == 5:
                raise AnamorphError("five")
        finally:
            with lock:
                running -= 1

    with pytest.raises(AnamorphError, match="five"):
        drain(compiled.steps_over_all_cores(work, 40, 1))
    assert running == 0


def test_what_has_begun_is_at_its_end_when_it_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "cores", lambda: 2)
    let_go, begun, done = threading.Event(), set[int](), set[int]()

    def work(start: int, stop: int) -> None:
        begun.add(start)
        let_go.wait(60.0)
        done.add(start)

    going = compiled.steps_over_all_cores(work, 40, 1)
    while not begun:
        next(going)
    threading.Timer(0.05, let_go.set).start()
    going.close()
    assert begun == done and 0 < len(done) < 40


def test_long_pieces_do_not_hold_a_step_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "cores", lambda: 2)
    let_go = threading.Event()
    going = compiled.steps_over_all_cores(lambda start, stop: let_go.wait(60.0) and None, 2, 1)
    assert sum(1 for _ in islice(going, 3)) == 3
    let_go.set()
    drain(going)


@given(st.integers(0, 12), st.integers(0, 2**32 - 1))
def test_beams_in_steps_are_those_made_at_once(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    image = np.concatenate([rng.uniform(-20.0, 70.0, (count, 3, 2)), np.ones((count, 3, 1))], axis=2)
    box = np.sort(rng.integers(0, 40, (count, 2, 2)), axis=1).reshape(count, 4)
    rays = image, rng.normal(size=(count, 3, 3)), rng.normal(size=(count, 3, 3)), box
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(beams, "AT_ONCE", 4)
        parts, _ = drain(making_beams(*rays, 0.1))
    whole, _ = drain(making_beams(*rays, 0.1))
    for name, one, other in zip(whole._fields, parts, whole, strict=True):
        assert np.array_equal(one, other), name
        assert np.asarray(one).dtype == np.asarray(other).dtype, name


def counting(ended: list[str]) -> Generator[int, None, str]:
    try:
        yield 1
        yield 2
        return "done"
    finally:
        ended.append("ended")


def test_steps_in_other_words_and_timed_end_when_they_are_left(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = 0.0
    monkeypatch.setattr(steps, "perf_counter", lambda: seconds)
    for outer in (timed, lambda inner: mapped(inner, str)):
        ended: list[str] = []
        # That nobody else holds the inner steps must not be what ends them.
        inner = counting(ended)
        going = outer(inner)
        next(going)
        going.close()
        assert ended == ["ended"]
    told: list[int] = []

    def tell(step: int) -> None:
        nonlocal seconds
        seconds += 5.0
        told.append(step)

    assert drain(timed(counting([])), tell) == ("done", 0.0)
    assert told == [1, 2]
