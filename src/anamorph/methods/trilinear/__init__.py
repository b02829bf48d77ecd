"""Trilinear projection: every scene triangle projected through every ray triangle that may see it.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005). What is not in it makes the edges exact: each sample
decides by its own ray what it sees. A shader that is not listed has the name of its module.

| chapter of the thesis | what | module |
| --- | --- | --- |
| 6, 7.2, 7.3 | ray triangles: a camera's, or those of mirrors and lenses as the eye sees them | `ray_triangles` |
| 2 | a sample's ray, as polynomials of the image | `beams` |
| 3.1 to 3.6 | where a ray triangle sees a point: the cubic and its roots | `raytriangle` |
| 3.7 | which scene triangles a ray triangle may see | `box_tree`, `pairs`, `plan` |
| not in it | whether a ray meets a scene triangle, by the pair's quadratics | `terms` |
| not in it | what each sample sees: the nearest pair that its ray meets | `sights`, `sample_sights` |
| 4, 5 | in place of these two: straight lines between projected corners | `straight` |
| 7.2.3 | rays that go on from a mirror seen in a mirror | `samples`, `following` |
| not in it | where each sample's path ends, for the visibility buffer | `visibility`, `path_ends` |
| | all of this for the rays of one bounce, and as the device reads it | `ray_layer`, `ray_records` |
| | all bounces, and the frame | `trilinear` |
"""

from anamorph.methods.trilinear.trilinear import METHOD as METHOD
