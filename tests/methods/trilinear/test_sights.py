"""What samples see, against rays by brute force, and what rays that go on know of those that they follow."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from scenes import SIZE, open_view
from trilinear_twin import (
    IMAGES,
    RAYS,
    TRIANGLES,
    beams_of,
    looked,
    meet,
    ray_triangle,
    scene_triangles,
)
from trilinear_twin import SIZE as TWIN_SIZE

from anamorph.base.compiled import compiled
from anamorph.gallery import make
from anamorph.methods.trilinear.pairs import FEW
from anamorph.methods.trilinear.ray_records import SPECULAR
from anamorph.methods.trilinear.terms import is_inside
from anamorph.raytriangle.owners import owners_of, places_of

QUICK = settings(max_examples=100, phases=(Phase.explicit, Phase.generate))
SEEDS = st.integers(0, 2**32 - 1)


@compiled
def _inside(terms: np.ndarray, places: np.ndarray, found: np.ndarray) -> None:
    for k in range(len(places)):
        found[k] = is_inside(terms, places[k, 0], places[k, 1])


def signs(terms: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Whether none of the three quadratics and the two linear functions is negative at places (N, 2)."""
    x, y = places.T
    square = np.stack([x * x, x * y, y * y, x, y, np.ones_like(x)])
    return (terms[:18].reshape(3, 6) @ square >= 0.0).all(axis=0) & (terms[18:].reshape(2, 3) @ square[3:] >= 0.0).all(
        axis=0
    )


@QUICK
@given(SEEDS)
def test_a_place_is_inside_where_no_term_is_negative(seed):
    random = np.random.default_rng(seed)
    terms = random.normal(size=24) * random.integers(0, 2, 24)
    terms[[5, 11, 17, 20, 23]] += 1.5
    places = random.uniform(-2.0, 2.0, (200, 2))
    found = np.zeros(len(places), bool)
    _inside(terms, places, found)
    assert (found == signs(terms, places)).all()
    assert not signs(np.where(np.arange(24) == 20, -1e9, terms), places).any()


def test_nothing_is_outside_of_its_own_border():
    found = np.zeros(2, bool)
    _inside(np.zeros(24), np.array([[0.0, 0.0], [-3.0, 4.0]]), found)
    assert found.all()
    for last in (5, 11, 17, 20, 23):
        below = np.zeros(24)
        below[last] = -1e-300
        _inside(below, np.zeros((2, 2)), found)
        assert not found.any()


def owned(rays) -> np.ndarray:
    """Find the owner of each sample, (height, width), for one ray triangle or none."""
    owner = np.empty(TWIN_SIZE[::-1], np.int32)
    owners_of(places_of(rays.image, TWIN_SIZE), TWIN_SIZE, None, np.empty(TWIN_SIZE[::-1]), owner)
    return owner


@QUICK
@given(
    st.sampled_from(RAYS), st.sampled_from(IMAGES), st.sampled_from(TRIANGLES), st.booleans(), st.integers(0, 2**32 - 1)
)
def test_samples_see_what_their_rays_meet_first(rays, image, kind, few, seed):
    """Few samples send their rays down the tree, and of many only bounds are tried."""
    random = np.random.default_rng(seed)
    seen_by = ray_triangle(rays, image, random)
    triangles, _ = scene_triangles(kind, seen_by, 12, random)
    owner = owned(seen_by)
    row, column = np.nonzero(owner == 0)
    if few:
        owner[row[FEW // 2 :], column[FEW // 2 :]] = -1
    beams, frames = beams_of(seen_by)
    sights = looked(beams, frames, owner, triangles)
    assert not sights.seen[owner < 0].any()
    row, column = np.nonzero(owner == 0)
    some = random.permutation(len(row))[:200]
    row, column = row[some], column[some]
    meeting = meet(seen_by, triangles, np.column_stack([column, row]))
    # Where neither a border nor a grazing ray leaves it open, nor two triangles at one distance.
    extent = np.abs(meeting.weights).max(axis=-1)
    doubtful = (np.abs(meeting.weights).min(axis=-1) <= 1e-6 * extent) | ~meeting.sure()
    t = np.where(meeting.hit(), meeting.t, np.inf).astype(float)
    nearest = np.sort(t, axis=1)
    clear = meeting.own & ~doubtful.any(axis=1)
    clear &= ~(nearest[:, 0] >= (1.0 - 1e-6) * nearest[:, 1]) | np.isinf(nearest[:, 0])
    expected = np.where(np.isfinite(nearest[:, 0]), t.argmin(axis=1) + 1, 0)
    assert (sights.seen[row, column] == expected)[clear].all()
    met = clear & (expected > 0)
    assert np.allclose(sights.way[row, column][met], nearest[met, 0], rtol=1e-4)


@pytest.fixture(scope="module")
def layers():
    """What two layers see between facing mirrors."""
    scene = make("facing-mirrors")
    session = open_view(scene, "trilinear", SIZE)
    session.draw(scene.camera)
    return session.diagnostics()


def test_following_rays_know_what_they_follow_and_how_light_came(layers):
    (first, second), (before, after), world = layers["layers"], layers["sights"], layers["triangles"]
    row, column = np.nonzero(after.owner >= 0)
    assert len(row) > 1000
    # Those of the samples that see a mirror's front, and no others.
    sees = (before.owner >= 0) & (before.seen & SPECULAR > 0)
    face = (before.seen & ~SPECULAR).astype(int) - 1
    assert (after.owner >= 0)[sees & world.mirror[face]].mean() > 0.999
    assert (sees & world.mirror[face])[row, column].all()
    source, record = first.records[before.owner[row, column]], second.records[after.owner[row, column]]
    assert (record["face"] == face[row, column]).all() and (record["object"] == world.object[record["face"]]).all()
    assert (record["first"] == source["object"]).all() and (record["first"] != record["object"]).all()
    assert (record["met"] == 2).all() and (record["exists"] == 1).all()

    def at(kind: str, names: tuple[str, str, str], of: np.ndarray) -> np.ndarray:
        x, y = column - of["center_x"], row - of["center_y"]
        a, b, c = (of[f"{kind}_{name}"] for name in names)
        return x[:, None] * a + y[:, None] * b + c

    # The direction before the mirror is that of the rays which come to it.
    incident, coming = (at(kind, ("x", "y", "one"), of) for kind, of in (("incident", record), ("direction", source)))
    assert np.abs(incident - coming).max() <= 1e-3 * np.linalg.norm(coming, axis=1).min()
