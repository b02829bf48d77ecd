"""The laws of reflection and refraction, as properties."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from anamorph.methods.tracing.bounces import schlick, through_glass
from anamorph.optics.laws import fresnel, reflect, refract

# Cosines from straight on to grazing within 1e-9, with the ends drawn on purpose.
cosines = st.one_of(st.sampled_from([1.0, 1.0 - 1e-12, 1e-3, 1e-6, 1e-9]), st.floats(1e-9, 1.0))
frames = arrays(float, (2, 3), elements=st.floats(-1, 1)).filter(lambda rows: np.linalg.norm(np.cross(*rows)) > 1e-2)
etas = st.one_of(st.sampled_from([1.0, 1 / 1.5, 1.5, 1.0 + 1e-12]), st.floats(0.3, 3.0))


def ray(frame, cosine):
    """A unit normal, a unit tangent, and a unit ray onto the surface at `cosine`."""
    normal = frame[0] / np.linalg.norm(frame[0])
    tangent = np.cross(normal, frame[1])
    tangent /= np.linalg.norm(tangent)
    return normal, tangent, np.sqrt((1 - cosine) * (1 + cosine)) * tangent - cosine * normal


@given(frames, cosines)
def test_reflection_keeps_the_tangent_and_turns_the_normal_part(frame, cosine):
    normal, tangent, incident = ray(frame, cosine)
    (out,) = reflect(incident[None], normal[None])
    assert abs(np.linalg.norm(out) - 1) < 1e-14
    assert abs(out @ normal - cosine) < 1e-15 + 1e-15 * cosine * 10
    assert abs(out @ tangent - incident @ tangent) < 1e-15 * 10
    assert np.allclose(reflect(out[None], normal[None])[0], incident, atol=1e-15 * 10)
    assert np.allclose(reflect(incident[None], -normal[None])[0], out, atol=0)


@given(frames, cosines, etas)
def test_refraction_obeys_snell(frame, cosine, eta):
    normal, tangent, incident = ray(frame, cosine)
    direction, total = refract(incident[None], normal[None], eta)
    sine = eta * np.sqrt((1 - cosine) * (1 + cosine))
    assert abs(np.linalg.norm(direction[0]) - 1) < 1e-12
    if abs(sine - 1) < 1e-12:
        return
    assert total[0] == (sine > 1)
    if total[0]:
        assert np.array_equal(direction, reflect(incident[None], normal[None]))
        return
    assert abs(direction[0] @ tangent - sine) < 1e-14
    assert direction[0] @ normal <= 0
    assert abs(direction[0] @ np.cross(normal, tangent)) < 1e-14


@given(frames, cosines, etas)
def test_refraction_runs_back_the_same_way(frame, cosine, eta):
    normal, _, incident = ray(frame, cosine)
    direction, total = refract(incident[None], normal[None], eta)
    if total[0] or -direction[0] @ normal < 1e-4:
        return
    back, total = refract(-direction, -normal[None], 1 / eta)
    if total[0]:
        # The last digit decides whether a ray comes back out along the surface.
        assert cosine < 1e-7
        return
    # Back through, an error of the sine grows by 1 / cosine.
    assert np.allclose(back[0], -incident, atol=1e-14 / max(cosine, 1e-7))


def test_normal_incidence_goes_straight_on():
    direction, total = refract(np.array([[0, 0, -1.0]]), np.array([[0, 0, 1.0]]), 1.5)
    assert np.array_equal(direction, [[0, 0, -1]]) and not total[0]


def test_total_reflection_starts_at_the_critical_angle():
    critical = np.arcsin(1 / 1.5)
    angles = critical + np.array([-1e-9, 1e-9])
    incident = np.stack([np.sin(angles), np.zeros(2), -np.cos(angles)], axis=-1)
    direction, total = refract(incident, np.tile([0, 0, 1.0], (2, 1)), 1.5)
    assert total.tolist() == [False, True]
    assert direction[0, 2] < 0 < direction[1, 2]


def test_a_ratio_for_every_ray():
    incident = np.tile([0.6, 0, -0.8], (3, 1))
    direction, _ = refract(incident, np.tile([0, 0, 1.0], (3, 1)), np.array([0.5, 1.0, 1.2]))
    assert np.allclose(direction[:, 0], [0.3, 0.6, 0.72])


@given(st.floats(0, 1), st.floats(0, 1))
def test_schlick_runs_from_its_reflectance_to_one(reflectance, cosine):
    assert schlick(reflectance, 1.0) == reflectance
    assert schlick(reflectance, 0.0) == 1.0
    assert reflectance - 1e-15 <= schlick(reflectance, cosine) <= 1.0 + 1e-15


@given(etas, cosines)
def test_fresnel_is_a_share_and_the_same_both_ways(eta, cosine):
    share = fresnel(eta, np.array([cosine]))[0]
    assert 0.0 <= share <= 1.0 + 1e-12
    transmitted = 1 - eta**2 * (1 - cosine) * (1 + cosine)
    if transmitted > 1e-6:
        assert abs(fresnel(1 / eta, np.sqrt([transmitted]))[0] - share) < 1e-6
    elif transmitted < 0:
        assert abs(share - 1.0) < 1e-12


def test_fresnel_at_normal_incidence_and_at_brewsters_angle():
    assert np.isclose(fresnel(1 / 1.5, np.array([1.0]))[0], 0.04)
    brewster = np.arctan(1.5)
    across = (np.cos(2 * brewster)) ** 2 / 2
    assert np.isclose(fresnel(1 / 1.5, np.cos([brewster]))[0], across)


@given(frames, cosines, etas)
def test_the_compiled_glass_is_that_of_the_laws(frame, cosine, eta):
    normal, _, incident = ray(frame, cosine)
    sine = eta * np.sqrt((1 - cosine) * (1 + cosine))
    # There the last digit decides whether light crosses.
    assume(abs(sine - 1) > 1e-9)
    bent, share, crosses = through_glass(tuple(incident), tuple(normal), eta)
    direction, total = refract(incident[None], normal[None], eta)
    assert crosses != total[0]
    assert np.allclose(bent, direction[0], rtol=0, atol=1e-13)
    # The compiled cosine comes from a dot product, whose rounding counts where Fresnel's share is steep.
    expected = 1.0 if total[0] else 1.0 - fresnel(eta, np.array([cosine]))[0]
    assert abs(share - expected) < 1e-6


@given(st.floats(0, 1), st.one_of(cosines, st.just(0.0)))
def test_the_compiled_schlick_is_his(reflectance, cosine):
    assert abs(schlick(reflectance, cosine) - (reflectance + (1.0 - reflectance) * (1.0 - cosine) ** 5)) < 1e-15
