"""The viewer in a browser: images a second while the eye moves, how soon a slider shows, and half an hour of use.

Run it with `./run bench viewer`, or for the half hour with `./run bench viewer --minutes 30`. Chromium shows what the
command serves, on the same machine: it takes its share of the cores, as it does for whoever uses the viewer. It stands
here and not in the package because it needs what the tests of the viewer need.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from browser import Served, Tab, chromium, served, tab_of
from playwright.sync_api import sync_playwright

METHODS = ("pervertex", "raytrace", "environment", "trilinear", "pervertex:map=image", "pervertex:tolerance=0.5")

WATCH = """() => {
  const image = document.querySelector('img')
  const small = document.createElement('canvas')
  small.width = small.height = 48
  const pixels = small.getContext('2d', { willReadFrequently: true })
  let before = null
  const look = () => {
    pixels.drawImage(image, image.naturalWidth / 2 - 60, image.naturalHeight / 2 - 60, 120, 120, 0, 0, 48, 48)
    const now = pixels.getImageData(0, 0, 48, 48).data
    let difference = before === null ? 0 : 255
    if (before !== null) {
      difference = 0
      for (let place = 0; place < now.length; place++) { difference += Math.abs(now[place] - before[place]) }
      difference /= now.length
    }
    before = now
    return difference
  }
  window.arrivals = []
  window.changed = null
  image.addEventListener('load', () => {
    if (look() > 1.0) {
      window.arrivals.push(performance.now())
      window.changed = window.changed || performance.now()
    }
  })
  document.addEventListener('pointermove', () => { window.moved = performance.now() }, true)
}"""
"""Notes when an image arrives whose middle differs from that of the one before."""


CIRCLE = """([x, y, milliseconds]) => new Promise((done) => {
  window.arrivals = []
  const began = performance.now()
  const step = () => {
    const passed = performance.now() - began
    if (passed > milliseconds) {
      done(window.arrivals)
      return
    }
    const angle = passed / 400
    const place = { clientX: x + 90 * Math.sin(angle), clientY: y + 30 * Math.sin(1.3 * angle), buttons: 1 }
    const move = new PointerEvent('pointermove', { ...place, pointerId: 1, bubbles: true })
    document.querySelector('img').dispatchEvent(move)
    setTimeout(step, 16)
  }
  step()
})"""
"""Moves the held pointer about: from within the page, as a mouse would without another program's share of the cores."""


def main() -> None:
    """Measure, and print what came of it."""
    parser = argparse.ArgumentParser(prog="./run bench viewer", description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="car-mirror", help="a built-in scene with a part 'mirror' (car-mirror)")
    parser.add_argument("--size", default="800x600", help="of the image without a panel (800x600)")
    parser.add_argument("--minutes", type=float, default=0.0, help="of scripted use, watching memory and log (none)")
    arguments = parser.parse_args()
    width, height = map(int, arguments.size.split("x"))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright, chromium(playwright) as browser:
        if arguments.minutes:
            with shown(browser, Path(folder), arguments.scene, (1280, 720)) as (viewer, tab):
                use(tab, viewer, arguments.minutes)
            return
        for resolution, what in ((0.0, "as the viewer likes"), (1.0, "at full resolution")):
            view = Path(folder) / "view.toml"
            view.write_text(f'builtin = "{arguments.scene}"\n[view]\npanel = false\nresolution = {resolution}\n')
            # A line below the image belongs to the status.
            with shown(browser, Path(folder), str(view), (width, height + 24)) as (_, tab):
                measure_rate(tab, what)
        with shown(browser, Path(folder), arguments.scene, (1076, 624)) as (_, tab):
            measure_delay(tab)


@contextmanager
def shown(browser: Any, folder: Path, scene: str, size: tuple[int, int]) -> Iterator[tuple[Served, Tab]]:
    """A viewer and the tab that shows it; what it has said in its log in the end."""
    viewport = {"width": size[0], "height": size[1]}
    with served(folder, scene) as viewer:
        with tab_of(browser, viewer, viewport=viewport) as tab:
            tab.page.evaluate(WATCH)
            yield viewer, tab
        code, errors = viewer.interrupt()
        if code or errors or tab.complaints:
            print(f"ended with code {code}, having said:", errors, *tab.complaints, sep="\n")


def measure_rate(tab: Tab, what: str, seconds: float = 10.0) -> None:
    """Images a second that arrive, each other than the one before, while the eye moves all the time."""
    tab.wait_until(lambda snapshot: snapshot["at_rest"], "rest")
    size = tab.page.viewport_size
    x, y = size["width"] / 2.0, size["height"] / 2.0
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    arrivals = np.array(tab.page.evaluate(CIRCLE, [x, y, 1000.0 * seconds]))
    drawn = tab.snapshot()["image"]
    tab.page.mouse.up()
    gaps = np.diff(arrivals[arrivals > arrivals[0] + 1000.0])
    print(
        f"eye moving, {what}: {1000.0 / gaps.mean():.1f} images a second; between two {np.median(gaps):.0f} ms "
        f"(median), {np.percentile(gaps, 95):.0f} ms (95th percentile); last drawn at {drawn[0]}x{drawn[1]}"
    )


