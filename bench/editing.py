"""One step of a slider: a mirror is turned, and the scene, which is large otherwise, is opened and drawn again.

Run it with `./run bench editing`. Before the steps that count, two others fill what is kept from one to the next.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from time import perf_counter

import numpy as np

from anamorph import gallery
from anamorph.frame import View
from anamorph.gallery.shapes import lattice
from anamorph.methods import METHODS, parse
from anamorph.scene.model import Mesh, Scene
from anamorph.viewer.controls import edited

COUNTS = (10_000, 100_000, 300_000, 1_000_000)


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(prog="./run bench editing", description=__doc__.splitlines()[0])
    parser.add_argument("-m", "--method", action="append", help="with its options; may be repeated (all methods)")
    parser.add_argument("--triangles", type=int, action="append", help="around the mirror; may be repeated")
    parser.add_argument("--size", default="400x300", help="of the picture (400x300)")
    parser.add_argument("--steps", type=int, default=9, help="of which the median is told (9)")
    arguments = parser.parse_args()
    width, height = map(int, arguments.size.split("x"))
    print("medians, ms | triangles | method | edit | open | first picture | second picture")
    for count in arguments.triangles or COUNTS:
        scene = hilly(count)
        for method in arguments.method or METHODS:
            times = np.array([step(scene, method, (width, height), 0.2 * n) for n in range(arguments.steps + 2)])
            told = " | ".join(f"{1e3 * median:.1f}" for median in np.median(times[2:], axis=0))
            print(f"{sum(len(mesh.faces) for mesh in scene.meshes)} | {method} | {told}", flush=True)


def step(scene: Scene, method: str, size: tuple[int, int], swivel: float) -> list[float]:
    """Seconds that editing, opening and two pictures took."""
    opener, options = parse(method)
    times = [perf_counter()]
    changed = edited(scene, {"mirror/swivel": swivel})
    times.append(perf_counter())
    session = opener.open(View(changed, changed.camera, size), options)
    times.append(perf_counter())
    for _ in range(2):
        session.draw(changed.camera)
        session.wait()
        times.append(perf_counter())
    return np.diff(times).tolist()


def hilly(count: int, strips: int = 8) -> Scene:
    """The mirror of `car-mirror` over hills of about `count` triangles, in strips."""
    scene = gallery.make("car-mirror")
    columns = int(np.sqrt(count / 2 / strips))
    rows = max(count // (2 * strips * columns), 1)
    hills = []
    for number in range(strips):
        x, z = np.meshgrid(np.linspace(-60, 60, columns + 1), 20.0 * np.linspace(number - 1, number, rows + 1))
        y = 0.4 * np.sin(0.5 * x) * np.cos(0.7 * z) + 0.05 * np.sin(5.0 * x) - 1.0
        slope_x = 0.2 * np.cos(0.5 * x) * np.cos(0.7 * z) + 0.25 * np.cos(5.0 * x)
        normals = np.stack([-slope_x, np.ones_like(x), 0.28 * np.sin(0.5 * x) * np.sin(0.7 * z)], axis=-1)
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        places = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)
        faces = lattice(columns + 1, rows + 1).astype(np.int32)
        normal = normals.reshape(-1, 3).astype(np.float32)
        hills.append(Mesh(f"hills-{number}", places, faces, normal, colors=np.abs(np.sin(places))))
    return replace(scene, name="hills", meshes=(scene.meshes[0], *hills))


if __name__ == "__main__":
    main()
