"""Plots as PNG, by matplotlib where it is installed: the extra `plots`."""

from __future__ import annotations

import io
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from anamorph.base.output import whole_file

INSTALL = "anamorph[plots]"
DASHES = ("-", "--", ":", "-.")
MARKERS = ("o", "s", "^", "D")


@dataclass(frozen=True)
class Line:
    """One line of a plot: `group` has a colour, `kind` (the method) a dash and a marker."""

    group: str
    kind: str
    x: tuple[float, ...]
    y: tuple[float, ...]


@dataclass(frozen=True)
class Panel:
    """Axes with their lines; `logarithmic` holds for both axes, and a thin line marks the height `even`."""

    title: str
    x: str
    y: str
    lines: tuple[Line, ...]
    logarithmic: bool = True
    even: float | None = None


def can_plot() -> bool:
    """Whether matplotlib is installed."""
    return find_spec("matplotlib") is not None


def save_plot(path: Path, title: str, panels: Sequence[Panel]) -> None:
    """Draw panels side by side, those with lines, with one legend below all of them."""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    from matplotlib import colormaps
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.ticker import LogLocator, NullLocator

    panels = [panel for panel in panels if panel.lines]
    kinds = list(dict.fromkeys(line.kind for panel in panels for line in panel.lines))
    colors: dict[str, tuple[float, float, float, float]] = {}
    for panel in panels:
        groups = [group for group in dict.fromkeys(line.group for line in panel.lines) if group not in colors]
        # Groups of another kind in a second panel have colours of another map. The last ones cannot be seen on white.
        colormap = colormaps["plasma" if colors else "viridis"]
        colors |= {group: colormap(0.88 * i / max(1, len(groups) - 1)) for i, group in enumerate(groups)}
    styles: dict[str, dict[str, Any]] = {
        kind: {"linestyle": DASHES[i % len(DASHES)], "marker": MARKERS[i % len(MARKERS)], "markersize": 4}
        for i, kind in enumerate(kinds)
    }
    figure = Figure(figsize=(5.6 * len(panels), 5.4), layout="constrained", dpi=110)
    figure.suptitle(title)
    for place, panel in enumerate(panels):
        axes = figure.add_subplot(1, len(panels), place + 1, title=panel.title, xlabel=panel.x, ylabel=panel.y)
        for line in panel.lines:
            axes.plot(line.x, line.y, color=colors[line.group], **styles[line.kind])
        if panel.logarithmic:
            axes.set(xscale="log", yscale="log")
            axes.yaxis.set_major_formatter("{x:,g}")
            axes.yaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
            axes.yaxis.set_minor_formatter("{x:,g}")
            axes.tick_params(axis="y", which="minor", labelsize=7)
        else:
            axes.set_ylim(bottom=0.0)
        places = _apart(sorted({x for line in panel.lines for x in line.x}), panel.logarithmic)
        axes.set_xticks(places, [f"{x:,.0f}" for x in places], rotation=40, ha="right", rotation_mode="anchor")
        axes.xaxis.set_minor_locator(NullLocator())
        if panel.even is not None:
            axes.axhline(panel.even, color="gray", linewidth=1)
        axes.grid(True, which="major", alpha=0.3)
    handles = [Line2D([], [], color=color, linewidth=3, label=group) for group, color in colors.items()]
    handles += [Line2D([], [], color="black", label=kind, **style) for kind, style in styles.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=min(4, len(handles)))
    image = io.BytesIO()
    figure.savefig(image, format="png")
    with whole_file(path) as file:
        file.write(image.getvalue())


def _apart(values: Sequence[float], logarithmic: bool) -> list[float]:
    """Those of ascending values that are far enough from the one before to be written below the axis."""
    heights = np.log(values) if logarithmic else np.asarray(values, float)
    least, chosen = 0.04 * (heights[-1] - heights[0]), [0]
    for place, height in enumerate(heights):
        if height - heights[chosen[-1]] > least:
            chosen.append(place)
    return [values[place] for place in chosen]