def measure_delay(tab: Tab, times: int = 20) -> None:
    """From the pointer's move on a slider to the first image that shows it."""
    delays = []
    shown = tab.wait_until(lambda snapshot: "mirror/swivel" in snapshot["rectangles"], "the panel")
    left, top, right, bottom = shown["rectangles"]["mirror/swivel"]
    for number in range(times):
        tab.wait_until(lambda snapshot: snapshot["at_rest"], "rest")
        middle, y = (left + right) / 2.0, (top + bottom) / 2.0
        tab.page.mouse.move(middle, y)
        tab.page.mouse.down()
        tab.page.wait_for_timeout(300)
        tab.wait_until(lambda snapshot: snapshot["at_rest"], "rest")
        tab.page.wait_for_timeout(700)
        tab.page.evaluate("window.changed = null")
        tab.page.mouse.move(middle + (8 if number % 2 else -8), y)
        tab.page.wait_for_timeout(1000)
        delays.append(tab.page.evaluate("window.changed - window.moved"))
        tab.page.mouse.up()
    print(f"slider to image: {np.median(delays):.0f} ms (median), {max(delays):.0f} ms (largest of {times})")


def use(tab: Tab, viewer: Served, minutes: float) -> None:
    """Do this and that, and tell every minute what memory the viewer takes, in the state in which it began."""
    chance = random.Random(1)
    size = tab.page.viewport_size
    started, said = time.monotonic(), 0.0
    while (passed := time.monotonic() - started) < 60.0 * minutes:
        if passed >= said:
            tab.page.set_viewport_size(size)
            tab.key("Escape")
            tab.key("Shift+R")
            frames = tab.wait_until(lambda snapshot: snapshot["at_rest"], "rest")["frames"]
            print(f"{passed / 60.0:5.1f} min: {memory(viewer.process.pid):7.1f} MiB, {frames} frames", flush=True)
            said += 60.0
        act(tab, chance)


def act(tab: Tab, chance: random.Random) -> None:
    """One thing that a user does."""
    page = tab.page
    width, height = page.viewport_size["width"], page.viewport_size["height"]
    kind = chance.randrange(10)
    if kind < 4:
        x, y = chance.uniform(0.5, 0.9) * width, chance.uniform(0.2, 0.8) * height
        page.mouse.move(x, y)
        page.mouse.down(button=chance.choice(["left", "left", "right", "middle"]))
        for _ in range(30):
            x, y = x + chance.uniform(-9, 9), y + chance.uniform(-6, 6)
            page.mouse.move(x, y)
            page.wait_for_timeout(16)
        for button in ("left", "right", "middle"):
            page.mouse.up(button=button)
        if chance.random() < 0.5:
            tab.key("r")
    elif kind < 6:
        places = [place for name, place in seen_widgets(tab).items() if name.startswith(("mirror/", "eye/", "first/"))]
        if places:
            drag(page, chance.choice(places), chance.uniform(-40, 40))
    elif kind == 6:
        tab.key(chance.choice(["s", "m", "Shift+M", "x", "1", "2", "3", "u", "e", "o", "w", "h", "v", "b"]))
    elif kind == 7:
        tab.click(chance.uniform(0.4, 0.9) * width, chance.uniform(0.2, 0.8) * height)
    elif kind == 8:
        page.set_viewport_size(
            chance.choice(
                [{"width": 1076, "height": 624}, {"width": 1280, "height": 720}, {"width": 900, "height": 700}]
            )
        )
    elif chance.random() < 0.3:
        page.reload()
        tab.wait_for_image()
    else:
        tab.key("Shift+R")
    page.wait_for_timeout(chance.choice([50, 400, 1500]))


def seen_widgets(tab: Tab) -> dict[str, tuple[float, float]]:
    """The middles of the panel's widgets that are not scrolled away."""
    found = tab.snapshot()["rectangles"]
    if "panel/body" not in found:
        return {}
    top, bottom = found["panel/body"][1], found["panel/body"][3]
    middles = {name: ((box[0] + box[2]) / 2.0, (box[1] + box[3]) / 2.0) for name, box in found.items()}
    return {name: (x, y) for name, (x, y) in middles.items() if top < y < bottom and name != "panel/body"}


def drag(page: Any, start: tuple[float, float], right: float) -> None:
    """Drag to the right, or to the left, slowly enough to be seen."""
    x, y = start
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(x + right * step / 8.0, y)
        page.wait_for_timeout(30)
    page.mouse.up()


def memory(process: int) -> float:
    """What a process holds in memory, MiB."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmRSS"))


if __name__ == "__main__":
    main()
