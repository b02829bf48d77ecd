"""Environment mapping: each pixel looks up its reflected ray's direction alone, in a cube map around the mirror.

Source: Blinn and Newell, "Texture and reflection in computer generated images" (1976); cube maps after Greene,
"Environment mapping and other applications of world projections" (1986).

| part of the papers | what | module |
| --- | --- | --- |
| Greene: the cube | six images of the scene, from the middle of a mirror | `cube_map` |
| Blinn and Newell: reflection | look up the reflected direction | `environment` |
| | the same for a shader, also of another method | `cube_map.wgsl` |
| in neither | flat mirrors, by the scene drawn from the mirrored eye | a special case of `methods.pervertex` |
"""

from anamorph.methods.environment.cube_map import CubeMap as CubeMap
from anamorph.methods.environment.cube_map import cube_layout as cube_layout
from anamorph.methods.environment.environment import METHOD as METHOD
