"""What is there: meshes with their materials and exact surfaces, lights, sky and eye.

| module | what it holds |
| --- | --- |
| `model` | `Scene`, `Mesh`, materials, lights, sky: frozen data |
| `camera` | the pinhole camera, and the eye alone |
| `checks` | whether a scene can be drawn, and what to mend |
| `geometry` | a scene as flat arrays, with one numbering for rays and drawing |
| `parts` | what belongs together by its names, as users name it |
| `lens_pairs` | which meshes are the two faces of a lens |
| `connected` | which mirror meshes are one mirror, because they touch |
| `pose` | where a part is, and how it is turned |
| `subdivision` | finer triangles on an exact surface |
| `triangles` | normals and areas of triangles |
"""
