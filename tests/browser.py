"""The viewer in a browser, as its user has it: the command starts it, and Chromium opens the link that it prints."""

from __future__ import annotations

import io
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import anamorph

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium; see `screens` in ./run")

FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
HOME = Path(anamorph.__file__).resolve().parents[1]
PATIENCE = 300.0
"""Seconds for what takes one or two on a machine that does nothing else."""


def wait_until(happened: Callable[[], Any], what: str = "what was waited for") -> Any:
    """What `happened` returns, as soon as that is true."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        if value := happened():
            return value
        time.sleep(0.05)
    raise AssertionError(f"{what} did not happen")


@dataclass
class Served:
    """A viewer that runs: its process, the link that it printed, and where it writes errors."""

    process: subprocess.Popen[str]
    link: str
    errors: Path

    @property
    def page(self) -> str:
        """Its address; what else is served is found from there."""
        return self.link.split("?")[0]

    @property
    def origin(self) -> str:
        return "/".join(self.link.split("/")[:3])

    @property
    def port(self) -> int:
        return int(self.origin.rsplit(":", 1)[1])

    def interrupt(self) -> tuple[int, str]:
        """End it as Ctrl-C does; its exit code, and all that it has said of errors."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(PATIENCE), self.errors.read_text()


@contextmanager
def served(directory: Path, *arguments: str) -> Iterator[Served]:
    """Run `anamorph view` with these arguments, in a directory where it may save files."""
    path = os.pathsep.join([str(HOME), *filter(None, [os.environ.get("PYTHONPATH")])])
    errors = directory / "errors.txt"
    with errors.open("w") as file:
        process = subprocess.Popen(
            [sys.executable, "-m", "anamorph", "view", *arguments, "--backend", "browser", "--port", "0"],
            stdout=subprocess.PIPE,
            stderr=file,
            text=True,
            cwd=directory,
            env={**os.environ, "PYTHONPATH": path},
        )
    try:
        assert process.stdout is not None
        said = re.search(r"http\S+", process.stdout.readline())
        assert said, errors.read_text()
        yield Served(process, said[0], errors)
    finally:
        process.kill()
        process.communicate()


class Tab:
    """A tab with the viewer; places are in logical pixels of the page, which are the canvas's."""

    def __init__(self, page: Any, address: str) -> None:
        self.page, self._address = page, address
        self.complaints: list[str] = []
        page.set_default_timeout(1000 * PATIENCE)
        page.on("console", lambda message: self.complaints.append(message.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))

    def wait_for_image(self) -> None:
        self.page.wait_for_selector("img[src^='blob:']")

    def snapshot(self) -> dict[str, Any]:
        return self.page.context.request.get(f"{self._address}snapshot.json").json()

    def wait_until(
        self, predicate: Callable[[dict[str, Any]], Any], what: str = "what was waited for"
    ) -> dict[str, Any]:
        """The first report for which `predicate` is true."""

        def look() -> dict[str, Any] | None:
            snapshot = self.snapshot()
            return snapshot if predicate(snapshot) else None

        return wait_until(look, what)

    def image(self) -> np.ndarray:
        """What is on the screen, (H, W, 3) uint8."""
        return np.asarray(Image.open(io.BytesIO(self.page.screenshot())).convert("RGB"))

    def center(self, name: str) -> tuple[float, float]:
        """Of a widget, by its name in the report, once it stays where it is."""

        def place() -> Any:
            return self.snapshot()["rectangles"].get(name)

        def settled() -> Any:
            before = place()
            time.sleep(0.15)
            return before if before == place() else None

        left, top, right, bottom = wait_until(settled, f"'{name}'")
        return (left + right) / 2.0, (top + bottom) / 2.0

    def click(self, x: float, y: float) -> None:
        self.page.mouse.click(x, y)

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down()
        self._drawn_again()
        mouse.move(*end, steps=4)
        self._drawn_again()
        mouse.up()

    def wheel(self, x: float, y: float, down: float) -> None:
        self.page.mouse.move(x, y)
        self.page.mouse.wheel(0.0, down)

    def key(self, name: str) -> None:
        self.page.keyboard.press(name)

    def tap(self, x: float, y: float) -> None:
        self.page.touchscreen.tap(x, y)

    def _drawn_again(self) -> None:
        frames = self.snapshot()["frames"]
        self.wait_until(lambda snapshot: snapshot["frames"] > frames + 1, "another image")


@contextmanager
def chromium(playwright: Any, *flags: str) -> Iterator[Any]:
    """A headless Chromium with a fresh profile."""
    browser = playwright.chromium.launch(executable_path=CHROMIUM, headless=True, args=[*FLAGS, *flags])
    try:
        yield browser
    finally:
        browser.close()


@contextmanager
def tab_of(browser: Any, viewer: Served, **context: Any) -> Iterator[Tab]:
    """Open the link in a profile of its own, with options for that; a next tab there opens `viewer.page`."""
    profile = browser.new_context(**{"viewport": {"width": 1000, "height": 640}, **context})
    tab = Tab(profile.new_page(), viewer.page)
    tab.page.goto(viewer.link)
    tab.wait_for_image()
    yield tab
    profile.close()
