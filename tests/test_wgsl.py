"""Reading what shaders declare: by the examples of WGSL's own text, and as the shaders of the package write it."""

from __future__ import annotations

import pytest
from wgsl import bound, constants, declared, layout_of

# WGSL, section 14.4.2, "Structure Member Layout".
EXAMPLE = """
struct A {                                     //             align(8)  size(24)
    u: f32,                                    // offset(0)   align(4)  size(4)
    v: f32,                                    // offset(4)   align(4)  size(4)
    w: vec2<f32>,                              // offset(8)   align(8)  size(8)
    x: f32                                     // offset(16)  align(4)  size(4)
    // -- implicit struct size padding --      // offset(20)            size(4)
}

struct B {                                     //             align(16) size(160)
    a: vec2<f32>,                              // offset(0)   align(8)  size(8)
    // -- implicit member alignment padding -- // offset(8)             size(8)
    b: vec3<f32>,                              // offset(16)  align(16) size(12)
    c: f32,                                    // offset(28)  align(4)  size(4)
    d: f32,                                    // offset(32)  align(4)  size(4)
    // -- implicit member alignment padding -- // offset(36)            size(4)
    e: A,                                      // offset(40)  align(8)  size(24)
    f: vec3<f32>,                              // offset(64)  align(16) size(12)
    // -- implicit member alignment padding -- // offset(76)            size(4)
    g: array<A, 3>,    // element stride 24       offset(80)  align(8)  size(72)
    h: i32                                     // offset(152) align(4)  size(4)
    // -- implicit struct size padding --      // offset(156)           size(4)
}
"""


def test_structures_lie_as_in_the_example_of_the_standard():
    structures = declared(EXAMPLE)
    first, second = layout_of("A", structures), layout_of("B", structures)
    assert (first.size, first.alignment, second.size, second.alignment) == (24, 8, 160, 16)
    assert first.members == {"u": 0, "v": 4, "w": 8, "x": 16}
    assert second.members == {"a": 0, "b": 16, "c": 28, "d": 32, "e": 40, "f": 64, "g": 80, "h": 152}
    assert second.words[-1] == (152, "i") and len(second.words) == 2 + 3 + 2 + 5 + 3 + 3 * 5 + 1


@pytest.mark.parametrize(
    ("kind", "size", "alignment", "stride"),
    [
        ("u32", 4, 4, 4), ("vec2u", 8, 8, 8), ("vec3f", 12, 16, 16), ("vec4f", 16, 16, 16), ("mat4x4f", 64, 16, 64),
        ("mat3x3f", 48, 16, 48), ("mat3x2f", 24, 8, 24), ("array<vec3f, 4>", 64, 16, 64), ("array<f32, 5>", 20, 4, 20),
    ],
)  # fmt: skip
def test_sizes_and_alignments(kind, size, alignment, stride):
    found = layout_of(kind, {})
    assert (found.size, found.alignment, found.stride) == (size, alignment, stride)


def test_several_members_on_a_line_and_their_attributes():
    text = "struct C {\n    x: f32, y: u32, // z: i32,\n    @location(0) @interpolate(flat) w: array<A, 3>,\n}\n"
    assert declared(text) == {"C": [("x", "f32"), ("y", "u32"), ("w", "array<A, 3>")]}


def test_constants_and_buffers():
    text = "const A = 3u;\nconst B = 0x80000000u;\nconst C = 2.8e-14;\nconst D = vec3f(1.0);\noverride E: i32 = 1;\n"
    assert constants(text) == {"A": 3.0, "B": 2.0**31, "C": 2.8e-14}
    text = (
        "var<uniform> a: P;\nvar<storage, read> b: array<Q>;\nvar<storage> c: array<u32, 6>;\nvar t: texture_2d<f32>;"
    )
    assert list(bound(text)) == ["P", "Q", "u32"]
