"""What own_ray.wgsl binds: group 3 of every shader in which pixels bend their own rays at exact surfaces."""

from __future__ import annotations

import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import of_device
from anamorph.optics.exact_sides import ExactSides

SPECTRUM = 1, 0, 2
"""Of the visibility buffer's lines: green, red and blue light by their numbers in the spectrum."""


@of_device
def exact_layout() -> wgpu.GPUBindGroupLayout:
    """The layout: exact surfaces, what bends rays at them, and the vertices' parameters."""
    return layout_of(*3 * [STORAGE], stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT)


def bind_exact(sides: ExactSides) -> wgpu.GPUBindGroup:
    """Copy the exact surfaces of a scene to the device, and bind them."""
    return bind(exact_layout(), [storage_buffer(each) for each in (sides.numbers, sides.records, sides.parameters)])
