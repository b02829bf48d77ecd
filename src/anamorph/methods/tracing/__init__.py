"""Light paths, a ray for every pixel: for the reference, for the tiles that a method doubts, and for inspection.

| what | module |
| --- | --- |
| how paths begin | `launch` |
| one bounce of many paths | `bounces` |
| paths on all the cores, to their ends | `paths` |
| the first bounce along the interpolated rays of ray meshes | `vertex_rays` |
| traced pixels, shaded on the device | `tiles` |
"""

from anamorph.methods.tracing.paths import PathTracer as PathTracer
