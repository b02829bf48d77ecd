"""The images of the paper on three-ray cameras: sculptures in a mirror teapot, Figures 1, 2, 5 and 6."""

from __future__ import annotations

from dataclasses import replace

from figures.comparing import number, p95_of_things
from figures.panels import HALF, Panel, cropped, draw

import anamorph as an
from anamorph.gallery.animals import bunny, dinosaur, dragon
from anamorph.gallery.beside_teapot import OBJECTS, beside_teapot, in_hall
from anamorph.gallery.sculpting import Sculpture, sculpted
from anamorph.measure.errors import measure

THIRD = (313, 235)
LARGE = (960, 720)
OURS, TRUTH, MAP = "threeray", "raytrace", "environment"
SQUARES = "threeray:spacing=1,detail=false,splat="
"""The paper's own way: each triangle is smaller than the spacing, and gives one point."""
TRIANGLES = 37_000
"""Of sculptures that are not those of the six scenes."""
FEW = 2_500
"""Triangles of a sculpture whose points are to be seen."""


def placed(
    sculpture: Sculpture,
    name: str,
    place: tuple[float, float, float],
    turn: float,
    scale: float,
    triangles: int = TRIANGLES,
) -> an.Mesh:
    """A sculpture in the hall, turned by degrees."""
    solid = sculpted(sculpture, triangles)
    turned = replace(solid, positions=scale * solid.positions).turned(turn)
    return turned.moved(*place).mesh(name, an.Diffuse((1.0, 1.0, 1.0)))


def errors(scene: an.Scene, method: str) -> str:
    """How far a method is from the truth, in words."""
    reference, frame = (an.render(scene, method=each, size=LARGE, seen=True) for each in (TRUTH, method))
    found = measure(reference, frame)
    away = p95_of_things(reference, found)
    return f"p95 {number(away)} px, {number(found.other_object_percent)}% another object"


def compared(scene: an.Scene, box: tuple[int, int, int, int], methods: dict[str, str]) -> list[Panel]:
    """Part of a scene's image by some methods, with words, and by the truth."""
    panels = []
    for method, words in methods.items():
        image = draw(scene, f"{method}:antialias=4", LARGE, 1)
        panels.append(Panel(cropped(image, box, THIRD, smooth=True), f"{words}\n{errors(scene, method)}"))
    image = draw(scene, f"{TRUTH}:antialias=4", LARGE, 1)
    return [*panels, Panel(cropped(image, box, THIRD, smooth=True), "truth")]


def points() -> list[list[Panel]]:
    """Figure 1: reflections of objects, and the points that draw them."""

    def scene(triangles: int) -> an.Scene:
        return in_hall(
            "dinosaur and bunny",
            placed(dinosaur(), "dinosaur", (-0.66, -0.5, 0.74), 80.0, 0.62, triangles),
            placed(bunny(), "bunny", (0.60, -0.5, 0.72), -35.0, 0.62, triangles),
        )

    many, few = scene(TRIANGLES), scene(FEW)
    whole, part = (200, 150, 760, 570), (325, 345, 493, 471)

    def shown(each: an.Scene, method: str, box: tuple[int, int, int, int], words: str) -> Panel:
        return Panel(cropped(draw(each, method, LARGE, 1), box, THIRD, smooth=box is whole), words)

    return [
        [
            shown(many, f"{SQUARES}2", whole, f"{2 * TRIANGLES:,} points as squares of 2 px"),
            shown(many, OURS, whole, "met by the cameras' rays"),
            shown(many, TRUTH, whole, "truth"),
        ],
        [
            shown(few, f"{SQUARES}1", part, f"{2 * FEW:,} points as squares of 1 px"),
            shown(many, f"{SQUARES}1", part, f"{2 * TRIANGLES:,} points"),
            shown(many, OURS, part, "met by the cameras' rays"),
        ],
    ]


def environment() -> list[list[Panel]]:
    """Figure 2: an environment map and three-ray cameras, of a thing near the pot and of one that is stuck in it."""
    near = in_hall("near", placed(bunny(), "bunny", (-0.52, -0.5, 0.80), 15.0, 0.50))
    stuck = in_hall("stuck", placed(dragon(), "dragon", (0.12, -0.42, 0.45), 20.0, 0.7))
    methods = {MAP: "environment map", OURS: "three-ray cameras"}
    return [compared(near, (210, 250, 650, 580), methods), compared(stuck, (320, 250, 760, 580), methods)]


def over_environment() -> list[list[Panel]]:
    """Figure 5: dragon and bunny over the hall, which is an image."""
    scene = in_hall(
        "dragon and bunny",
        placed(dragon(), "dragon", (-0.72, -0.5, 0.80), 60.0, 0.62),
        placed(bunny(), "bunny", (0.66, -0.5, 0.74), -35.0, 0.62),
    )
    words = {OURS: f"three-ray cameras\n{errors(scene, OURS)}", TRUTH: "truth"}
    return [[Panel(draw(scene, f"{method}:antialias=4", HALF, 1), said) for method, said in words.items()]]


def six() -> list[list[Panel]]:
    """Figure 6: the six scenes that are measured, and the truth below each."""
    rows: list[list[Panel]] = []
    names = list(OBJECTS)
    for some in (names[:3], names[3:]):
        scenes = {name: beside_teapot(name) for name in some}
        for method in (OURS, TRUTH):
            rows.append(
                [
                    Panel(
                        draw(scene, f"{method}:antialias=4", THIRD, 1),
                        f"{name}, {OBJECTS[name].triangles:,} triangles" if method == OURS else "truth",
                    )
                    for name, scene in scenes.items()
                ]
            )
    return rows
