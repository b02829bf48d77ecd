"""Three-ray cameras: what each triangle of a mirror may see, found in a tree and met by the rays of its own pixels.

Source: Mei, Popescu and Sacks, "A hybrid backward-forward method for interactive reflections" (2007).

| section of the paper | what | module |
| --- | --- | --- |
| 3.1 | the reflected geometry as surfels | `surfels` |
| 4 | the tree over them | `surfel_tree`, `halving` |
| 5 | the cameras of an image | `cameras_seen` |
| | each sample's own ray | `sample_rays` |
| in place of 6 | what each sample's ray meets | `meeting` |
| | cameras of many samples look for it | `surfels_seen` |
| | the samples whose weights are within bounds | `sample_spans` |
| | samples of small cameras go through the tree themselves | `packets` |
| | the triangles that rays meet | `scene_triangles` |
| 5.2 | with `splat`, pairs of a camera and a point that it may see | `points_seen`, `camera_bases` |
| 5.1 | these projected on the device | `projector`: `projected.wgsl` |
| 6 | and drawn as squares | `squares`: `squares.wgsl` |
| | what the device is given for that | `splat_records`: `three_ray_camera.wgsl` |
| | what objects do to light and to rays that leave them | `objects` |
| | where paths end, for the visibility buffer; which of them go on | `camera_records` |
| 7 | what is far, by a map behind what is near | `background` |
| | what stands before a mirror hides it | `hiding`: `hidden.wgsl` |
| | the frame | `threeray` |

Which samples each camera owns, what it may see, bounded linearly (in place of 5.2), and which points it may see twice
(5.1) is in `anamorph.raytriangle`: `owners`, `bounds`, and `seen_once` and `sees_once`.
"""

from anamorph.methods.threeray.surfel_tree import make_tree as make_tree
from anamorph.methods.threeray.threeray import METHOD as METHOD
