"""What stands on the canvas: the halves' images, coarse while things move, refined at rest."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from time import perf_counter

import numpy as np

from anamorph.base.steps import mapped, timed
from anamorph.frame import Frame
from anamorph.methods.specification import Specification
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer.compose import FalseColorTexture, Shown
from anamorph.viewer.counting import Counting, count_colors
from anamorph.viewer.fluency import COARSEST, RESOLUTIONS, Fluency, scaled
from anamorph.viewer.measured import Measured, error_colors, measure_half, status_colors
from anamorph.viewer.method_images import MethodImages, Size
from anamorph.viewer.state import REFERENCE, Aspect, Half, State, looking_eye, shown_camera

LONG = 4e3
"""Milliseconds that an image at rest may be expected to take; on the way to a longer one, coarser ones are drawn, each
of which can be the last when something moves."""

FRAME = 30.0
"""Milliseconds of drawing after which the canvas is painted, and the drawing goes on in its next frame."""

STALE = 2e3
"""Milliseconds for which an image may have been drawn to be finished though something has moved again: without
images that are a little late there would be none of what goes on moving."""

Steps = Generator[bool, None, None]
"""Drawing that can be left, and gone on with, whenever it yields: whether a whole step of it is done."""


@dataclass(frozen=True)
class _Imaged:
    """What the images depend on: when it changes, something moves."""

    camera: Camera
    methods: tuple[Specification, ...]
    size: Size
    resolution: float
    samples: int


@dataclass(frozen=True)
class _Detailed:
    """What else the canvas depends on: when it changes, the images stay."""

    halves: tuple[Half, ...]
    unit: str
    picked: bool
    eye: Camera | None


class Showing:
    """The canvas's content, for one scene after the other.

    Attributes
    ----------
    frames : mapping of Specification to Frame
        By method, what each pixel sees; at full size where `at_rest`.
    measured : mapping of Specification to Measured
        By method.
    at_rest : bool
        Whether the images are at full size.
    image : (width, height)
        Of the images that were drawn last.
    frame_ms : float
        What the last image of several that moved took to draw; 0 before there are two.
    samples_done : int
    finished : bool
        Whether nothing is left to refine.
    """

    def __init__(self) -> None:
        self._scene: Scene | None = None
        self._images: dict[Specification, MethodImages] = {}
        self._imaged: _Imaged | None = None
        self._detailed: _Detailed | None = None
        self._steps: Steps = (True for _ in ())
        self._underway: Steps | None = None
        self._spent = 0.0
        self._behind = False
        self._before: tuple[Shown, ...] = ()
        self._of_images: dict[tuple[str, ...], Fluency] = {}
        self._of_false_colors = Fluency()
        self._long = False
        self._false_colors = FalseColorTexture(), FalseColorTexture()
        self._shows_false_color = [False, False]
        self._counting = Counting()
        self._first = True
        self.frames: dict[Specification, Frame] = {}
        self.measured: dict[Specification, Measured] = {}
        self.at_rest = False
        self.image: Size = (0, 0)
        self.frame_ms = 0.0
        self.samples_done = 0
        self.finished = False

    def update(self, scene: Scene, state: State, size: Size) -> bool:
        """Draw what has moved, or begin anew with the rest; tells whether anything has, or is still being drawn.

        An image that takes longer than a frame is drawn in several, and shown when it is done.
        """
        methods = tuple(half.method for half in state.halves)
        imaged = _Imaged(shown_camera(state), methods, size, state.resolution, state.samples)
        counts = any(half.aspect == Aspect.COUNTS for half in state.halves)
        detailed = _Detailed(state.halves, state.unit, state.picked is not None, looking_eye(state) if counts else None)
        moved = scene is not self._scene or imaged != self._imaged
        changed = moved or detailed != self._detailed
        if self._underway is not None and (not moved or self._spent < STALE):
            self._behind = changed
            self._draw()
            return True
        self._behind = False
        if not changed:
            return False
        before = self.halves
        self._steps.close()
        if self._underway is not None:
            self._underway.close()
        if scene is not self._scene:
            self._scene, self._images = scene, {}
        self._imaged, self._detailed, self.finished = imaged, detailed, False
        for number, half in enumerate((state.first, state.second)):
            self._shows_false_color[number] &= half.aspect != Aspect.IMAGE
        self._steps = self._resting()
        if moved:
            self.frames, self.measured, self.samples_done, self.at_rest = {}, {}, 0, False
            self._before, self._underway, self._spent = before, self._moving(), 0.0
            self._draw()
        return True

    def rest(self) -> bool:
        """Take a step of refinement, or as much of it as a frame has time for; tells whether there was one."""
        if self._underway is not None:
            self._draw()
            return True
        self.finished = not _go_on(self._steps)
        self._first = True
        return not self.finished

    @property
    def moving(self) -> bool:
        """Whether an image of what has moved is still to be drawn."""
        return self._underway is not None or self._behind

    @property
    def halves(self) -> tuple[Shown, ...]:
        """What there is to show, which is what was there before while something else is drawn.

        Nothing of a half whose method fails.
        """
        if self._underway is not None:
            return self._before
        methods = self._imaged.methods if self._imaged else ()
        colored = zip(methods, self._false_colors, self._shows_false_color, strict=False)
        return tuple(
            Shown(self._of(method).texture, colors.texture if shown else None) for method, colors, shown in colored
        )

    @property
    def failures(self) -> tuple[str, ...]:
        """Why methods draw nothing, or nothing is counted."""
        methods = self._imaged.methods if self._imaged else ()
        counting = self._counting.failure if self._detailed and self._detailed.eye else ""
        return tuple(dict.fromkeys(filter(None, (*(self._of(method).failure for method in methods), counting))))

    @property
    def counting(self) -> bool:
        """Whether vertices are being counted."""
        return bool(self._detailed and self._detailed.eye) and self.at_rest and self._counting.busy

    @property
    def phases(self) -> Mapping[str, float]:
        """What the time of the first half's last image went to, milliseconds."""
        return self._of(self._imaged.methods[0]).phases if self._imaged else {}

    def _of(self, method: Specification) -> MethodImages:
        if method not in self._images:
            assert self._scene is not None
            used = {REFERENCE, *(self._imaged.methods if self._imaged else ())}
            self._images = {name: each for name, each in self._images.items() if name in used}
            self._images[method] = MethodImages(self._scene, method)
        return self._images[method]

    def _draw(self) -> None:
        """Go on with the image of what has moved, for as long as a frame has time."""
        assert self._underway is not None
        began = perf_counter()
        if not _go_on(self._underway):
            self._underway, self._before = None, ()
        self._spent += 1e3 * (perf_counter() - began)

    def _moving(self) -> Steps:
        """An image of what has moved, as coarse as it must be, and its false-colour images."""
        assert self._imaged is not None and self._detailed is not None
        # Nobody knows how long methods take that have drawn nothing yet: they begin with the coarsest image.
        names = tuple(each.method.name for each in self._imaged.methods)
        fluency = self._of_images.get(names, COARSEST)
        resolution = self._imaged.resolution or fluency.resolution
        _, seconds = yield from timed(self._drawing(scaled(self._imaged.size, resolution)))
        spent = 1e3 * seconds
        self._long = spent > LONG * resolution**2
        if not self._imaged.resolution:
            self._of_images[names] = fluency.after(spent)
        if any(half.aspect != Aspect.IMAGE for half in self._detailed.halves):
            coloring = self._coloring(scaled(self._imaged.size, self._of_false_colors.resolution))
            _, seconds = yield from timed(mapped(coloring, _within))
            self._of_false_colors = self._of_false_colors.after(1e3 * seconds)
            self.frames, self.measured = {}, {}
            spent += 1e3 * seconds
        # The first of several may have opened what the others find open.
        if not self._first:
            self.frame_ms = spent
        self._first = False

    def _drawing(self, size: Size) -> Steps:
        """Draw the images at a size."""
        assert self._imaged is not None
        methods = dict.fromkeys(self._imaged.methods)
        for method in methods:
            yield from mapped(self._of(method).drawing(self._imaged.camera, size), _within)
        for method in methods:
            self._of(method).wait()
        self.image = size

    def _resting(self) -> Steps:
        """Everything at full size, in steps none of which takes longer than a frame by a method or the reference."""
        assert self._imaged is not None
        camera, size = self._imaged.camera, self._imaged.size
        methods = dict.fromkeys(self._imaged.methods)
        between = [scaled(size, resolution) for resolution in reversed(RESOLUTIONS)] if self._long else []
        for step in (*between, size):
            if self.image[0] < step[0]:
                for method in methods:
                    yield from mapped(self._of(method).drawing(camera, step), _within)
                    yield True
                self.image = step
        self.at_rest = True
        yield from self._coloring(size)
        # Those are in the mean already that were drawn before something was asked for that moves nothing.
        for shift in shifts(self._imaged.samples)[self.samples_done :]:
            for method in methods:
                yield from mapped(self._of(method).refining(camera, size, shift), _within)
            # None counts for one half and not for the other, whenever this is left.
            for method in methods:
                self._of(method).refine()
            self.samples_done += 1
            yield True

    def _coloring(self, size: Size) -> Steps:
        """What each pixel sees, where false colours or the picked pixel need it, and the false-colour images."""
        assert self._imaged is not None and self._detailed is not None
        halves, picked = self._detailed.halves, self._detailed.picked
        # Counts take longer than an image that moves.
        shown = [
            half for half in halves if half.aspect != Aspect.IMAGE and (self.at_rest or half.aspect != Aspect.COUNTS)
        ]
        seen = [half.method for half in halves if half in shown or picked]
        compared = [half.method for half in halves if half.aspect == Aspect.ERROR or picked]
        for method in dict.fromkeys([*seen, *([REFERENCE] if compared else [])]):
            if method not in self.frames:
                frame = yield from mapped(self._of(method).seeing(self._imaged.camera, size), _within)
                if frame is not None:
                    self.frames[method] = frame
                yield True
        for method in dict.fromkeys(compared):
            if method not in self.measured and {method, REFERENCE} <= self.frames.keys():
                self.measured[method] = measure_half(self.frames[REFERENCE], self.frames[method])
                yield True
        for number, half in enumerate(halves):
            colors = None
            if half.aspect == Aspect.ERROR and half.method in self.measured:
                colors = error_colors(self.measured[half.method], self._detailed.unit)
            elif half.aspect == Aspect.STATUS and half.method in self.frames:
                colors = status_colors(self.frames[half.method])
            elif half.aspect == Aspect.COUNTS and half in shown and half.method in self.frames:
                assert self._scene is not None and self._detailed.eye is not None
                counting = self._counting.counting(self._scene, self._detailed.eye, size)
                counts = yield from mapped(counting, _within)
                if counts is not None:
                    colors = count_colors(self.frames[half.method], self._scene, counts)
            self._shows_false_color[number] = colors is not None
            if colors is not None:
                self._false_colors[number].write(colors)
                yield True


