"""What ray triangles see of scene triangles, against a ray for each of many image points, by brute force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from trilinear_twin import (
    IMAGES,
    RAYS,
    TRIANGLES,
    RayTriangles,
    evaluated,
    held,
    image_points,
    magnitudes,
    meet,
    planned,
    ray_triangle,
    scene_triangles,
)

from anamorph import cameras
from anamorph.gallery import make
from anamorph.gallery.cube import CAMERA, cube_scene
from anamorph.methods.trilinear import plan as plan_module
from anamorph.methods.trilinear.pairs import ALL, FRONTS, NONE, Own
from anamorph.methods.trilinear.pieces import make_workspace
from anamorph.methods.trilinear.plan import Plan, Planner
from anamorph.methods.trilinear.terms import ROUNDING, TERMS
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raymesh import RayMesh
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Mirror, Scene

QUICK = settings(max_examples=150, phases=(Phase.explicit, Phase.generate))
MARGIN = 1.0 / 64.0
AROUND = MARGIN * np.array([(np.cos(angle), np.sin(angle)) for angle in np.arange(8) * np.pi / 4])
NOISE = 1e-11
"""Of float64 in the pair's functions, as a share of what they are the differences of."""


def check(rays: RayTriangles, triangles: np.ndarray, points: np.ndarray, near: float = 0.0) -> int:
    """Hold a plan against brute force at image points. Returns the number of hits."""
    beams, plan = planned(rays, triangles, near)
    pace = np.linalg.norm(rays.directions[0], axis=1).max()
    meeting = meet(rays, triangles, points)
    sure = meeting.own[:, None] & meeting.sure(near / pace)
    hits = sure & meeting.hit(near / pace)
    if not len(beams.number):
        return 0
    places = points - beams.center[0]
    rows = {(face, side): row for row, (_, face, side) in enumerate(plan.pair.tolist())}
    assert len(rows) == len(plan.pair)
    for face in range(len(triangles)):
        for side in range(2):
            hit = hits[:, face] & (meeting.front[:, face] == (side == 1))
            row = rows.get((face, side))
            if row is None:
                assert not hit.any(), "no pair"
                continue
            values, _ = evaluated(plan.terms[row], places)
            noise = NOISE * magnitudes(rays, triangles[face], beams, places)
            assert (values >= -noise)[hit].all(), "inside"
            pieces = plan.place[plan.owner == row]
            assert len(pieces)
            for step in AROUND:
                assert held(pieces, places[hit] + step).all(), "pieces"
            x, y = np.abs(beams.domain[0, : beams.corners[0]]).max(axis=0)
            _, most = evaluated(plan.terms[row], np.array([[x, y]]))
            slack = noise + np.array([ROUNDING, ROUNDING, ROUNDING, 0.0, 0.0]) * 1.01 * most
            missed = sure[:, face] & ~hit
            assert (values <= slack)[missed].any(axis=1).all(), "outside"
            exact(meeting, face, hit, values, noise, slack, beams.near[0])
    return int(np.count_nonzero(hits))


def exact(meeting, face, hit, values, noise, slack, near):
    """The quadratics' shares are the weights, and N t over N is t."""
    total = values[hit, :3].sum(axis=1)
    weights = values[hit, :3] / total[:, None]
    doubt = slack[hit, :3].sum(axis=1) / total
    expected = meeting.weights[hit, face].astype(float)
    assert (np.abs(weights - expected) <= 2.0 * doubt[:, None]).all(), "weights"
    t = near + values[hit, 4] / values[hit, 3]
    expected = meeting.t[hit, face].astype(float)
    doubt = (noise[hit, 4] + noise[hit, 3] * expected) / values[hit, 3]
    assert (np.abs(t - expected) <= doubt).all(), "t"


