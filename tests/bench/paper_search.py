"""How right the search of Estalella et al. 2005 is, by its steps and the size of its cube maps, and where it fails.

Run it with `./run bench paper-search`. Truth are the reflection points of the exact search.
"""

from __future__ import annotations

import time
from itertools import pairwise

import numpy as np
from rich.table import Table

from anamorph.base.vectors import tuple_of
from anamorph.gallery import make
from anamorph.gallery.cookware import STEEL, turned_body
from anamorph.gallery.spheres import mirror_ball
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import submit, wait
from anamorph.measure.table import headed, print_table
from anamorph.methods.virtual.cube_search import lookup, search
from anamorph.methods.virtual.device_search import DeviceSearch, packed_points
from anamorph.methods.virtual.reflector_maps import ReflectorMaps, reflector_maps
from anamorph.reflections.searching import MirrorSearch
from anamorph.scene.camera import Camera
from anamorph.scene.model import Mesh

COUNT = 6000
"""Points around each body."""

STEPS = (0, 3, 5, 7, 9, 15, 30, 60)

SIZES = (64, 128, 256, 512)

IMAGE, RADIUS = (1024, 768), 300.0
"""The image, and how large a body is in it; pixels."""

FAILED = 5.0
"""Pixels by which a search misses that counts as failed."""


def bodies() -> dict[str, Mesh]:
    """What is searched: a ball, nearly an ellipsoid with half axes of 1, 0.6 and 0.4, and the kettle."""
    bend = 0.6 * 0.5523
    half = [(0.0, -0.6), (0.5523, -0.6), (1.0, -bend), (1.0, bend), (0.5523, 0.6), (0.0, 0.6)]
    kettle = next(mesh for mesh in make("kitchen").meshes if mesh.name == "kettle")
    return {
        "ball": mirror_ball("ball", (0.0, 0.0, 0.0), 1.0),
        "ellipsoid": turned_body("ellipsoid", half, (0.0, 0.0, 0.0), STEEL, stretch=(1.0, 0.4)),
        "kettle": kettle,
    }


class Around:
    """Points around a body, and where it shows them.

    Attributes
    ----------
    eye, points, places : arrays
    away, slant : (N,) float64
        How far each point is from the body, in its size; and the cosine between the normal where it is shown and the
        direction to the eye.
    """

    def __init__(self, mesh: Mesh) -> None:
        self.mesh, self.maps = mesh, self.maps_of(mesh, SIZES[2])
        middle, size = self.maps.center, self.maps.reach
        self.eye = middle + size * np.array([0.6, 1.2, 3.6])
        field = np.degrees(2.0 * np.arctan(0.5 * IMAGE[1] / RADIUS * size / np.linalg.norm(self.eye - middle)))
        self._camera = Camera(tuple_of(self.eye), tuple_of(middle), field_of_view=float(field))
        random = np.random.default_rng(1)
        ways = random.normal(size=(COUNT, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        away = np.exp(random.uniform(np.log(0.005), np.log(10.0), COUNT))
        surface = np.array([np.linalg.norm(lookup(self.maps.positions, tuple_of(way))) for way in ways])
        points = middle + (surface + size * away)[:, None] * ways
        found = MirrorSearch.of(mesh, self.eye).find(points)
        places = np.zeros((COUNT, 3))
        places[found.point] = found.position
        once = np.flatnonzero(np.bincount(found.point, minlength=COUNT) == 1)
        self.points, self.places, self.away = points[once], places[once], away[once]
        normals = search(self.maps, self.eye, points[once], 0)[:, 3:6]
        for row, place in enumerate(self.places - middle):
            normals[row] = lookup(self.maps.normals, tuple_of(place))
        to_eye = self.eye - self.places
        self.slant = np.einsum("ni,ni->n", normals, to_eye) / np.linalg.norm(to_eye, axis=1)

    @staticmethod
    def maps_of(mesh: Mesh, size: int) -> ReflectorMaps:
        maps = reflector_maps((mesh,), size)
        assert isinstance(maps, ReflectorMaps)
        return maps

    def errors(self, places: np.ndarray) -> np.ndarray:
        """How far from the truth places (N, 3) are, pixels."""
        x, y = ((each[:, :2] / each[:, 2:]) for each in (self._camera.image(p, IMAGE) for p in (places, self.places)))
        return np.linalg.norm(x - y, axis=1)


def told(errors: np.ndarray) -> list[str]:
    median, p95 = np.percentile(errors, [50, 95])
    return [
        f"{median:.3f}",
        f"{p95:.2f}",
        f"{100 * (errors <= 0.5).mean():.1f}",
        f"{100 * (errors > FAILED).mean():.1f}",
    ]


def error_table(around: dict[str, Around]) -> Table:
    """Errors by steps, then by the size of the maps."""
    columns = "median px", "p95 px", "within 0.5 px, %", f"over {FAILED:.0f} px, %"
    table = headed("the paper's search", f"{COUNT} points, those that are shown once", "", "steps", "texels", *columns)
    for name, each in around.items():
        for steps in STEPS:
            found = search(each.maps, each.eye, each.points, steps)
            table.add_row(name, str(steps), str(SIZES[2]), *told(each.errors(found[:, :3])))
        for size in SIZES:
            found = search(Around.maps_of(each.mesh, size), each.eye, each.points, STEPS[-1])
            table.add_row(name, str(STEPS[-1]), str(size), *told(each.errors(found[:, :3])))
    return table


def failure_table(around: dict[str, Around], steps: int = 9) -> Table:
    """Where the search fails."""
    table = headed(
        f"failed after {steps} steps, %",
        "by where it is shown, and by how far the point is",
        "",
        "",
        "points",
        "failed",
    )
    for name, each in around.items():
        failed = each.errors(search(each.maps, each.eye, each.points, steps)[:, :3]) > FAILED
        for said, values, ends in (
            ("cosine", each.slant, (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 1.0)),
            ("distance", each.away, (0.0, 0.02, 0.1, 0.3, 1.0, 3.0, 10.0)),
        ):
            for low, high in pairwise(ends):
                own = (values > low) & (values <= high)
                if own.any():
                    table.add_row(
                        name, f"{said} {low:g} to {high:g}", str(own.sum()), f"{100 * failed[own].mean():.0f}"
                    )
    return table


def time_table(around: dict[str, Around]) -> Table:
    """What a point takes, of all cores."""
    table = headed("microseconds of all cores a point", "", "", "steps", "float64", "device")
    for name, each in around.items():
        many = np.tile(each.points, (10, 1))
        device = DeviceSearch(each.maps, storage_buffer(packed_points(many)), len(many))
        for steps in (3, 9, 60):
            spent = []
            for turn in range(3):
                start = time.process_time()
                search(each.maps, each.eye, many, steps)
                middle = time.process_time()
                encoder = get_device().create_command_encoder()
                device.record(encoder, each.eye, steps)
                submit(encoder)
                wait()
                if turn:
                    spent.append((middle - start, time.process_time() - middle))
            float64, own = 1e6 * np.min(spent, axis=0) / len(many)
            table.add_row(name, str(steps), f"{float64:.2f}", f"{own:.2f}")
    return table


def main() -> None:
    """Print all tables."""
    around = {name: Around(mesh) for name, mesh in bodies().items()}
    for table in (error_table(around), failure_table(around), time_table(around)):
        print_table(table)


if __name__ == "__main__":
    main()
