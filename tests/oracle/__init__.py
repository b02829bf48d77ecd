"""A second tracer, written for the tests alone, and the random scenes that it judges the package's frames in.

It shares nothing with the package: float64, analytic surfaces, a tree of boxes of its own, no Embree.

| what | module |
| --- | --- |
| what a scene is to the tracer | `scene` |
| vectors, compiled | `vectors` |
| where a ray meets a plane, sphere, cylinder or cone | `quadrics` |
| where a ray meets a toroid or an even asphere | `sags` |
| the part of a surface that is there | `trims` |
| where a ray meets a trimmed shape of any kind | `shapes` |
| triangles and their tree of boxes | `triangles` |
| paths of light | `tracer` |
| how far, in pixels, a frame is from what the tracer sees | `judging` |
| which sub-rays of a pixel see what a frame shows | `subrays` |
| meshes over surfaces | `meshes` |
| mirrors, lenses and other parts | `parts` |
| boxes all around, and an eye | `surroundings` |
| families of random scenes | `families`, `mirror_families`, `lens_families`, `hard_families` |
| scenes on which a method once failed | `found` |
| from these scenes to the package's, and from its lenses to these | `conversion` |

Of these only `conversion`, the families and `found` lean on `anamorph`: the tracer and its judgement stand
alone.
"""
