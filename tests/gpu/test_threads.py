"""Threads and processes: the first use may come from many threads at once, and a fork has no device."""

from __future__ import annotations

import os
import subprocess
import sys
import threading

import pytest

from anamorph.base.output import whole_file

PATIENCE = 120.0
"""Seconds; what hangs does so for ever."""

# Eight threads that begin together, with nothing made before them: two scenes, and methods that share what they make.
FIRST_USE = """
import threading
from concurrent.futures import ThreadPoolExecutor
import anamorph as an
KINDS = [(scene, method) for scene in ("flat-mirror", "spheres") for method in ("pervertex", "raytrace", "environment")]
together = threading.Barrier(8)

def drawn(number):
    if number < 8:
        together.wait()
    scene, method = KINDS[number % len(KINDS)]
    return number, an.render(scene, method, size=(64, 48)).color

with ThreadPoolExecutor(8) as threads:
    found = list(threads.map(drawn, range(12)))
for number, color in found:
    scene, method = KINDS[number % len(KINDS)]
    assert (an.render(scene, method, size=(64, 48)).color == color).all(), (scene, method)
print("same")
"""

FORKED = """
import multiprocessing, sys
import anamorph as an

def drawn(_):
    try:
        return float(an.render("flat-mirror", size=(32, 24)).color.mean())
    except an.AnamorphError as error:
        return str(error)

if __name__ == "__main__":
    how, before = sys.argv[1:]
    own = drawn(0) if before == "before" else None
    with multiprocessing.get_context(how).Pool(2) as pool:
        others = pool.map_async(drawn, range(2)).get(100.0)
    print(*(other if isinstance(other, str) else other == (own or drawn(0)) for other in others), sep="\\n")
"""


def ended(program: str, *arguments: str, tmp_path) -> str:
    """What a program says on its standard output; it must end well."""
    (tmp_path / "program.py").write_text(program)
    command = [sys.executable, str(tmp_path / "program.py"), *arguments]
    found = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (found.returncode, found.stderr) == (0, "")
    return found.stdout


def test_the_first_pictures_may_come_from_many_threads_at_once(tmp_path):
    assert ended(FIRST_USE, tmp_path=tmp_path) == "same\n"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.parametrize(("how", "before"), [("fork", "after"), ("spawn", "before")])
def test_processes_with_a_device_of_their_own_draw(how, before, tmp_path):
    assert ended(FORKED, how, before, tmp_path=tmp_path) == "True\nTrue\n"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_process_that_was_forked_from_one_that_has_drawn_says_what_to_do(tmp_path):
    said = ended(FORKED, "fork", "before", tmp_path=tmp_path).splitlines()
    assert len(said) == 2 and all("multiprocessing.get_context('spawn')" in line for line in said)


def test_threads_that_write_one_file_do_not_share_the_part_that_is_not_finished(tmp_path):
    path, together = tmp_path / "a.bin", threading.Barrier(2)

    def write(letter: bytes) -> None:
        with whole_file(path) as file:
            for _ in range(100):
                file.write(letter * 1000)
            together.wait(10.0)

    threads = [threading.Thread(target=write, args=(letter,)) for letter in (b"a", b"b")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert path.read_bytes() in (b"a" * 100_000, b"b" * 100_000)
    assert os.listdir(tmp_path) == ["a.bin"]
