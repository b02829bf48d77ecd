"""Each shader says what it needs: no more, and no less."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest
import wgpu

import anamorph
from anamorph.base.errors import AnamorphError
from anamorph.gpu.device import get_device
from anamorph.gpu.shaders import joined, needs, shader_module

PACKAGE = Path(anamorph.__file__).parent
SHADERS = sorted(str(path.relative_to(PACKAGE)) for path in PACKAGE.rglob("*.wgsl"))


def compiles(texts: Iterable[str]) -> bool:
    try:
        get_device().create_shader_module(code="\n".join(texts))
    except wgpu.GPUError:
        return False
    return True


def reached(shaders: Iterable[str], barred: str | Path) -> set[str]:
    """The shaders and all that they need, without going through one of them."""
    found, waiting = set(), [shader for shader in shaders if shader != barred]
    while waiting:
        shader = waiting.pop()
        if shader not in found and shader != barred:
            found.add(shader)
            waiting += needs((PACKAGE / shader).read_text())
    return found


def superfluous(shader: str | Path) -> list[str]:
    """What a shader says it needs, and compiles without or gets from what else it needs."""
    texts = joined(shader)
    wanted = needs(texts[shader])
    again = [need for need in wanted if need in reached(set(wanted) - {need}, shader)]
    return again + [need for need in wanted if compiles(text for name, text in texts.items() if name != need)]


@pytest.mark.parametrize("shader", SHADERS)
def test_every_shader_compiles_with_what_it_needs_and_not_without(shader):
    assert shader_module(shader) is not None
    assert superfluous(shader) == []


def test_what_is_not_needed_is_found(tmp_path):
    shader = tmp_path / "own.wgsl"
    shader.write_text("// Red.\n// needs: gpu/map.wgsl, gpu/scene.wgsl\nfn red() -> u32 { return STATUS_SKY; }\n")
    assert superfluous(shader) == ["gpu/scene.wgsl", "gpu/map.wgsl"]


def test_a_shader_that_lacks_what_it_needs_does_not_compile(tmp_path):
    shader = tmp_path / "own.wgsl"
    shader.write_text("// Red.\n// needs: gpu/vertices.wgsl\nfn red() -> u32 { return STATUS_SKY; }\n")
    assert not compiles(joined(shader).values())


def test_a_shader_of_another_package_takes_what_it_needs_from_this_one(tmp_path):
    shader = tmp_path / "own.wgsl"
    shader.write_text("// Red.\n// needs: gpu/scene.wgsl\nfn red() -> u32 { return STATUS_SKY; }\n")
    assert list(joined(shader)) == ["gpu/shading.wgsl", "gpu/scene.wgsl", shader]
    assert shader_module(shader) is not None


def test_shaders_that_need_each_other_are_taken_once():
    names = list(joined("raytriangle/points.wgsl", "raytriangle/weights.wgsl"))
    assert sorted(names) == [name for name in SHADERS if name.startswith("raytriangle/")]


@pytest.mark.parametrize("named", ["own.wgsl", "gpu/scenery.wgsl"])
def test_what_does_not_exist_is_said_in_one_line(tmp_path, named):
    shader = tmp_path / "own.wgsl"
    if named != shader.name:
        shader.write_text(f"// Red.\n// needs: {named}\n")
    with pytest.raises(AnamorphError, match=f"{named}: there is no such file") as caught:
        joined(shader)
    assert "\n" not in str(caught.value)
    assert named == shader.name or f"{shader} needs it" in str(caught.value)
