"""The viewer in a window, on a display of its own."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import HOME, PATIENCE, wait_until

needs_display = pytest.mark.skipif(
    not (shutil.which("Xvfb") and shutil.which("xdotool")), reason="there is no Xvfb or xdotool; see `screens` in ./run"
)
SCREEN = (1100, 700)


class Display:
    """A screen in memory; Xvfb keeps its pixels in a file."""

    def __init__(self, name: str, file: Path) -> None:
        self.environment = {**os.environ, "DISPLAY": name, "PYTHONPATH": str(HOME)}
        self.environment.pop("WAYLAND_DISPLAY", None)
        self._file = file

    def image(self) -> np.ndarray:
        """(H, W, 3) uint8. The file is a window dump: a header of big-endian words, a colour map, and BGRX pixels."""
        data = self._file.read_bytes()
        header = np.frombuffer(data, ">u4", 25)
        width, height, line = int(header[4]), int(header[5]), int(header[12])
        start = int(header[0]) + 12 * int(header[19])
        rows = np.frombuffer(data, np.uint8, height * line, start).reshape(height, line // 4, 4)
        return rows[:, :width, 2::-1]

    def do(self, *arguments: object) -> str:
        """Have xdotool do something; what it says."""
        command = ["xdotool", *map(str, arguments)]
        done = subprocess.run(command, env=self.environment, capture_output=True, text=True, timeout=PATIENCE)
        return done.stdout


@pytest.fixture
def display(tmp_path: Path) -> Iterator[Display]:
    reading, writing = os.pipe()
    size = f"{SCREEN[0]}x{SCREEN[1]}x24"
    command = ["Xvfb", "-displayfd", str(writing), "-screen", "0", size, "-nolisten", "tcp", "-fbdir", str(tmp_path)]
    # Else it starts over whenever its last client leaves, such as one that looks for a window before there is any, and
    # then loses who is about to come: the viewer would find no display, and serve a page.
    command.append("-noreset")
    server = subprocess.Popen(command, pass_fds=[writing], stderr=subprocess.DEVNULL)
    os.close(writing)
    try:
        with os.fdopen(reading) as told:
            name = told.readline().strip()
        yield Display(f":{name}", tmp_path / "Xvfb_screen0")
    finally:
        server.kill()
        server.wait()


@needs_display
def test_a_window_opens_follows_the_mouse_and_closes(display, tmp_path):
    # a process whose interrupts are ignored, as in the background of a script, would have them ignored here too
    program = (
        "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from anamorph.__main__ import main; sys.exit(main())"
    )
    errors = tmp_path / "errors.txt"
    with errors.open("w") as file:
        process = subprocess.Popen(
            [sys.executable, "-c", program, "view", "flat-mirror", "-m", "environment"],
            stderr=file,
            env=display.environment,
            cwd=tmp_path,
        )

    def found() -> str:
        assert process.poll() is None, errors.read_text()
        return display.do("search", "--name", "flat-mirror - Anamorph").strip()

    try:
        window = wait_until(found, "a window")
        geometry = display.do("getwindowgeometry", "--shell", window)
        assert f"WIDTH={SCREEN[0]}\n" in geometry, "the window fits the screen, which is narrower than it would be"

        def scene() -> np.ndarray:
            return display.image()[50:550, 320:].astype(float)

        wait_until(lambda: scene().std() > 20.0, "an image")
        before = scene()
        display.do("mousemove", 600, 300, "mousedown", 1)
        display.do("mousemove", 720, 330)
        display.do("mousemove", 760, 340, "mouseup", 1)
        wait_until(lambda: np.mean(np.abs(scene() - before).max(-1) > 24.0) > 0.05, "another image")

        display.do("windowsize", "--sync", window, 800, 600)
        # beside the window, the screen is bare; in its lower right corner, the status line says how to get help
        wait_until(lambda: display.image()[:, 810:].std() == 0.0, "the smaller window")
        wait_until(lambda: display.image()[580:600, 600:800].std() > 5.0, "its image")
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 0
        said = errors.read_text()
        assert said == "", said
    finally:
        process.kill()
        process.wait()


def without_display(*arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [sys.executable, "-m", "anamorph", "view", "flat-mirror", *arguments]
    environment["PYTHONPATH"] = str(HOME)
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=PATIENCE)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere a display is always there")
def test_without_a_display_a_window_is_refused_in_one_line():
    result = without_display("--backend", "desktop")
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith("anamorph: error: --backend desktop: ")
    assert "--backend browser" in result.stderr
    assert result.stderr.count("\n") == 1
