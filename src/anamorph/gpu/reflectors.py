"""Drawing one mesh of the scene with a lookup of its own at each vertex."""

from __future__ import annotations

import wgpu

from anamorph.gpu.buffers import VERTEX, VERTEX_LAYOUT, SceneBuffers

REFLECTOR_BUFFERS = (
    VERTEX_LAYOUT,
    {"array_stride": 16, "attributes": [{"shader_location": 5, "format": "float32x4", "offset": 0}]},
)
"""Vertex buffers: the scene's vertices, and four floats a vertex of the mesh."""


def draw_reflector(
    render_pass: wgpu.GPURenderPassEncoder, buffers: SceneBuffers, index: int, lookups: wgpu.GPUBuffer | None = None
) -> None:
    """Draw mesh `index` with the current pipeline, and `lookups` as its second vertex buffer."""
    vertex, start = int(buffers.first_vertex[index]), int(buffers.first_face[index])
    render_pass.set_index_buffer(buffers.indices, "uint32")
    render_pass.set_vertex_buffer(0, buffers.vertices, vertex * VERTEX.itemsize)
    if lookups is not None:
        render_pass.set_vertex_buffer(1, lookups)
    # Indices count through the whole scene, and both vertex buffers begin at this mesh.
    render_pass.draw_indexed(3 * (int(buffers.first_face[index + 1]) - start), 1, 3 * start, -vertex)
