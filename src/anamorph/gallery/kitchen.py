"""A kitchen with polished cookware on its table: a kettle large in front, pans, a toaster, and a bowl to look into."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.gallery.cookware import COPPER, STEEL, bowl, turned_body
from anamorph.gallery.crockery import curve, fruit_bowl, jar, labelled_box, place_setting, ring, tea_towel
from anamorph.gallery.kitchen_room import TABLE, kitchen_room
from anamorph.gallery.solids import Solid, box, grid, join, lathe, loft
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, DirectionalLight, Mesh, PointLight, Scene

KETTLE_PROFILE = [(0.0, 0.0), (0.085, 0.0), (0.118, 0.012), (0.128, 0.085), (0.085, 0.158), (0.04, 0.168), (0.0, 0.168)]

BOWL, BOWL_RADIUS, BOWL_DEPTH = (0.31, TABLE + 0.135, 0.14), 0.13, 0.09
"""The middle of the sphere that the mixing bowl is part of, its radius, and how deep the bowl is; metres."""

BLACK = (0.035, 0.034, 0.036)


def kitchen() -> Scene:
    """The built-in scene `kitchen`."""
    toward = np.array([-0.8, 0.5, 0.25])
    return Scene(
        name="kitchen",
        meshes=(*cookware(), *kettle_fittings(), *laid_table(), *kitchen_room()),
        camera=Camera(position=(0.20, TABLE + 0.36, 0.72), target=(0.02, TABLE + 0.085, 0.0), field_of_view=36.0),
        lights=(
            DirectionalLight(toward=tuple(toward / np.linalg.norm(toward)), color=(0.46, 0.44, 0.40)),
            PointLight(position=(0.2, 1.95, 0.2), color=(0.60, 0.54, 0.46)),
            AmbientLight(sky=(0.44, 0.44, 0.45), ground=(0.32, 0.29, 0.26)),
        ),
    )


def cookware() -> list[Mesh]:
    """All that is polished."""
    toaster = [(0.0, 0.0), (0.08, 0.0), (0.088, 0.01), (0.090, 0.08), (0.086, 0.135), (0.06, 0.142), (0.0, 0.142)]
    pan = [(0.0, 0.0), (0.075, 0.0), (0.086, 0.008), (0.09, 0.05), (0.089, 0.095), (0.084, 0.102), (0.0, 0.104)]
    return [
        turned_body("kettle", KETTLE_PROFILE, (0.0, TABLE + 0.004, 0.0), STEEL, rows=40, columns=80),
        turned_body("toaster", toaster, (-0.42, TABLE + 0.008, -0.10), STEEL, corner=2.2, stretch=(1.55, 0.95)),
        turned_body("saucepan", pan, (0.36, TABLE + 0.003, -0.24), COPPER),
        bowl("mixing-bowl", BOWL, BOWL_RADIUS, BOWL_DEPTH, STEEL),
    ]


def kettle_fittings() -> list[Mesh]:
    """The kettle's base, knob, spout and handle, the pan's handle and lid knob, and the toaster's lever."""
    y = TABLE + 0.004
    knob = lathe(
        curve([(0.0, 0.164), (0.012, 0.164), (0.011, 0.176), (0.022, 0.184), (0.018, 0.198), (0.0, 0.2)]), 40, 50.0
    )
    angle = np.linspace(np.radians(-4.0), np.radians(184.0), 49)
    arch = tube(np.stack([0.111 * np.cos(angle), 0.105 + 0.155 * np.sin(angle), 0.0 * angle], axis=-1), 0.011)
    steps = np.linspace(0.0, 1.0, 25)
    way = np.stack([-0.104 - 0.095 * steps, 0.06 + 0.09 * steps**1.4, 0.0 * steps], axis=-1)
    spout = tube(way, 0.021 - 0.010 * steps)
    parts = [
        ring(0.088, 0.007, 64, 10),
        knob,
        arch.turned(28.0),
        spout.turned(28.0),
    ]
    pan_handle = tube(np.array([[0.085 + 0.02 * i, 0.085 + 0.002 * i, 0.0] for i in range(10)]), 0.010)
    pan_knob = lathe(
        curve([(0.0, 0.1), (0.008, 0.1), (0.008, 0.112), (0.016, 0.118), (0.012, 0.128), (0.0, 0.129)]), 32, 50.0
    )
    lever = box((-0.012, 0.07, 0.0), (0.012, 0.082, 0.03))
    return [
        join(parts).moved(0.0, y, 0.0).mesh("kettle-fittings", Diffuse(color=BLACK)),
        join([pan_handle.turned(35.0), pan_knob])
        .moved(0.36, TABLE + 0.003, -0.24)
        .mesh("pan-fittings", Diffuse(color=BLACK)),
        join([lever.moved(0.0, 0.0, 0.082), box((-0.11, 0.0, -0.06), (0.11, 0.012, 0.06))])
        .moved(-0.42, TABLE, -0.10)
        .mesh("toaster-fittings", Diffuse(color=BLACK)),
        bowl_outside().mesh("mixing-bowl-outside", Diffuse(color=(0.70, 0.22, 0.16))),
    ]


