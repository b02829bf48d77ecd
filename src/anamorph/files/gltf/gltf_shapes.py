"""What a glTF file shows: shapes in the world, each with its material."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import note
from anamorph.files.gltf.container import Container, opened
from anamorph.files.gltf.gltf_materials import GltfMaterial, GltfMaterials
from anamorph.files.gltf.nodes import joint_matrices, shown_nodes, world_matrices
from anamorph.files.gltf.primitives import Primitive, primitive
from anamorph.files.model_shape import ModelShape, cofactors
from anamorph.scene.model import Diffuse, Glass


def gltf_shapes(data: bytes, path: Path) -> list[ModelShape]:
    """The shapes of the bytes of a .gltf or .glb file, by the numbers of their nodes.

    Raises
    ------
    AnamorphError
        One line that says which entry of the header, or which file that it names, is wrong.
    """
    container = opened(data, path)
    materials = GltfMaterials(container)
    try:
        world, shapes = world_matrices(container), []
        for number in shown_nodes(container):
            shapes += list(_shapes_of(container, materials, number, world))
    except AnamorphError:
        raise
    except (ArithmeticError, AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        # A header of other types than the specification's: each is some entry that is missing or no object.
        said = str(error) or type(error).__name__
        raise AnamorphError(f"{path}: its glTF header is damaged ({said:.120}); export it again") from None
    materials.tell()
    return shapes


def _shapes_of(
    container: Container, materials: GltfMaterials, number: int, world: list[np.ndarray]
) -> Iterator[ModelShape]:
    node = container.entry("nodes", number)
    if "mesh" not in node:
        return
    mesh = container.entry("meshes", node["mesh"])
    name, where = str(node.get("name") or mesh.get("name") or "part"), f"mesh {node['mesh']}"
    if "EXT_mesh_gpu_instancing" in node.get("extensions", {}):
        note(f"{container.path}: part '{name}': its instances by EXT_mesh_gpu_instancing are left out, but for one")
    found = [
        primitive(container, entry, node.get("weights", mesh.get("weights", [])), where) for entry in mesh["primitives"]
    ]
    if None in found:
        note(f"{container.path}: part '{name}': its points and lines are left out")
    for each in filter(None, found):
        shape = _shape(f"{container.path}: part '{name}'", name, each, materials[each.material], world[number])
        if each.joints is not None and "skin" in node:
            shape = _skinned(container, shape, each, joint_matrices(container, node["skin"], world), where)
        yield shape


def _shape(where: str, name: str, of: Primitive, material: GltfMaterial, matrix: np.ndarray) -> ModelShape:
    texcoords, colors = of.values.get(material.coordinates), of.values.get("COLOR_0")
    looks = material.material
    if isinstance(looks, Diffuse) and looks.texture is not None and texcoords is None:
        note(f"{where}: has no {material.coordinates}; its image is left out")
        looks = replace(looks, texture=None)
    if material.thin and isinstance(looks, Glass) and not _is_closed(of):
        note(f"{where}: is glass without a volume, and open; light goes straight through it")
        looks = replace(looks, index=1.0, abbe=None)
    if texcoords is not None:
        texcoords = texcoords @ material.transform[:2, :2].T + material.transform[:2, 2]
    return ModelShape(
        name=name,
        positions=of.values["POSITION"],
        faces=of.faces,
        normals=of.values.get("NORMAL"),
        matrix=matrix,
        material=looks,
        material_name=material.name,
        texcoords=texcoords,
        colors=None if colors is None else np.clip(colors[:, :3], 0.0, 1.0),
    )


def _is_closed(of: Primitive) -> bool:
    """Whether every edge belongs to two triangles, where vertices in one place are one."""
    positions = of.values["POSITION"]
    inside = len(of.faces) and of.faces.max() < len(positions) and np.isfinite(positions).all()
    if not inside:
        return False
    welded = trimesh.Trimesh(positions, of.faces, process=False)
    welded.merge_vertices(merge_tex=True, merge_norm=True)
    return bool(welded.is_watertight)


def _skinned(container: Container, shape: ModelShape, of: Primitive, joints: np.ndarray, where: str) -> ModelShape:
    """The shape in the world, as its joints hold it: where its own node stands does not count."""
    assert of.joints is not None and of.shares is not None
    if of.joints.max(initial=0) >= len(joints):
        container.wrong(f"{where}: names joint {of.joints.max()}, and its skin has {len(joints)}")
    by = np.zeros((len(shape.positions), 4, 4))
    for joint, share in zip(of.joints.T, of.shares.T, strict=True):
        by += share[:, None, None] * joints[joint]
    turned, faces = by[:, :3, :3], shape.faces
    positions = np.einsum("vij,vj->vi", turned, shape.positions) + by[:, :3, 3]
    normals = None if shape.normals is None else np.einsum("vij,vj->vi", cofactors(turned), shape.normals)
    if faces.max(initial=-1) < len(positions):
        # Joints that mirror turn triangles inside out.
        mirrored = np.linalg.det(turned) < 0.0
        faces = np.where(mirrored[faces].all(axis=1)[:, None], faces[:, ::-1], faces)
    return replace(shape, positions=positions, faces=faces, normals=normals, matrix=np.eye(4))
