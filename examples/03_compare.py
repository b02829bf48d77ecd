"""How far two methods are from the ray-traced reference, and how long they take beside it."""

from pathlib import Path

import anamorph as an
from anamorph.measure.page import comparison_page

scene, _ = an.open_scene("flat-mirror")
comparison = an.compare(scene, ["pervertex", "environment"], size=(320, 240))
for result in comparison.methods:
    error, frame = result.errors.angular_mrad, result.timing
    print(f"{result.name:12} median {error.median:.4f} mrad, 95th percentile {error.p95:.4f}; {frame.median:.1f} ms")
Path("comparison.html").write_text(comparison_page(comparison), encoding="utf-8")
