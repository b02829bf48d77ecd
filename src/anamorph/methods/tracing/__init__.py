"""Light paths, a ray for every pixel: for the reference, for what a method doubts, and for inspection.

| what | module |
| --- | --- |
| how paths begin | `launch` |
| one bounce of many paths | `bounces` |
| how a ray leaves the surface where it has been bent | `leaving` |
| paths on all the cores, to their ends | `paths` |
| the first bounce along the interpolated rays of ray meshes | `vertex_rays` |
| where paths end, as the visibility buffer holds it | `packing` |
| what a method doubts, listed on the device and traced | `doubt`: `doubtful.wgsl`, `replaced.wgsl` |
"""

from anamorph.methods.tracing.launch import GivenRays as GivenRays
from anamorph.methods.tracing.paths import PathTracer as PathTracer
