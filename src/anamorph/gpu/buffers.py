"""A scene on the device: vertices, triangles, materials, lights, textures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.gpu.bindings import SAMPLER, STORAGE, UNIFORM, bind, layout_of, texture
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.textures import sky_texture, texture_array, texture_sampler
from anamorph.scene.geometry import Geometry
from anamorph.scene.model import AmbientLight, Diffuse, Glass, Mirror, PointLight, Scene, Texture

VERTEX = np.dtype(
    [("position", "f4", 3), ("normal", "f4", 3), ("texcoord", "f4", 2), ("color", "u2", 4), ("object", "u4")]
)
"""One vertex, as scene.wgsl and raytrace.wgsl read it."""

SPARE = 1.25
"""How much larger than needed a buffer is made: a moving eye does not bring a new one every frame."""

MOST_LIGHTS = 1024
"""Directional and point lights of a scene, as many as shading.wgsl has space for."""

OBJECT = np.dtype(
    [
        ("color", "f4", 3),
        ("texture_layer", "u4"),
        ("tint", "f4", 3),
        ("parameter", "f4"),
        ("kind", "u4"),
        ("padding", "u4", 3),
    ]
)

WRAPS = {"repeat": 0, "clamp": 1, "mirror": 2}
"""What lies beyond a texture's edges, as shading.wgsl has it."""

VERTEX_LAYOUT = {
    "array_stride": VERTEX.itemsize,
    "attributes": [
        {"shader_location": 0, "format": "float32x3", "offset": 0},
        {"shader_location": 1, "format": "float32x3", "offset": 12},
        {"shader_location": 2, "format": "float32x2", "offset": 24},
        {"shader_location": 3, "format": "unorm16x4", "offset": 32},
        {"shader_location": 4, "format": "uint32", "offset": 40},
    ],
}


@dataclass(frozen=True, eq=False)
class SceneBuffers:
    """What shading and drawing bind.

    Parameters
    ----------
    vertices, indices : buffers
    first_face : (meshes + 1,) int64
        Mesh i owns triangles first_face[i] to first_face[i + 1].
    specular, mirrors : tuple of int
        Indices of the meshes that are mirrors or glass, and of the mirrors alone.
    specular_meshes, textured : (meshes,) bool
        Whether a mesh is specular, and whether it has a texture.
    sky_image : bool
        Whether the sky is an image.
    shading : bind group
        Group 0 of every shader.
    """

    vertices: wgpu.GPUBuffer
    indices: wgpu.GPUBuffer
    first_face: np.ndarray
    specular: tuple[int, ...]
    mirrors: tuple[int, ...]
    specular_meshes: np.ndarray
    textured: np.ndarray
    sky_image: bool
    shading: wgpu.GPUBindGroup


