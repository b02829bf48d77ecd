"""Bind groups: what a shader's `@group` finds, in the order of its `@binding` numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import wgpu

from anamorph.gpu.device import get_device, once

UNIFORM: dict[str, Any] = {"buffer": {"type": "uniform"}}
STORAGE: dict[str, Any] = {"buffer": {"type": "read-only-storage"}}
SAMPLER: dict[str, Any] = {"sampler": {}}


def texture(view: str = "2d", filterable: bool = True) -> dict[str, Any]:
    """A texture's entry in a layout; `rgba32float` cannot be filtered."""
    return {"texture": {"view_dimension": view, "sample_type": "float" if filterable else "unfilterable-float"}}


def numbers() -> dict[str, Any]:
    """The entry of a texture of whole numbers."""
    return {"texture": {"view_dimension": "2d", "sample_type": "uint"}}


def depths() -> dict[str, Any]:
    """The entry of a texture of depths."""
    return {"texture": {"view_dimension": "2d", "sample_type": "depth"}}


def layout_of(*entries: dict[str, Any], stages: int = wgpu.ShaderStage.FRAGMENT) -> wgpu.GPUBindGroupLayout:
    """A layout with bindings 0, 1, ... for `stages`; whoever asks for the same gets the same."""
    numbered = [{"binding": number, "visibility": stages, **entry} for number, entry in enumerate(entries)]
    return once(f"layout {numbered}", lambda: get_device().create_bind_group_layout(entries=numbered))


def bind(layout: wgpu.GPUBindGroupLayout, resources: Sequence[Any]) -> wgpu.GPUBindGroup:
    """Bind buffers, texture views and samplers to 0, 1, ... of `layout`."""
    entries = [
        {"binding": number, "resource": {"buffer": item} if isinstance(item, wgpu.GPUBuffer) else item}
        for number, item in enumerate(resources)
    ]
    return get_device().create_bind_group(layout=layout, entries=entries)
