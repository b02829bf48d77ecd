"""A comparison as one HTML page that needs nothing but itself."""

from __future__ import annotations

import base64
from html import escape
from importlib import resources
from string import Template

import numpy as np

from anamorph.base.output import pixel_bytes, to_pixels
from anamorph.measure.compare import Comparison, MethodResult
from anamorph.measure.figures import number, rows_of
from anamorph.measure.heatmap import MILLIRADIANS, VIRIDIS, heat_map
from anamorph.measure.status import status_shares

MARGIN = 12
"""Pixels that are shown around the specular surfaces."""


def comparison_page(comparison: Comparison) -> str:
    """The whole page: images as data, the table, the error maps with their scale, and how it was made."""
    width, height = comparison.size
    template = Template(resources.files("anamorph.measure").joinpath("page.html").read_text(encoding="utf-8"))
    drawn = [result for result in comparison.methods if result.name != comparison.reference]
    return template.substitute(
        scene=escape(comparison.scene),
        reference=escape(comparison.reference),
        size=f"{width} x {height}",
        adapter=escape(comparison.adapter),
        head="".join(f'<th scope="col">{_breakable(result.name)}</th>' for result in comparison.methods),
        rows=_rows(comparison),
        frames=max((result.timing.n for result in comparison.methods), default=0),
        plain=_plain(comparison),
        sections="\n".join(_section(comparison, result) for result in drawn),
        images="\n".join(_whole_images(comparison, drawn)),
        versions="\n".join(f"<dt>{escape(n)}</dt><dd>{escape(v)}</dd>" for n, v in comparison.versions.items()),
        command=escape(comparison.command or "made from Python, not by a command"),
    )


def specular_box(specular: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns around the true pixels of (H, W), with a margin; everything where none is true."""
    if not specular.any():
        return slice(0, specular.shape[0]), slice(0, specular.shape[1])
    rows, columns = np.flatnonzero(specular.any(axis=1)), np.flatnonzero(specular.any(axis=0))
    return (
        slice(max(0, int(rows[0]) - MARGIN), int(rows[-1]) + MARGIN + 1),
        slice(max(0, int(columns[0]) - MARGIN), int(columns[-1]) + MARGIN + 1),
    )


def _rows(comparison: Comparison) -> str:
    rows = []
    for row in rows_of(comparison):
        cells = "".join(f"<td>{escape(row.cell(comparison, result))}</td>" for result in comparison.methods)
        rows.append(f'<tr><th scope="row">{escape(row.label)} <small>{escape(row.unit)}</small></th>{cells}</tr>')
    return "\n".join(rows)


def _plain(comparison: Comparison) -> str:
    plain = comparison.without_mirrors
    if plain is None:
        return "Without its mirrors nothing is left of the scene."
    return f"The frame without mirrors takes its turn with them: {number(plain.median)} ms."


def _section(comparison: Comparison, result: MethodResult) -> str:
    maps, name = result.errors.maps, escape(result.name)
    box = specular_box(maps.specular)
    angular = result.errors.angular_mrad
    figures = (
        _figure(to_pixels(result.frame.color[box]), f"What {name} shows in the specular surfaces", name),
        _figure(
            to_pixels(comparison.reference_frame.color[box]),
            f"What is seen there in truth, by {escape(comparison.reference)}",
            f"truth: {escape(comparison.reference)}",
        ),
        _figure(
            heat_map(maps, comparison.reference_frame.color)[box],
            f"Map of the angular error of {name}: median {number(angular.median)}, 95th percentile "
            f"{number(angular.p95)}, maximum {number(angular.max)} milliradians",
            "angular error, mrad (silhouettes included)" + _scale(),
        ),
    )
    shares = status_shares(result.frame, maps.specular)
    statuses = ", ".join(f"{escape(status)} {number(share)} %" for status, share in shares.items()) or "not known"
    return (
        f'<section aria-label="{name}"><h2>{_breakable(result.name)}</h2>\n'
        f'<div class="three">{"".join(figures)}</div>\n'
        f"<p>How the pixels that look at a specular surface got their value: {statuses}.</p></section>"
    )


def _whole_images(comparison: Comparison, drawn: list[MethodResult]) -> list[str]:
    reference = escape(comparison.reference)
    images = [
        _figure(to_pixels(result.frame.color), f"The whole image by {escape(result.name)}", _breakable(result.name))
        for result in drawn
    ]
    alt = f"The whole image in truth, by {reference}"
    return [*images, _figure(to_pixels(comparison.reference_frame.color), alt, f"truth: {reference}")]


def _figure(pixels: np.ndarray, alt: str, caption: str) -> str:
    height, width = pixels.shape[:2]
    data = base64.b64encode(pixel_bytes(pixels)).decode("ascii")
    image = f'<img alt="{alt}" width="{width}" height="{height}" src="data:image/png;base64,{data}">'
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>\n"


def _scale() -> str:
    gradient = f"background:linear-gradient(to right,{','.join(VIRIDIS)})"
    ends = f"{MILLIRADIANS.lowest:g} or less to {MILLIRADIANS.highest:g} or more milliradians, logarithmic"
    ticks = "".join(f"<span>{tick:g}</span>" for tick in MILLIRADIANS.ticks)
    return (
        f'<div class="scale"><div class="bar" style="{gradient}" role="img" aria-label="Colour scale: {ends}"></div>'
        f'<div class="ticks" aria-hidden="true">{ticks}</div></div>'
    )


def _breakable(name: str) -> str:
    """A method's name with its options, which may be long, allowed to break after each."""
    return escape(name).replace(":", ":<wbr>").replace(",", ",<wbr>")