@of_device
def shading_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 0: lighting, objects, textures and sky."""
    stages = wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
    return layout_of(UNIFORM, STORAGE, texture("2d-array"), SAMPLER, texture(), SAMPLER, stages=stages)


def upload_scene(scene: Scene, geometry: Geometry) -> SceneBuffers:
    """Copy a scene to the device."""
    textures = _distinct_textures(scene)
    objects = _objects(scene, textures)
    resources = [
        get_device().create_buffer_with_data(data=_lighting(scene), usage=wgpu.BufferUsage.UNIFORM),
        storage_buffer(objects),
        texture_array(textures).create_view(dimension="2d-array"),
        texture_sampler(),
        sky_texture(scene.sky.image).create_view(dimension="2d"),
        texture_sampler(vertical="clamp-to-edge"),
    ]
    return SceneBuffers(
        vertices=storage_buffer(pack_vertices(geometry), wgpu.BufferUsage.VERTEX),
        indices=storage_buffer(geometry.faces.astype(np.uint32), wgpu.BufferUsage.INDEX),
        first_face=geometry.first_face,
        specular=tuple(i for i, mesh in enumerate(scene.meshes) if mesh.specular),
        mirrors=tuple(i for i, mesh in enumerate(scene.meshes) if isinstance(mesh.material, Mirror)),
        specular_meshes=np.array([mesh.specular for mesh in scene.meshes], bool),
        textured=objects["texture_layer"] > 0,
        sky_image=scene.sky.image is not None,
        shading=bind(shading_layout(), resources),
    )


def _most_bytes(needed: int) -> int:
    """The most that one buffer may take; an error where that is less than the bytes that are `needed`."""
    limits = get_device().limits
    limit = min(limits["max-buffer-size"], limits["max-storage-buffer-binding-size"]) // 16 * 16
    if needed > limit:
        raise AnamorphError(
            f"scene: needs {needed / 2**20:.0f} MiB in one buffer, and the device takes {limit / 2**20:.0f}; "
            "simplify its meshes"
        )
    return limit


def storage_buffer(data: np.ndarray, usage: int = 0) -> wgpu.GPUBuffer:
    """A buffer that shaders can read, filled with `data`."""
    _most_bytes(data.nbytes)
    return get_device().create_buffer_with_data(
        data=np.ascontiguousarray(data), usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_DST | usage
    )


def grown_buffer(buffer: wgpu.GPUBuffer | None, needed: int) -> wgpu.GPUBuffer:
    """`buffer` if it has the bytes that are needed, else a new one with some to spare."""
    if buffer is not None and buffer.size >= needed:
        return buffer
    limit = _most_bytes(needed)
    size = min((max(needed, int(SPARE * needed)) + 15) & ~15, limit)
    return get_device().create_buffer(size=size, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_DST)


def upload_vertices(buffers: SceneBuffers, vertices: np.ndarray) -> None:
    """Replace all vertices of a scene, (V,) of `VERTEX`."""
    get_device().queue.write_buffer(buffers.vertices, 0, vertices)


def pack_vertices(geometry: Geometry) -> np.ndarray:
    """The vertices as the device reads them, (V,) of `VERTEX`."""
    vertices = np.zeros(len(geometry.positions), VERTEX)
    vertices["position"] = geometry.positions
    vertices["normal"] = geometry.normals
    vertices["texcoord"] = geometry.texcoords
    vertices["color"][:, :3] = np.rint(np.clip(geometry.colors, 0.0, 1.0) * 65535.0)
    vertices["object"] = geometry.vertex_object
    return vertices


def _distinct_textures(scene: Scene) -> tuple[Texture, ...]:
    textures = [mesh.material.texture for mesh in scene.meshes if isinstance(mesh.material, Diffuse)]
    return tuple({id(texture): texture for texture in textures if texture is not None}.values())


def _objects(scene: Scene, textures: tuple[Texture, ...]) -> np.ndarray:
    layers = {id(texture): _texture_layer(layer, texture) for layer, texture in enumerate(textures, start=1)}
    objects = np.zeros(len(scene.meshes), OBJECT)
    for row, mesh in zip(objects, scene.meshes, strict=True):
        match mesh.material:
            case Diffuse(color=color, texture=image):
                row["color"], row["texture_layer"] = color, layers.get(id(image), 0)
            case Glass(tint=tint, index=index):
                row["color"], row["tint"], row["parameter"], row["kind"] = 1.0, tint, index, 2
            case Mirror(back=back, tint=tint, reflectance=share):
                row["color"], row["tint"], row["parameter"], row["kind"] = back, tint, share, 1
    return objects


def _texture_layer(layer: int, texture: Texture) -> int:
    """The layer of a texture and how it goes on beyond its edges, as the shader's `texture_layer`."""
    across, down = (WRAPS[wrap] for wrap in texture.wraps)
    return layer | across << 16 | down << 18


def _lighting(scene: Scene) -> np.ndarray:
    """The shader's `Lighting` structure, as 32-bit words."""
    lights = [light for light in scene.lights if not isinstance(light, AmbientLight)]
    ambient = [light for light in scene.lights if isinstance(light, AmbientLight)]
    if len(lights) > MOST_LIGHTS:
        raise AnamorphError(f"scene: has {len(lights)} lights, and {MOST_LIGHTS} are the most; leave the weakest out")
    words = np.zeros((5 + 2 * MOST_LIGHTS, 4), np.float32)
    flags = words.view(np.uint32)
    words[0, :3] = np.sum([light.sky for light in ambient] or [(0, 0, 0)], axis=0)
    words[1, :3] = np.sum([light.ground for light in ambient] or [(0, 0, 0)], axis=0)
    words[2, :3], words[3, :3], words[4, :3] = scene.sky.zenith, scene.sky.horizon, scene.sky.nadir
    # Where there is no light, the last one is black.
    flags[6 + 2 * max(len(lights) - 1, 0), 3] = 1
    for i, light in enumerate(lights):
        if isinstance(light, PointLight):
            words[5 + 2 * i, :3], flags[5 + 2 * i, 3] = light.position, 1
        else:
            words[5 + 2 * i, :3] = np.asarray(light.toward) / np.linalg.norm(light.toward)
        words[6 + 2 * i, :3] = light.color
    return words
