"""Running a shader's function over arrays on the device, as the tests of shaders do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device, once
from anamorph.gpu.shaders import shader_module

WORKGROUP = 64
GROUPS = 4
WRITTEN = {"buffer": {"type": "storage"}}


def computed(
    shader: Path, overrides: dict[str, int], count: int, result: np.dtype, groups: dict[int, list[np.ndarray]]
) -> np.ndarray:
    """What the entry point `main` of a shader writes: `count` of `result`.

    It finds arrays at the bindings 0, 1, ... of each of `groups`, and after those of group 0 what it writes.
    """
    stages = wgpu.ShaderStage.COMPUTE
    layouts = [
        layout_of(*[STORAGE] * len(groups.get(group, [])), *[WRITTEN] * (group == 0), stages=stages)
        for group in range(GROUPS)
    ]
    device = get_device()

    def pipeline() -> wgpu.GPUComputePipeline:
        stage = {"module": shader_module(shader), "entry_point": "main", "constants": overrides}
        return device.create_compute_pipeline(
            layout=device.create_pipeline_layout(bind_group_layouts=layouts), compute=stage
        )

    made = once(f"test pipeline {shader} {sorted(overrides.items())}", pipeline)
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    written = device.create_buffer(size=count * result.itemsize, usage=usage)
    encoder = device.create_command_encoder()
    compute_pass = encoder.begin_compute_pass()
    compute_pass.set_pipeline(made)
    for group, layout in enumerate(layouts):
        # A buffer may not be empty.
        held = [storage_buffer(np.append(array, np.zeros(4, array.dtype))) for array in groups.get(group, [])]
        compute_pass.set_bind_group(group, bind(layout, held + [written] * (group == 0)))
    compute_pass.dispatch_workgroups(-(-count // WORKGROUP))
    compute_pass.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(written), result)
