"""Every registered method obeys one contract; new ones are tested by being registered."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, open_view, plane_mirror, scene_with, spherical_mirror

import anamorph
from anamorph.base.errors import AnamorphError
from anamorph.frame import Status
from anamorph.gpu.device import maximum_size
from anamorph.methods import METHODS, Specification

SCENE = scene_with(spherical_mirror())
PACKAGE = Path(anamorph.__file__).parent
SHADERS = sorted(str(path.relative_to(PACKAGE)) for path in PACKAGE.rglob("*.wgsl"))


@pytest.fixture(scope="module")
def sessions():
    """One open session for each method."""
    return {name: open_view(SCENE, name) for name in METHODS}


def check_contract(frame, size):
    width, height = size
    assert frame.color.shape == frame.position.shape == (height, width, 3)
    assert frame.object_id.shape == frame.specular.shape == frame.status.shape == (height, width)
    assert frame.color.dtype == frame.position.dtype == np.float32
    assert frame.object_id.dtype == frame.specular.dtype == np.uint32
    assert frame.status.dtype == np.uint8
    for rays in (frame.ray_origin, frame.ray_direction):
        assert rays is None or (rays.shape == (height, width, 3) and rays.dtype == np.float32)
        assert rays is None or np.isfinite(rays).all()
    assert np.isfinite(frame.color).all() and np.isfinite(frame.position).all()
    assert (frame.color >= 0.0).all()
    assert set(np.unique(frame.status)) <= {int(status) for status in Status}
    assert frame.object_id.max() <= len(SCENE.meshes)
    assert set(np.unique(frame.specular)) <= {0, 1}
    sky = frame.object_id == 0
    assert np.abs(np.linalg.norm(frame.position[sky], axis=-1) - 1.0).max(initial=0.0) < 1e-4
    assert (frame.status[sky & (frame.specular == 0)] == Status.SKY).all()
    assert (frame.status[~sky & (frame.specular == 0)] == Status.DIRECT).all()


@pytest.mark.parametrize("name", METHODS)
def test_the_contract(sessions, name):
    session = sessions[name]
    session.draw(CAMERA)
    session.wait()
    frame = session.frame(seen=True)
    check_contract(frame, SIZE)
    assert (frame.specular == 1).sum() > 5000
    bare = session.frame()
    assert (bare.color == frame.color).all()
    assert bare.position is bare.object_id is bare.specular is bare.status is None


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("size", [(1, 1), (37, 53), (1, 40), (300, 2)])
def test_any_size(name, size):
    check_contract(drawn(SCENE, name, size), size)


@pytest.mark.parametrize(
    "specification", [*METHODS, "pervertex:tolerance=0.5", "pervertex:map=image", "threeray:splat=1"]
)
def test_the_back_of_a_mirror_hides_a_mirror_behind_it(specification):
    screen = plane_mirror("screen", (0.05, 0.3, 0.3), (0.0, 0.4, 0.0), (0.2, 0.0, 0.0))
    scene = scene_with(spherical_mirror(count=4), screen)
    reference, frame = drawn(scene, "raytrace"), drawn(scene, specification)
    hidden = (reference.object_id == 2) & (reference.specular == 0)
    assert hidden.sum() > 200
    # One pixel lies on the screen's edge.
    assert (frame.specular[hidden] > 0).sum() <= 1 and (frame.object_id[hidden] != 2).sum() <= 1


@pytest.mark.parametrize("name", METHODS)
def test_the_same_view_gives_the_same_frame(sessions, name):
    """In two sessions, and again in one after the eye has been elsewhere."""
    first = drawn(SCENE, name)
    session = sessions[name]
    session.draw(type(CAMERA)((-0.3, 0.5, 1.1), CAMERA.target))
    session.frame(seen=True)
    session.draw(CAMERA)
    second = session.frame(seen=True)
    for buffer in ("color", "position", "object_id", "specular", "status", "ray_origin", "ray_direction"):
        one, other = getattr(first, buffer), getattr(second, buffer)
        assert (one is None and other is None) or (one == other).all(), buffer


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("size", [(0, 10), (10, 0), (-5, 5), (10**6, 10)])
def test_sizes_that_no_device_has_are_refused(name, size):
    with pytest.raises(AnamorphError, match=f"from 1 to {maximum_size()}") as caught:
        open_view(SCENE, name, size)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", METHODS)
def test_methods_describe_themselves(name):
    method = METHODS[name]
    assert method.name == name
    assert method.summary and "\n" not in method.summary
    assert method.source
    default = method.options()
    assert Specification.parse(name) == Specification(method, default)
    for key, value in vars(default).items():
        assert type(value) in (bool, int, float, str)
        assert getattr(Specification.parse(f"{name}:{key}={value}").options, key) == value


def test_options_are_read_from_text():
    options = Specification.parse("pervertex:antialias=4, align=No,projective=0,resolution=2").options
    assert (options.antialias, options.align, options.projective, options.resolution) == (4, False, False, 2.0)
    assert isinstance(options.resolution, float)
    assert Specification.parse("pervertex:") == Specification.parse("pervertex")


@pytest.mark.parametrize("name", METHODS)
def test_a_specification_says_what_differs_and_reads_back(name):
    plain = Specification.parse(name)
    assert str(plain) == name
    other = {bool: lambda value: not value, str: lambda value: f"{value}er"}
    for key, value in vars(plain.options).items():
        changed = plain.with_options(**{key: other.get(type(value), lambda value: value + 1)(value)})
        assert changed != plain and str(changed).startswith(f"{name}:{key}=") and "," not in str(changed)
        assert Specification.parse(str(changed)) == Specification.parse(changed) == changed
        assert str(changed.with_options(**{key: value})) == name
        assert len({plain, changed, Specification.parse(str(changed))}) == 2


@pytest.mark.parametrize(
    ("specification", "said"),
    [
        ("pervertx", "did you mean 'pervertex'"),
        ("", "no method ''"),
        ("PERVERTEX", "methods are .*raytrace"),
        ("pervertex:antialias", "write option=value"),
        ("pervertex:antialiasing=4", "options are map, antialias"),
        ("pervertex:antialias=four", "a whole number"),
        ("pervertex:antialias=4.0", "a whole number"),
        ("pervertex:align=maybe", "true or false"),
        ("pervertex:resolution=high", "a number"),
        ("raytrace:bounces=", "a whole number"),
    ],
)
def test_wrong_specifications_are_one_line(specification, said):
    with pytest.raises(AnamorphError, match=said) as caught:
        Specification.parse(specification)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("antialias", 4.5),
        ("antialias", float("inf")),
        ("antialias", None),
        ("antialias", True),
        ("antialias", [4]),
        ("align", 1),
        ("align", None),
        ("resolution", True),
        ("resolution", None),
        ("resolution", "two"),
    ],
)
def test_values_of_the_wrong_type_are_named(key, value):
    with pytest.raises(AnamorphError, match=f"option {key} is") as caught:
        Specification.parse("pervertex").with_options(**{key: value})
    assert "\n" not in str(caught.value)


def test_values_of_another_type_that_mean_the_same_are_taken():
    changed = Specification.parse("pervertex").with_options(antialias=4.0, resolution=2)
    assert changed == Specification.parse("pervertex:antialias=4,resolution=2")


def test_shading_is_in_one_place():
    """No other shader reads lights, materials or the sky by itself."""
    for name in SHADERS:
        if name != "gpu/shading.wgsl":
            source = (PACKAGE / name).read_text()
            assert "lighting." not in source and "diffuse_textures" not in source and "objects[" not in source


def test_no_shader_is_too_long_to_read():
    assert {name: n for name in SHADERS if (n := len((PACKAGE / name).read_text().splitlines())) > 250} == {}
