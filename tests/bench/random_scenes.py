"""A few hundred random scenes, each drawn by a method and judged by the tests' own second tracer.

Run it with `./run bench random-scenes`, or `python -m tests.bench.random_scenes`. It prints a line for every scene in
which less than 99.9% of the pixels of mirrors and lenses are within half a pixel, and then figures by family and of all
scenes together. The same command draws the same scenes. It stands here and not in the package because the tracer does.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from oracle.conversion import shown_by
from oracle.families import FAMILIES, make
from oracle.found import FOUND
from oracle.judging import Judgement, judge
from oracle.scene import Scene
from oracle.tracer import Tracer

from anamorph import AnamorphError, Status

ENOUGH = 99.9
"""Percent of the pixels: a scene with fewer within half a pixel has a line of its own."""


@dataclass
class Tally:
    """Counts of pixels, summed over scenes."""

    scenes: int = 0
    below: int = 0
    refused: int = 0
    plain: int = 0
    wrong: int = 0
    other: int = 0
    silhouette: int = 0
    missed: int = 0
    unanswered: int = 0
    largest: float = 0.0
    wrong_by_status: Counter = field(default_factory=Counter)
    by_status: Counter = field(default_factory=Counter)

    def add(self, judgement: Judgement) -> None:
        self.scenes += 1
        self.plain += int(judgement.plain.sum())
        self.wrong += int(judgement.wrong.sum())
        self.other += int(judgement.other.sum())
        self.silhouette += int(judgement.silhouette.sum())
        self.missed += int(judgement.missed.sum())
        self.unanswered += int(judgement.unanswered.sum())
        self.largest = max(self.largest, float(judgement.angles.max()))
        self.wrong_by_status.update(judgement.wrong_by_status())
        self.by_status.update(judgement.status[judgement.counted].tolist())

    def merge(self, other: Tally) -> None:
        largest = max(self.largest, other.largest)
        for name, value in vars(other).items():
            setattr(self, name, getattr(self, name) + value)
        self.largest = largest

    @property
    def within(self) -> float:
        """Percent of the pixels away from silhouettes that show the right object, half a pixel off at most."""
        return percent(self.plain - self.wrong, self.plain)

    def __str__(self) -> str:
        wrong = ", ".join(f"{count} {Status(status).name}" for status, count in self.wrong_by_status.most_common())
        return (
            f"{self.within:8.3f}% within 0.5 px  {percent(self.other, self.plain):7.3f}% other object  "
            f"{percent(self.silhouette - self.missed, self.silhouette):7.2f}% at silhouettes  "
            f"{self.largest:.0e} rad at most  wrong: {wrong or 'none'}"
        )


def percent(part: int, whole: int) -> float:
    return 100.0 * part / whole if whole else 100.0


def chosen(count: int, seed: int, families: list[str]) -> Iterator[tuple[str, str, Scene]]:
    """`count` scenes, the families by turns: of each the name, the seed and the scene."""
    for number in range(count):
        family, own = families[number % len(families)], seed + number // len(families)
        yield family, str(own), make(family, own)


def run(scenes: Iterator[tuple[str, str, Scene]], methods: list[str], size: tuple[int, int]) -> dict[str, Tally]:
    """Judge every scene by every method, and print what is bad; returns the sums by method."""
    tallies: dict[str, dict[str, Tally]] = {method: {} for method in methods}
    start = time.monotonic()
    for number, (family, seed, scene) in enumerate(scenes, start=1):
        tracer = Tracer(scene)
        for method in methods:
            pooled, own = tallies[method].setdefault(family, Tally()), Tally()
            try:
                own.add(judge(tracer, scene.camera, shown_by(scene, method, size)))
            except AnamorphError as error:
                own.refused = 1
                print(f"{method}  {family} {seed}: refused: {error}", flush=True)
            if own.within < ENOUGH:
                own.below = 1
                print(f"{method}  {family} {seed}: {own}", flush=True)
            pooled.merge(own)
        if sys.stderr.isatty():
            print(f"\r{number} scenes, {time.monotonic() - start:.0f} s ", end="", file=sys.stderr, flush=True)
    return {method: _printed(method, by_family) for method, by_family in tallies.items()}


def _printed(method: str, by_family: dict[str, Tally]) -> Tally:
    total = Tally()
    print(f"\n{method}: by family")
    for family, tally in by_family.items():
        total.merge(tally)
        print(f"{family:22s} {tally.scenes:4d} scenes, {tally.below:3d} under {ENOUGH}%  {tally}")
    print(f"{'all':22s} {total.scenes:4d} scenes, {total.below:3d} under {ENOUGH}%  {total}")
    counted = sum(total.by_status.values())
    shares = (
        f"{Status(status).name} {percent(count, counted):.2f}%" for status, count in total.by_status.most_common()
    )
    left_out = percent(total.unanswered, counted + total.unanswered)
    print(f"status of all pixels judged: {', '.join(shares)}; {left_out:.2f}% have no answer and are not judged")
    return total


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="random_scenes", description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300, help="how many scenes, the families by turns")
    parser.add_argument("--method", "-m", action="append", help="may be repeated")
    parser.add_argument("--size", default="320x240", help="WIDTHxHEIGHT")
    parser.add_argument("--seed", type=int, default=0, help="of the first scene of each family")
    parser.add_argument("--family", action="append", choices=list(FAMILIES), help="only this one; may be repeated")
    parser.add_argument("--found", action="store_true", help="the scenes on which a method once failed, instead")
    options = parser.parse_args(arguments)
    width, height = map(int, options.size.split("x"))
    families = options.family or list(FAMILIES)
    scenes = (
        ((name, "found", maker()) for name, maker in FOUND.items())
        if options.found
        else chosen(options.count, options.seed, families)
    )
    run(scenes, options.method or ["pervertex:tolerance=0.5"], (width, height))


if __name__ == "__main__":
    main()