def _go_on(steps: Steps) -> bool:
    """Take steps until a whole one is done, or a frame has no time for more; tells whether there were any."""
    began = perf_counter()
    while (whole := next(steps, None)) is False:
        if 1e3 * (perf_counter() - began) >= FRAME:
            return True
    return whole is not None


def _within(part: object) -> bool:
    """Of a part of a step: that the whole is not done."""
    return False


@lru_cache
def shifts(samples: int) -> tuple[tuple[float, float], ...]:
    """The shifts of samples x samples images, in an order of which every beginning is spread over the pixel."""
    steps = (np.arange(samples) + 0.5) / samples - 0.5
    grid = [(float(x), float(y)) for y, x in product(steps, steps)] if samples > 1 else []
    chosen: list[tuple[float, float]] = []
    while grid:
        # Next to the mean so far, one that brings it nearest to the pixel's centre, and far from those taken.
        taken = np.array(chosen or [(2.0, 2.0)])
        far = [float(np.min(np.sum((taken - place) ** 2, axis=1))) for place in grid]
        mean = [float(np.sum((np.sum(taken, axis=0) + place) ** 2)) if chosen else 0.0 for place in grid]
        best = min(range(len(grid)), key=lambda number: (round(mean[number], 9), -round(far[number], 9)))
        chosen.append(grid.pop(best))
    return tuple(chosen)
