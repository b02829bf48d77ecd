"""Files that scenes come from, and scene files in and out. Imports go down this table, never up.

| module | what it holds |
| --- | --- |
| `view_file` | scene files that keep a view and its changes apart |
| `opening` | whatever names a scene, as a scene |
| `model_scene`, `own_mirror` | a scene around a model; a CAD mirror in place of a scene's own |
| `scene_file`, `part_tables` | the tables of a scene file, as a scene |
| `models` | models of every kind as meshes in the world |
| `gltf` | glTF, in and out |
| `obj`, `mtl`, `ply`, `ply_elements`, `stl` | OBJ, PLY and STL files as shapes |
| `polygons`, `units_and_axes` | polygons as triangles; the unit and axes of a file |
| `materials`, `model_shape`, `normals` | colours without a rule, what a file holds, and normals that it lacks |
| `cad`, `trimming`, `opencascade` | faces of CAD files, their triangles, and the process that reads them |
| `source_words`, `source` | the words that name a scene, and what they mean |
| `tables`, `key_lines`, `toml` | TOML in, with the lines of mistakes, and out |
| `reading` | bytes, text and textures from files |
"""
