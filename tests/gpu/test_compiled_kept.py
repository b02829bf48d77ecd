"""What sessions leave in the driver, where no counting of Python's objects finds it: no shader compiled for one alone.

Counted is the machine code in the process's memory, which depends on nothing else that the machine does.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from anamorph.methods import METHODS

MAPS = Path("/proc/self/maps")
"""What a process has in its memory, line by line: addresses, rights, offset, device, file number and file."""

OPENING = """
import sys
from pathlib import Path
from anamorph.frame import View
from anamorph.gallery import make
from anamorph.methods import Specification
from anamorph.viewer.controls import edited

def code():
    parts = [line.split() for line in Path("/proc/self/maps").read_text().splitlines()]
    ends = [part[0].split("-") for part in parts if "x" in part[1] and part[4] == "0"]
    return sum(int(end, 16) - int(start, 16) for start, end in ends)

scene, method = make("car-mirror"), sys.argv[1]
for number in range(12):
    turned = edited(scene, {"mirror/tilt": 0.1 * number})
    session = Specification.parse(method).open(View(turned, turned.camera, (100, 80)))
    session.draw(turned.camera)
    session.wait()
    print(code())
"""


@pytest.mark.skipif(not MAPS.exists(), reason="the system does not tell what a process has in its memory")
@pytest.mark.parametrize("method", METHODS)
def test_sessions_opened_one_after_the_other_leave_no_compiled_shader(method):
    run = subprocess.run([sys.executable, "-c", OPENING, method], capture_output=True, text=True, check=True)
    kept = [int(line) for line in run.stdout.split()]
    assert kept[0] > 0 and kept[-1] == kept[3]
