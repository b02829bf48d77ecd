"""The car mirror as a driver sees it, and what each pixel of it sees."""

import numpy as np

import anamorph as an

frame = an.render("car-mirror", method="pervertex", size=(640, 480), antialias=4, seen=True)
frame.save("mirror.png")

scene, _ = an.open_scene("car-mirror")
in_mirror = frame.specular != 0
objects, pixels = np.unique(frame.object_id[in_mirror], return_counts=True)
print(f"{in_mirror.sum()} of {in_mirror.size} pixels look at the mirror; there they see, most of all:")
for number, count in sorted(zip(objects, pixels, strict=True), key=lambda pair: -pair[1])[:5]:
    print(f"{count:8} {scene.meshes[number - 1].name if number else 'the sky'}")
