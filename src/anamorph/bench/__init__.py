"""Measurements that take minutes: `anamorph bench NAME`.

| name | what is timed | where |
| --- | --- | --- |
| `deforming` | frames of a scene that deforms | `deforming` |
| `editing` | a step of a slider of the viewer | `editing` |
| `virtual` | frames of Estalella et al., "Accurate interactive specular reflections" (2005) | `virtual_objects` |
| `trilinear` | tables and figures of Vallance, "Trilinear projection" (PhD thesis, 2005) | `thesis` |

`./run bench viewer`, which needs a browser and what drives it, is `tests/bench/viewer.py`.
"""
