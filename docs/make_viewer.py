"""Makes the images of viewer.md: `.venv/bin/python docs/make_viewer.py [--size WxH] [--folder FOLDER] [NAME ...]`.

The viewer itself runs on a canvas without a screen, and a hand does what is shown: it clicks, drags, turns the wheel
and presses keys.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from viewer_hand import Hand

from anamorph.base.output import whole_file
from anamorph.viewer.starting import start_of

IMAGES = Path(__file__).resolve().parent / "images" / "viewer"
NOTCH = 100.0
"""What a wheel tells of one of its steps."""


def as_opened(hand: Hand) -> None:
    """Nothing is done."""


def errors(hand: Hand) -> None:
    """The error beside the reference, with the divider dragged a little to the right."""
    press(hand, "s", "2")
    hand.drag(hand.place(0.5, 0.2), hand.place(0.55, 0.2))


def turned(hand: Hand) -> None:
    """The mirror swivelled and bent."""
    set_slider(hand, "mirror/swivel", 0.55)
    set_slider(hand, "mirror/curvature", 0.75)


def ground(hand: Hand) -> None:
    """The lens made stronger, of denser glass, and held against the reference."""
    set_slider(hand, "lens/power", 0.15)
    set_slider(hand, "lens/index", 0.6)
    press(hand, "s")


def status(hand: Hand) -> None:
    """How each pixel got its value, beside the reference."""
    press(hand, "s", "3")


def outside(hand: Hand) -> None:
    """Looked into a pixel, and then from outside, with all that is drawn into space."""
    hand.click(*hand.place(0.45, 0.45))
    hand.settle()
    press(hand, "o", "w", "h", "v", "b")


def reflections(hand: Hand) -> None:
    """A point at the foot of a pillar behind the ring, which shows it four times."""
    press(hand, "i")
    hand.click(*hand.place(0.4846, 0.4404))
    hand.settle(lambda snapshot: snapshot["reflections"])


def counts(hand: Hand) -> None:
    """How often each vertex is seen."""
    press(hand, "7")


def keys(hand: Hand) -> None:
    """Every key and gesture."""
    press(hand, "F1")


SHOTS: dict[str, tuple[str, str, Callable[[Hand], None]]] = {
    "car-mirror": ("car-mirror", "pervertex", as_opened),
    "errors": ("car-mirror", "pervertex", errors),
    "turned": ("car-mirror", "pervertex", turned),
    "lens": ("spectacles-minus", "pervertex", ground),
    "status": ("car-mirror", "pervertex:tolerance=0.5", status),
    "outside": ("spectacles-minus", "pervertex", outside),
    "reflections": ("torus", "raytrace", reflections),
    "counts": ("torus", "raytrace", counts),
    "help": ("car-mirror", "pervertex", keys),
}
"""Scene, method and what is done of each image."""


def press(hand: Hand, *names: str) -> None:
    """Press keys, one after the other."""
    for name in names:
        hand.key(name)


def set_slider(hand: Hand, key: str, share: float) -> None:
    """Scroll the panel until a slider is in sight, and press it at a share of its width."""
    left, top, right, bottom = hand.viewer.snapshot()["rectangles"]["panel/body"]
    while not top < (y := hand.widget(key)[1]) < bottom:
        hand.send("wheel", x=right - 4.0, y=(top + bottom) / 2.0, dx=0.0, dy=float(np.copysign(NOTCH, y - top)))
        hand.draw(2)
    hand.click(*hand.widget(key, share))
    # What is under a pointer at rest is explained over the image.
    hand.send("pointer_move", x=left, y=1.0, button=0)
    hand.settle()


def shot(name: str, size: tuple[int, int]) -> np.ndarray:
    """The whole canvas at rest, once its hand has done what it does, (H, W, 3) uint8."""
    scene, method, act = SHOTS[name]
    hand = Hand(start_of(scene, method), size)
    try:
        hand.settle()
        act(hand)
        return hand.settle()
    finally:
        hand.close()


def main() -> None:
    """Make them all, or those that are named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"any of {', '.join(SHOTS)} (all)")
    parser.add_argument("--size", default="1280x720", help="of the canvas (1280x720)")
    parser.add_argument("--folder", type=Path, default=IMAGES)
    arguments = parser.parse_args()
    if unknown := sorted(set(arguments.names) - SHOTS.keys()):
        parser.error(f"no image {', '.join(unknown)}; there are {', '.join(SHOTS)}")
    width, height = map(int, arguments.size.split("x"))
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for name in arguments.names or SHOTS:
        path = arguments.folder / f"{name}.jpg"
        with whole_file(path) as file:
            pixels = shot(name, (width, height))
            Image.fromarray(pixels).save(file, "JPEG", quality=72, optimize=True, progressive=True)
        print(path)


if __name__ == "__main__":
    main()
