"""Reflection points: where on its mirrors an eye sees a point of the scene, and how often.

| module | what it does |
| --- | --- |
| `charts` | cuts a mirror into pieces |
| `cone_tree` | tells which pieces may send a ray to a point |
| `path_length` | finds where the length of the path is stationary |
| `trims` | tells what belongs to the mirror |
| `searching` | finds all the reflection points of a point on one mirror |
| `reflection_points` | does so for many points and all the mirrors of a scene |
"""
