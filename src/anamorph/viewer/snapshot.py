"""What the viewer shows, as plain data that scripts and tests read."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from anamorph.viewer.facts import Facts
from anamorph.viewer.panel.panel import Drawn
from anamorph.viewer.state import State


def snapshot(facts: Facts, state: State, drawn: Drawn | None, frames: int, at_rest: bool) -> dict[str, Any]:
    """All of it but the scene's arrays, ready for JSON."""
    copied = ("size", "image", "full", "adapter", "frame_ms", "samples_done", "samples_total", "searching", "message")
    halves = {
        name: vars(half) | {"method": str(half.method)}
        for name, half in (("first", state.first), ("second", state.second))
    }
    seen = facts.inspection
    return {
        "scene": facts.scene.name,
        "state": asdict(state) | halves | {"drawings": sorted(state.drawings)},
        "frames": frames,
        "at_rest": at_rest,
        "rectangles": dict(drawn.rectangles) if drawn else {},
        "covered": list(drawn.covered) if drawn else [],
        "phases_ms": dict(facts.phases_ms),
        "figures": [each and asdict(each) for each in facts.figures],
        "inspection": seen and asdict(seen) | {"method": str(seen.method)},
        "reflections": facts.reflections and asdict(facts.reflections) | {"status": facts.reflections.status.name},
        "progress": facts.progress and asdict(facts.progress),
        **{name: getattr(facts, name) for name in copied},
    }