def bowl_outside() -> Solid:
    """The enamelled outside of the bowl, with its rim."""
    x, y, z = BOWL
    outer = BOWL_RADIUS + 0.004
    angle = np.linspace(-0.5 * np.pi, np.arcsin(BOWL_DEPTH / BOWL_RADIUS - 1.0), 24)
    profile = [(outer * np.cos(a), outer * np.sin(a)) for a in angle]
    edge = (BOWL_RADIUS * np.cos(angle[-1]), BOWL_RADIUS * np.sin(angle[-1]))
    profile += [(profile[-1][0] + 0.004, edge[1] + 0.001), (profile[-1][0] + 0.003, edge[1] + 0.005), edge]
    return lathe(profile, 64, 60.0).moved(x, y, z)


def tube(way: np.ndarray, radius: float | np.ndarray, segments: int = 20) -> Solid:
    """A closed tube of round sections along points (N, 3), of one radius or one at each point."""
    ahead = np.gradient(way, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(ahead, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(ahead, side)
    angle = np.arange(segments) * 2.0 * np.pi / segments
    circle = np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * other[:, None]
    rings = way[:, None] + np.broadcast_to(radius, len(way))[:, None, None] * circle
    ends = [np.repeat(way[:1, None], segments, axis=1), np.repeat(way[-1:, None], segments, axis=1)]
    return loft(np.concatenate([ends[0], rings, ends[1]]), 50.0)


def laid_table() -> list[Mesh]:
    """What stands on the table beside the cookware."""
    white = Diffuse(color=(1.0, 1.0, 1.0))
    settings = [
        place_setting((0.14, 0.30, 0.52)).moved(-0.32, TABLE, 0.34),
        place_setting((0.62, 0.26, 0.12)).turned(180.0).moved(0.42, TABLE, 0.52),
        place_setting((0.20, 0.42, 0.26)).turned(180.0).moved(-0.05, TABLE, -0.40),
    ]
    jars = [
        jar(0.11, 0.035, color, (0.45, 0.28, 0.14)).moved(x, TABLE, z)
        for x, z, color in (
            (-0.20, -0.30, (0.70, 0.30, 0.10)), (-0.29, -0.33, (0.78, 0.66, 0.22)), (-0.62, 0.12, (0.28, 0.40, 0.16)),
        )
    ]  # fmt: skip
    bowl_of_fruit = [_moved(mesh, (-0.30, TABLE, 0.10)) for mesh in fruit_bowl()]
    towel = grid((0.0, 0.0, 0.0), (0.24, 0.0, 0.0), (0.0, 0.0, -0.34), (16, 24))
    waves = 0.003 * (1.0 + np.sin(40.0 * towel.positions[:, 0]) * np.cos(31.0 * towel.positions[:, 2]))
    lifted = replace(towel, positions=towel.positions + waves[:, None] * [0.0, 1.0, 0.0])
    carton = labelled_box("OATS", (176, 120, 40), (0.10, 0.17, 0.06))
    return [
        join(settings).mesh("settings", white),
        join(jars).mesh("jars", white),
        *bowl_of_fruit,
        lifted.turned(-16.0)
        .moved(0.10, TABLE + 0.001, 0.52)
        .mesh("towel", Diffuse(color=(1.0, 1.0, 1.0), texture=tea_towel())),
        _moved(carton, (0.58, TABLE, 0.02)),
    ]


def _moved(mesh: Mesh, by: tuple[float, float, float]) -> Mesh:
    return replace(mesh, positions=(mesh.positions + np.array(by)).astype(np.float32))
