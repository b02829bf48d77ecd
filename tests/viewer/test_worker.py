"""Work beside the drawing: one piece after the other, and of those that wait only the last."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event

import pytest

from anamorph.viewer.worker import Worker

PATIENCE = 60.0
"""Seconds until work is taken to hang, on however busy a machine."""


def test_work_is_done_once_for_equal_keys():
    worker, done = Worker[int](), []

    def work() -> int:
        done.append(1)
        return len(done)

    assert [worker.get(("a", 1), work, PATIENCE) for _ in range(3)] == [1, 1, 1]
    assert worker.get(("a", 2), work, PATIENCE) == 2 and not worker.busy


def test_who_waits_goes_on_without_and_of_what_was_asked_for_meanwhile_the_last_is_done():
    worker, go, done = Worker[str](), Event(), []

    def work(name: str) -> Callable[[], str]:
        def waits() -> str:
            assert go.wait(PATIENCE)
            done.append(name)
            return name

        return waits

    for name in ("first", "second", "third"):
        assert worker.get(name, work(name), 0.0) is None and worker.busy
    go.set()
    while (found := worker.get("third", work("third"), PATIENCE)) is None:
        assert worker.busy
    assert found == "third" and done == ["first", "third"] and not worker.busy


def test_a_failure_is_raised_once_and_other_work_is_done_after_it():
    worker = Worker[int]()
    with pytest.raises(ZeroDivisionError):
        worker.get("bad", lambda: 1 // 0, PATIENCE)
    assert worker.get("bad", lambda: 1 // 0, PATIENCE) is None and not worker.busy
    assert worker.get("good", lambda: 1, PATIENCE) == 1
