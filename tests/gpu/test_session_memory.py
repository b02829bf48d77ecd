"""What sessions leave behind: nothing, also not in the driver, where no counting of Python's objects finds it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

OPENING = """
import sys
from pathlib import Path
from anamorph.frame import View
from anamorph.methods import parse
from anamorph.gallery import make
from anamorph.viewer.controls import edited

scene, method = make("car-mirror"), sys.argv[1]
memory = []
for number in range(40):
    turned = edited(scene, {"mirror/tilt": 0.1 * number})
    chosen, options = parse(method)
    session = chosen.open(View(turned, turned.camera, (100, 80)), options)
    session.draw(turned.camera)
    session.wait()
    status = Path("/proc/self/status").read_text().splitlines()
    memory.append(next(int(line.split()[1]) / 1024.0 for line in status if line.startswith("VmRSS")))
print(memory[-1] - memory[9])
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the system does not tell a process's memory so")
@pytest.mark.parametrize("method", ["raytrace", "environment", "pervertex", "trilinear"])
def test_sessions_opened_one_after_the_other_leave_nothing(method):
    run = subprocess.run([sys.executable, "-c", OPENING, method], capture_output=True, text=True, check=True)
    assert float(run.stdout) < 12.0
