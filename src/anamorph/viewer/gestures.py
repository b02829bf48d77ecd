"""What pointer, wheel and fingers do."""

from __future__ import annotations

GESTURES: tuple[tuple[str, str], ...] = (
    ("Drag", "orbit"),
    ("Right drag, Shift+drag", "pan"),
    ("Middle drag, Ctrl+drag", "look around"),
    ("Wheel", "zoom toward the pointer"),
    ("Alt+wheel", "field of view"),
    ("Click", "look into a pixel; again to drop it"),
    ("Double click", "reset the view"),
    ("Drag the divider", "compare the halves"),
    ("One finger", "orbit"),
    ("Two fingers", "pan and zoom"),
)
"""Every gesture and what it does, in the order of the help overlay."""
