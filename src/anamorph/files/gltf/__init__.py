"""glTF files, in and out.

| module | what it holds |
| --- | --- |
| `container` | the header of a .gltf or .glb file, and the bytes that it names |
| `accessors` | numbers, dense and sparse |
| `primitives` | triangles, strips and fans, in the shape that morph weights give them |
| `nodes` | which nodes are shown, where they stand, and skins |
| `gltf_materials` | diffuse materials, mirrors and glass; images and how they go on beyond their edges |
| `gltf_shapes` | all of these together: what a file shows |
| `exporting` | a scene as a .glb file |
"""
