"""Times over random triangles: tables D.1 to D.3, the growth with the scene, and what the crossover is read from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from anamorph.bench.moving import Times, time_methods
from anamorph.bench.thesis.printed import printed, random_table
from anamorph.bench.thesis.random_scene import random_ray_mesh, random_triangles
from anamorph.methods import Specification


@dataclass(frozen=True, order=True)
class Place:
    """A square image of random triangles: its side in pixels, quads along a side of the ray mesh, its roughness."""

    side: int
    scene_triangles: int
    quads: int
    roughness: float = 1.0

    @property
    def projections(self) -> int:
        """The number of ray triangles."""
        return 2 * self.quads**2


@dataclass(frozen=True)
class RandomTime:
    """What a frame takes at one `Place`, milliseconds.

    `printed_ms` is the thesis's, where it has that place. Where a method could not draw it, `refusal` says why.
    """

    resolution_px: int
    scene_triangles: int
    trilinear_projections: int
    roughness: float
    method: str
    ms: float | None
    least_ms: float | None
    printed_ms: float | None = None
    refusal: str = ""

    @property
    def pixels_a_ray_triangle(self) -> float:
        """Of the image, which the ray triangles share evenly."""
        return self.resolution_px / self.trilinear_projections


def lines_through(sides: Sequence[int], counts: Sequence[int], quads: Sequence[int]) -> list[Place]:
    """The lines of figures 8.2 to 8.8 and 8.13 to 8.15 through the cross of all three axes.

    Resolution for the least, second and largest scene, and scene triangles for three resolutions, both through one
    quad; ray triangles for the same three resolutions, with the largest scene.
    """
    few, some = _three(counts), _three(sides[1:])
    places = {Place(side, count, quads[0]) for side in sides for count in few}
    places |= {Place(side, count, quads[0]) for side in some for count in counts}
    places |= {Place(side, counts[-1], number) for side in some for number in quads}
    return sorted(places)


def clip_lines(sides: Sequence[int], counts: Sequence[int], quads: Sequence[int]) -> list[Place]:
    """The lines of figure 8.16: ray triangles at the largest resolution, for three scenes."""
    return [Place(sides[-1], count, number) for count in _three(counts) for number in quads]


def _three(values: Sequence[int]) -> set[int]:
    """The first, the middle one (of two the lower; of a list of six the second) and the last."""
    return {values[0], values[max(0, (len(values) - 1) // 2 - (len(values) > 5))], values[-1]}


def time_random(
    places: Iterable[Place],
    methods: Sequence[Specification],
    frames: int,
    report: Callable[[str], None] = lambda what: None,
) -> list[RandomTime]:
    """Time all methods at each place."""
    rows = []
    for place in places:
        report(f"{place.scene_triangles:,} triangles, {place.projections} ray triangles, {place.side} x {place.side}")
        size = (place.side, place.side)
        rays = random_ray_mesh(place.quads, size, roughness=place.roughness)
        times = time_methods(random_triangles(place.scene_triangles, rays), rays, size, methods, frames)
        rows += [_row(place, method, times) for method in methods]
    return rows


def _row(place: Place, method: Specification, times: Times) -> RandomTime:
    pixels, known = place.side**2, None
    if place.roughness == 1.0:
        known = printed(
            random_table(method),
            resolution_px=pixels,
            scene_triangles=place.scene_triangles,
            trilinear_projections=place.projections,
        )
    timing = times.timings.get(method)
    return RandomTime(
        pixels, place.scene_triangles, place.projections, place.roughness, str(method),
        timing.median if timing else None, timing.min if timing else None, known, times.refusals.get(method, ""),
    )  # fmt: skip
