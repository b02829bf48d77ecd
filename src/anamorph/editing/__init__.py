"""Changing parts of a scene, which keep their exact surfaces.

| module | what it holds |
| --- | --- |
| `edit` | all changes of one part, in their order: bent or ground, turned, moved |
| `bending` | mirrors of closed form, bent to another curvature |
| `arching` | mirrors of patches and CAD faces, bent further |
| `grinding` | lenses of another power or index |

What can be bent: planes and spheres, every `SagSurface`, and, further than they are, Bezier patches and NURBS.
"""
