"""Reflection points and refraction points: where an eye sees a point in mirrors and through lenses, and how often.

| module | what it does |
| --- | --- |
| `charts` | cuts a mirror, or a face of a lens, into pieces |
| `cone_tree` | tells which pieces may send a ray to a point |
| `seeds` | says where to search on these |
| `path_length`, `lens_length` | tell how the length of the path changes, over a mirror and through a lens |
| `stationary`, `through_lens` | find where it is stationary |
| `beside` | finds the feet of points close to a surface |
| `trims` | tells what belongs to the mirror |
| `distinct` | searches from all starts and from twins, and keeps each place once |
| `searching`, `lens_searching` | find all the places of a point on one mirror, or through one lens |
| `reflection_points`, `refraction_points` | do so for many points and all the mirrors or lenses of a scene |
| `open_paths` | tells which paths nothing hides |
"""