@QUICK
@given(
    st.sampled_from(RAYS),
    st.sampled_from(IMAGES),
    st.sampled_from(TRIANGLES),
    st.sampled_from([0.0, 0.7]),
    st.integers(0, 2**32 - 1),
)
def test_a_plan_holds_what_rays_meet(rays, image, kind, near, seed):
    random = np.random.default_rng(seed)
    seen_by = ray_triangle(rays, image, random)
    triangles, places = scene_triangles(kind, seen_by, 12, random)
    check(seen_by, triangles, np.concatenate([places, image_points(seen_by, 150, random)]), near)


def scene(count: int = 40, seed: int = 0, rays: int = 30) -> tuple[RayTriangles, np.ndarray]:
    """Many ray triangles, and triangles that several of them see."""
    random = np.random.default_rng(seed)
    parts = [ray_triangle("any", "any", random) for _ in range(rays)]
    seen_by = RayTriangles(*(np.concatenate(each) for each in zip(*parts, strict=True)))
    middles = random.normal(size=(count, 1, 3)) + np.array([0.0, 0.0, 3.0])
    return seen_by, middles + random.normal(scale=0.5, size=(count, 3, 3))


def rows_of(plan: Plan) -> set[tuple[int, int, int]]:
    return set(map(tuple, plan.pair.tolist()))


def test_many_ray_triangles_are_planned_as_one_by_one():
    rays, triangles = scene()
    beams, plan = planned(rays, triangles)
    for k, number in enumerate(beams.number):
        _, alone = planned(RayTriangles(*(each[number : number + 1] for each in rays)), triangles)
        rows = plan.pair[:, 0] == k
        assert (plan.pair[rows, 1:] == alone.pair[:, 1:]).all()
        assert (plan.terms[rows] == alone.terms).all()
        assert (plan.place[rows[plan.owner]] == alone.place).all()


@pytest.mark.parametrize("count", [0, 1, 3])
def test_nothing_to_see_and_nothing_that_sees(count):
    rays, triangles = scene()
    none = RayTriangles(*(each[:0] for each in rays))
    few = RayTriangles(*(each[:count] for each in rays))
    for seen_by, seen in ((none, triangles), (few, triangles[:0]), (few, triangles - [0.0, 0.0, 1000.0])):
        _, plan = planned(seen_by, seen)
        assert plan.pair.shape == (0, 3) and plan.terms.shape == (0, TERMS)
        assert plan.place.shape == (0, 3, 2) and plan.owner.shape == (0,)


@pytest.mark.parametrize("use", [1, 2, 5])
def test_any_number_of_cores_and_any_capacity_give_the_same_plan(use, monkeypatch):
    rays, triangles = scene(200)
    _, expected = planned(rays, triangles)
    assert len(expected.pair) > 500
    monkeypatch.setattr(plan_module, "cores", lambda: use)
    monkeypatch.setattr(plan_module, "make_workspace", growing_from(3, 7))
    planner = Planner()
    for _ in range(2):
        _, plan = planned(rays, triangles, planner=planner)
        for name in ("pair", "terms", "place", "owner"):
            assert (getattr(plan, name) == getattr(expected, name)).all()


def growing_from(pairs: int, pieces: int):
    """Arrays that are small at first."""
    return lambda wanted, more: make_workspace(*((pairs, pieces) if wanted == 1024 else (wanted, more)))


@pytest.mark.parametrize("sees", [ALL, FRONTS, NONE])
def test_a_ray_triangle_sees_of_its_own_group_what_it_may(sees):
    rays, triangles = scene()
    group = (np.arange(len(triangles)) % 3).astype(np.int32)
    count = len(rays.image)
    own = Own(
        np.arange(count, dtype=np.int32),
        (np.arange(count) % 3).astype(np.int32),
        np.full(count, sees, np.int32),
    )
    beams, everything = planned(rays, triangles)
    _, plan = planned(rays, triangles, group=group, own=own)
    expected = {
        (k, face, side)
        for k, face, side in rows_of(everything)
        if face != beams.number[k]
        and (group[face] != beams.number[k] % 3 or sees == ALL or (sees == FRONTS and side == 1))
    }
    assert rows_of(plan) == expected
    assert 0 < len(expected) < len(everything.pair)


