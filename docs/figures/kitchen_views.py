"""The kitchen by several ways, Figures 6 to 8 of the paper on virtual objects; and reflectors that it cannot show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from figures.comparing import number
from figures.panels import HALF, Panel, cropped, draw

import anamorph as an
from anamorph.gallery import make
from anamorph.measure.curvature_parts import Form, curvature_parts
from anamorph.measure.errors import measure
from anamorph.scene.model import Color

LARGE = (1024, 768)

BOX = (262, 170, 706, 590)
"""Around the kettle."""

SIZE = (HALF[0], round(HALF[0] * (BOX[3] - BOX[1]) / (BOX[2] - BOX[0])))

THIRD = (313, 235)

PAPER = "virtual:search=cubemap"


def errors(scene: an.Scene | str, method: str, size: tuple[int, int] = LARGE) -> str:
    """How far a method is from the truth, in words."""
    reference, frame = (an.render(scene, method=each, size=size, seen=True) for each in ("raytrace", method))
    found = measure(reference, frame)
    return f"median {number(found.pixels.median)} px, {number(found.other_object_percent)}% another object"


def panels(methods: dict[str, str]) -> list[Panel]:
    """The kettle by some methods, with words."""
    shown = []
    for method, words in methods.items():
        image = cropped(
            draw("kitchen", f"{method}{',' if ':' in method else ':'}antialias=4", LARGE, 1), BOX, SIZE, True
        )
        told = "" if method == "raytrace" else f"\n{errors('kitchen', method)}"
        shown.append(Panel(np.asarray(image), f"{words}{told}"))
    return shown


def in_rows(shown: Sequence[Panel]) -> list[list[Panel]]:
    return [list(shown[:2]), list(shown[2:])]


def ways() -> list[list[Panel]]:
    """Figure 6: traced, all vertices searched for, a grid of 10%, and an environment map that is drawn each frame."""
    return in_rows(
        panels(
            {
                "raytrace": "ray traced",
                PAPER: "all vertices searched for",
                f"{PAPER},grid=regular": "a grid of 9.6%",
                "environment": "environment map, drawn each frame",
            }
        )
    )


def shares() -> list[list[Panel]]:
    """Figure 7: grids of other shares."""
    return in_rows(
        panels({f"{PAPER},grid=regular,share={share}": f"{100 * share:.1f}%" for share in (0.041, 0.055, 0.096, 0.143)})
    )


def steps() -> list[list[Panel]]:
    """Figure 8: other numbers of steps."""
    return in_rows(panels({f"{PAPER},iterations={count}": f"{count} steps" for count in (3, 5, 7, 9)}))


FORMS: dict[Form, Color] = {
    Form.FLAT: (0.75, 0.75, 0.72),
    Form.CONVEX: (0.82, 0.42, 0.10),
    Form.CONCAVE: (0.10, 0.36, 0.70),
    Form.SADDLE: (0.30, 0.58, 0.22),
}


def in_forms(mesh: an.Mesh) -> an.Mesh:
    """A mirror painted by how it curves."""
    if not mesh.specular:
        return mesh
    corners = mesh.faces.ravel()
    colors = np.array([FORMS[form] for form in Form], np.float32)[curvature_parts(mesh).form]
    return an.Mesh(
        mesh.name,
        np.asarray(mesh.positions, np.float32)[corners],
        np.arange(len(corners), dtype=np.int32).reshape(-1, 3),
        mesh.normals[corners],
        an.Diffuse((1.0, 1.0, 1.0)),
        colors=np.repeat(colors, 3, axis=0),
    )


def parts() -> list[list[Panel]]:
    """Beyond the paper: reflectors parted by how they curve."""
    row = []
    for name in ("torus", "room"):
        scene = make(name)
        painted = replace(scene, meshes=tuple(map(in_forms, scene.meshes)))
        row.append(Panel(draw(painted, "raytrace", HALF, 3), name))
    return [row]


def reflectors() -> list[list[Panel]]:
    """Beyond the paper: by tiles, on reflectors of all kinds, above the truth."""
    rows = []
    for names in (("kitchen", "torus", "saddle"), ("room", "curvature-series", "car-mirror")):
        rows.append(
            [Panel(draw(name, "virtual:antialias=4", THIRD, 1), f"{name}\n{errors(name, 'virtual')}") for name in names]
        )
        rows.append([Panel(draw(name, "raytrace:antialias=4", THIRD, 1), "truth") for name in names])
    return rows
