"""The viewer in Chromium: every effect is looked for in the pixels of the page, or in what the viewer reports."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from browser import Served, Tab, chromium, needs_chromium, served, tab_of, wait_until

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def playwright():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as running:
        yield running


@pytest.fixture(scope="module")
def browser(playwright):
    with chromium(playwright) as running:
        yield running


def inside(image: np.ndarray, rectangle: list[float]) -> np.ndarray:
    left, top, right, bottom = (round(edge) for edge in rectangle)
    return image[top:bottom, left:right].astype(float)


def changed(before: np.ndarray, after: np.ndarray) -> float:
    """The share of pixels that differ by more than the loss of a JPEG file."""
    return float(np.mean(np.abs(before.astype(float) - after).max(-1) > 24.0))


def test_the_divider_a_slider_the_method_and_a_click_do_what_they_are_for(browser, tmp_path):
    with served(tmp_path, "flat-mirror") as viewer, tab_of(browser, viewer) as tab:
        snapshot = tab.wait_until(lambda snapshot: snapshot["at_rest"], "rest")
        assert tab.page.url == viewer.page
        assert tab.page.title() == "flat-mirror - Anamorph"
        assert snapshot["size"] == [1000, 640]
        view = [snapshot["rectangles"]["panel"][2], 0.0, 1000.0, 600.0]
        at_first = tab.image()
        assert inside(at_first, view).std() > 20.0

        tab.click(*tab.center("first/method"))
        tab.wait_until(lambda snapshot: "first/method/environment" in snapshot["rectangles"], "the list of methods")
        tab.click(*tab.center("first/method/environment"))
        tab.wait_until(lambda snapshot: snapshot["state"]["first"]["method"] == "environment" and snapshot["at_rest"])
        wait_until(lambda: changed(inside(at_first, view), inside(tab.image(), view)) > 0.02, "another image")

        tab.key("s")
        snapshot = tab.wait_until(lambda snapshot: snapshot["state"]["split"] and "divider" in snapshot["rectangles"])
        tab.wait_until(lambda snapshot: snapshot["at_rest"], "rest")
        split = tab.image()
        x, y = tab.center("divider")
        tab.drag((x, y), (x + 150.0, y))
        snapshot = tab.wait_until(lambda snapshot: snapshot["state"]["divider"] > 0.6 and snapshot["at_rest"])
        assert tab.center("divider")[0] == pytest.approx(x + 150.0, abs=2.0)
        # what lies between the old place and the new one is now drawn by the environment map, and nothing else is
        between = [x + 10.0, 0.0, x + 140.0, 560.0]
        wait_until(lambda: changed(inside(split, between), inside(tab.image(), between)) > 0.02, "the other half")
        beyond = [x + 180.0, 0.0, 1000.0, 560.0]
        assert changed(inside(split, beyond), inside(tab.image(), beyond)) < 0.01

        before = tab.image()
        x, y = tab.center("mirror/swivel")
        tab.drag((x, y), (x + 40.0, y))
        tab.wait_until(lambda snapshot: snapshot["state"]["values"].get("mirror/swivel") and snapshot["at_rest"])
        wait_until(lambda: changed(inside(before, beyond), inside(tab.image(), beyond)) > 0.05, "a turned mirror")

        tab.click(900.0, 330.0)
        snapshot = tab.wait_until(lambda snapshot: snapshot["inspection"], "what is seen there")
        assert snapshot["inspection"]["method"] == "raytrace"
        assert snapshot["state"]["picked"] == pytest.approx(
            [(900.0 - view[0]) / (1000.0 - view[0]), 330.0 / 616.0], abs=0.01
        )
        assert tab.complaints == []
        assert viewer.interrupt() == (0, "")


def test_another_scene_is_opened_from_the_keyboard_and_the_page_is_called_after_it(browser, tmp_path):
    with served(tmp_path, "flat-mirror") as viewer, tab_of(browser, viewer) as tab:
        tab.wait_until(lambda snapshot: snapshot["at_rest"], "rest")
        before = tab.image()
        press = "new KeyboardEvent('keydown', { key: 'o', ctrlKey: true, cancelable: true })"
        assert tab.page.evaluate(f"!window.dispatchEvent({press})"), "the browser would open a file of its own"
        tab.page.keyboard.press("Control+o")
        snapshot = tab.wait_until(
            lambda snapshot: "opening/path" in snapshot["rectangles"], "the page that opens scenes"
        )
        tab.wait_until(lambda now: now["frames"] > snapshot["frames"] + 2 or now["at_rest"])
        tab.page.keyboard.type("sphere")
        tab.wait_until(lambda snapshot: snapshot["state"]["opening"] == "sphere", "what is typed")
        assert (
            tab.snapshot()["state"]["samples"] == snapshot["state"]["samples"] and not tab.snapshot()["state"]["split"]
        )
        tab.key("Enter")
        tab.wait_until(lambda snapshot: "spheres" in snapshot["message"], "a name that is near")
        assert tab.page.title() == "flat-mirror - Anamorph"
        tab.click(*tab.center("opening/spheres"))
        tab.wait_until(lambda snapshot: snapshot["scene"] == "spheres" and snapshot["at_rest"], "the other scene")
        wait_until(lambda: tab.page.title() == "spheres - Anamorph", "its title")
        view = [300.0, 60.0, 1000.0, 600.0]
        wait_until(lambda: changed(inside(before, view), inside(tab.image(), view)) > 0.5, "its image")
        tab.page.reload()
        tab.wait_for_image()
        assert tab.page.title() == "spheres - Anamorph"
        assert tab.complaints == []
        assert viewer.interrupt() == (0, "")


def test_the_image_follows_the_window_and_the_tab_that_controls_it(browser, tmp_path):
    with served(tmp_path, "flat-mirror") as viewer, tab_of(browser, viewer, has_touch=True) as tab:
        tab.wait_until(lambda snapshot: snapshot["size"] == [1000, 640])
        tab.page.set_viewport_size({"width": 640, "height": 400})
        tab.wait_until(lambda snapshot: snapshot["size"] == [640, 400])
        page = "[document.scrollingElement.scrollWidth, document.scrollingElement.scrollHeight]"
        assert tab.page.evaluate(page) == [640, 400]
        assert tab.page.evaluate("getComputedStyle(document.querySelector('img')).touchAction") == "none"
        assert tab.page.get_by_role("img").get_attribute("alt")
        tab.key("Tab")
        tab.wait_until(lambda snapshot: "panel/show" in snapshot["rectangles"])
        tab.tap(*tab.center("panel/show"))
        tab.wait_until(lambda snapshot: snapshot["state"]["panel"])

        second = another_tab(tab, viewer, 500, 300)
        second.wait_for_selector("text=Watching")
        assert tab.snapshot()["size"] == [640, 400]
        tab.page.close()
        second.wait_for_selector("#status:empty", state="attached")
        tab.wait_until(lambda snapshot: snapshot["size"] == [500, 300])
        second.close()
        third = another_tab(tab, viewer, 520, 320)
        tab.wait_until(lambda snapshot: snapshot["size"] == [520, 320])
        assert viewer.interrupt() == (0, "")
        third.wait_for_selector("text=Disconnected")


def another_tab(tab: Tab, viewer: Served, width: int, height: int) -> Any:
    page = tab.page.context.new_page()
    page.set_viewport_size({"width": width, "height": height})
    page.goto(viewer.page)
    return page


def test_a_fine_screen_gets_its_own_pixels(playwright, tmp_path):
    flags = "--force-device-scale-factor=2", "--window-size=700,500"
    with (
        chromium(playwright, *flags) as browser,
        served(tmp_path, "flat-mirror") as viewer,
        tab_of(browser, viewer, viewport=None, no_viewport=True) as tab,
    ):
        width, height = tab.page.evaluate("[window.innerWidth, window.innerHeight]")
        snapshot = tab.wait_until(lambda snapshot: snapshot["size"] == [width, height])
        assert snapshot["full"][1] == 2 * (height - 24)
        wait_until(lambda: tab.page.evaluate("document.querySelector('img').naturalWidth") == 2 * width, "its pixels")


def test_two_fingers_pan_and_zoom_and_one_scrolls_the_panel(browser, tmp_path):
    with served(tmp_path, "flat-mirror") as viewer, tab_of(browser, viewer, has_touch=True) as tab:
        fingers = tab.page.context.new_cdp_session(tab.page)

        def touch(kind: str, *places: float, y: float = 300.0) -> None:
            points = [{"x": x, "y": y, "id": number} for number, x in enumerate(places)]
            fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        def distance(camera: dict[str, Any]) -> float:
            return float(np.linalg.norm(np.subtract(camera["position"], camera["target"])))

        before = tab.wait_until(lambda snapshot: snapshot["at_rest"])["state"]["camera"]
        touch("touchStart", 600.0)
        touch("touchStart", 600.0, 700.0)
        for spread in range(10, 60, 10):
            touch("touchMove", 600.0 - spread, 700.0 + spread)
        after = tab.wait_until(lambda snapshot: distance(snapshot["state"]["camera"]) < 0.6 * distance(before))
        turned = [np.subtract(camera["position"], camera["target"]) for camera in (before, after["state"]["camera"])]
        assert np.dot(*turned) == pytest.approx(np.prod([np.linalg.norm(each) for each in turned])), "it does not orbit"
        touch("touchEnd", 550.0)
        touch("touchEnd")
        snapshot = tab.wait_until(lambda snapshot: snapshot["at_rest"])
        assert snapshot["state"]["picked"] is None

        x, y = tab.center("section/scene")
        touch("touchStart", x, y=y)
        for up in range(10, 110, 10):
            touch("touchMove", x, y=y - up)
        touch("touchEnd")
        tab.wait_until(
            lambda snapshot: snapshot["rectangles"]["section/scene"][3] < y - 50.0, "another part of the panel"
        )
        assert tab.center("section/scene")[1] >= y - 100.0
        assert tab.snapshot()["state"] == snapshot["state"], "and all else stays as it was"
        assert "mirror/swivel" in tab.snapshot()["rectangles"]
        place = tab.center("mirror/tilt")
        # Two taps are a double tap within half a second; a machine that is busy may need more of them.
        for _ in range(6):
            frames = tab.snapshot()["frames"]
            tab.tap(*place)
            tab.tap(*place)
            # Until they have been drawn that show it, keys have another meaning.
            tab.wait_until(lambda snapshot, before=frames: snapshot["frames"] >= before + 8, "the taps")
            tab.page.keyboard.type("3.5")
            tab.key("Enter")
            frames = tab.snapshot()["frames"]
            values = tab.wait_until(lambda snapshot, before=frames: snapshot["frames"] >= before + 4)["state"]["values"]
            if values.get("mirror/tilt") == 3.5:
                break
        assert values.get("mirror/tilt") == 3.5
        assert tab.complaints == []
        assert viewer.interrupt() == (0, "")