def test_the_front_is_where_corners_run_counter_clockwise():
    rays = RayTriangles(
        np.array([[[0.0, 0.0, 1.0], [100.0, 0.0, 1.0], [0.0, 100.0, 1.0]]]),
        np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]),
        np.array([[[0.0, 0.0, -1.0]] * 3]),
    )
    upward = np.array([[[0.1, 0.1, -2.0], [0.3, 0.1, -2.0], [0.1, 0.3, -2.0]]])
    for triangles, side in ((upward, 1), (upward[:, ::-1], 0)):
        _, plan = planned(rays, triangles)
        assert plan.pair.tolist() == [[0, 0, side]]
    for near, count in ((1.9, 1), (2.1, 0)):
        assert len(planned(rays, upward, near)[1].pair) == count


def test_what_is_nearer_than_near_is_not_seen():
    """In metres along the longest of the three rays."""
    rays = RayTriangles(
        np.array([[[0.0, 0.0, 1.0], [100.0, 0.0, 1.0], [0.0, 100.0, 1.0]]]),
        np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]),
        np.array([[[0.0, 0.0, 5.0]] * 3]),
    )
    leaning = np.array([[[-1.0, -1.0, -1.0], [3.0, -1.0, 3.0], [0.3, 4.0, 0.3]]])
    points = np.random.default_rng(1).uniform(0.0, 50.0, (300, 2))
    assert 20 < check(rays, leaning, points, 0.4) < check(rays, leaning, points, 0.0)


def triangles_of(scene: Scene) -> np.ndarray:
    geometry = flatten(scene)
    return geometry.positions[geometry.faces].astype(float)


def corners_of(rays: RayMesh) -> RayTriangles:
    return RayTriangles(rays.image[rays.faces], rays.origins[rays.faces], rays.directions[rays.faces])


def from_camera(rays: RayMesh) -> tuple[RayTriangles, np.ndarray]:
    return corners_of(rays), triangles_of(cube_scene())


def from_mirrors(name: str) -> tuple[RayTriangles, np.ndarray]:
    scene = make(name)
    eye = scene.camera.eye((400, 400))
    meshes = [
        corners_of(reflected_rays(reflector(mesh), eye)) for mesh in scene.meshes if isinstance(mesh.material, Mirror)
    ]
    return RayTriangles(*(np.concatenate(each) for each in zip(*meshes, strict=True))), triangles_of(scene)


SEEN = {
    "pinhole": lambda: from_camera(cameras.pinhole(CAMERA, (400, 400))),
    "detail and context": lambda: from_camera(cameras.detail_and_context(CAMERA, (400, 400))),
    "inward sphere": lambda: from_camera(cameras.inward_sphere((0.0, 0.0, 0.0), 2.0, (400, 400))),
    "refracting plane": lambda: from_camera(cameras.refracting_plane(CAMERA, (400, 400))),
    "cube in sphere": lambda: from_mirrors("cube-in-sphere"),
    "cube in wavy mirror": lambda: from_mirrors("cube-in-wavy-mirror"),
}


@pytest.mark.parametrize("name", SEEN)
def test_pieces_are_little_larger_than_what_is_seen_in_them(name):
    _, plan = planned(*SEEN[name](), size=(400, 400))
    random = np.random.default_rng(5)
    corners = plan.place.astype(float)
    sides = corners[:, 1:] - corners[:, :1]
    areas = 0.5 * np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    weights = random.dirichlet([1.0] * 3, (len(corners), 12))
    places = np.einsum("tpi,tix->tpx", weights, corners)
    values = np.stack([evaluated(terms, at)[0] for terms, at in zip(plan.terms[plan.owner], places, strict=True)])
    seen = areas @ (values >= 0.0).all(axis=-1).mean(axis=1)
    assert areas.sum() < 1.25 * seen
