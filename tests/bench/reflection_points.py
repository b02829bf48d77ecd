"""How many of all reflection points are found, how many are spurious, and what a point takes.

Run it with `./run bench reflection-points`. It prints a line for each mirror and lens: of how many points how many
places are found, how many of one point, how many of the truth's are missed, how many it does not have, how many of all
break the law of reflection or refraction, of how many points the status is not `FOUND`, and the processor time of a
point. Points behind a lens lie on rays that go through it, and their rays are the truth; of the ball it is the plane of
its center. Then it prints this time by how many pieces a mirror has.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
from reflected_truth import (
    CENTER,
    RADIUS,
    Trial,
    ball_points,
    dense_points,
    door_mirror,
    normal_at,
    points_before,
    ripples,
    saddle,
    toroid,
    torus,
    unmatched,
    whole_ball,
)
from refracted_truth import TRIALS, LensTrial, rays_through
from refracted_truth import ball_points as glass_ball_points

from anamorph import reflection_points, refraction_points
from anamorph.reflections import charts
from anamorph.reflections.searching import MirrorSearch

BALLS = (
    ("ball, convex", (0.6, 0.6, 1.7), False),
    ("ball, eye inside", (0.4, 0.3, -0.75), True),
    ("ball, eye near its centre", (0.12, 0.21, -0.27), True),
    ("ball, eye near its wall", (0.6, 0.6, 0.4), True),
)


def ball_trial(eye: tuple[float, float, float], concave: bool, count: int) -> tuple[Trial, np.ndarray]:
    """A ball, and points outside or inside."""
    random = np.random.default_rng(3)
    ways = random.normal(size=(count, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    far = np.exp(random.uniform(np.log(0.01), np.log(10.0), (count, 1)))
    inside = 0.999 * random.uniform(0.0, 1.0, (count, 1)) ** (1 / 3)
    return whole_ball(np.array(eye), concave), CENTER + RADIUS * ways * (inside if concave else 1.0 + far)


def report(name: str, trial: Trial, points: np.ndarray, truth) -> None:
    """Print the line of one mirror."""
    search = MirrorSearch.of(trial.mesh, trial.eye)
    search.find(points[:10])
    start = time.process_time()
    search.find(points)
    spent = 1e6 * (time.process_time() - start) / len(points)
    found = reflection_points(trial.scene, trial.eye, points)
    who, places = truth(trial, points)[:2]
    order = np.argsort(who, kind="stable")
    who, places = who[order], places[order]
    missed = len(unmatched(who, places, found.point, found.position, 1e-9 * trial.size))
    more = len(unmatched(found.point, found.position, who, places, 1e-9 * trial.size))
    normals = normal_at(trial, found.parameters)
    ways = [end - found.position for end in (trial.eye, points[found.point])]
    both = sum(way / np.linalg.norm(way, axis=1, keepdims=True) for way in ways)
    wrong = int((np.linalg.norm(np.cross(both, normals), axis=1) > 1e-8).sum())
    unsure = int((found.point_status > 0).sum())
    print(
        f"{name:26} {len(points):7} {len(found.point):7} {found.counts.max():4} {missed:7} {more:7} {wrong:7} "
        f"{unsure:7} {len(search.pieces.chart.parents):7} {spent:8.1f}",
        flush=True,
    )


def report_lens(name: str, trial: LensTrial, count: int) -> None:
    """Print the line of one lens."""
    entries, exits, ways = rays_through(trial, count, 17)
    far = np.exp(np.random.default_rng(18).uniform(np.log(1e-3), np.log(300.0), (len(exits), 1)))
    points, who = exits + trial.size * far * ways, np.arange(len(exits))
    refraction_points(trial.scene, trial.eye, points[:10])
    start = time.process_time()
    found = refraction_points(trial.scene, trial.eye, points)
    spent = 1e6 * (time.process_time() - start) / len(points)
    more: int | str = "-"
    if name == "glass_ball":
        truth = glass_ball_points(trial.index, trial.eye, points)
        who, entries = np.repeat(who, [len(each) for each in truth]), np.concatenate(truth)
        more = len(unmatched(found.point, found.position[:, 0], who, entries, 1e-9 * trial.size))
    # Where a caustic passes near the point, rounding of the point itself moves its place.
    missed = len(unmatched(who, entries, found.point, found.position[:, 0], 1e-7 * trial.size))
    near, far_face = (face.surface for face in trial.faces)
    legs = [
        found.position[:, 0] - trial.eye,
        np.diff(found.position, axis=1)[:, 0],
        points[found.point] - found.position[:, 1],
    ]
    legs = [leg / np.linalg.norm(leg, axis=1, keepdims=True) for leg in legs]
    bent = [
        np.linalg.norm(np.cross(before * legs[k] - after * legs[k + 1], surface.normal(found.parameters[:, k])), axis=1)
        for k, (surface, before, after) in enumerate(((near, 1.0, trial.index), (far_face, trial.index, 1.0)))
    ]
    wrong = int((np.maximum(*bent) > 1e-8).sum())
    unsure = int((found.point_status > 0).sum())
    print(
        f"{name:26} {len(points):7} {len(found.point):7} {found.counts.max():4} {missed:7} {more:>7} {wrong:7} "
        f"{unsure:7} {'':7} {spent:8.1f}",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=100_000, help="random points for each mirror")
    parser.add_argument("--only", nargs="*", help="names of mirrors, or their first letters")
    chosen = parser.parse_args()
    print("mirror                      points   found most  missed    more   wrong  unsure  pieces  us/point")

    def wanted(name: str) -> bool:
        return not chosen.only or any(name.startswith(each) for each in chosen.only)

    for name, eye, concave in BALLS:
        if wanted(name):
            trial, points = ball_trial(eye, concave, chosen.points)

            def quartic(trial: Trial, points: np.ndarray, concave: bool = concave) -> tuple[np.ndarray, np.ndarray]:
                return ball_points(np.array(CENTER), RADIUS, trial.eye, points, concave)

            report(name, trial, points, quartic)
    for make in (saddle, toroid, torus, door_mirror, ripples):
        if wanted(make.__name__):
            trial = make()
            report(make.__name__, trial, points_before(trial, chosen.points), dense_points)
    for name, make_lens in TRIALS.items():
        if wanted(name):
            report_lens(name, make_lens(), chosen.points)
    if not chosen.only:
        trial = torus()
        points = points_before(trial, 20_000)
        for cells in (16, 32, 64, 128):
            charts.CELLS = cells
            # What was prepared for another mesh is not used again.
            search = MirrorSearch.of(torus().mesh, trial.eye)
            search.find(points[:10])
            start = time.process_time()
            count = len(search.find(points).point)
            spent = 1e6 * (time.process_time() - start) / len(points)
            print(f"torus in {len(search.pieces.chart.parents):7} pieces: {spent:6.1f} us a point, {count} found")


if __name__ == "__main__":
    main()
