"""Thousands of files broken at random: how many are opened or refused, and whether any ends, hangs or takes memory.

Run it with `./run bench broken-files`. It prints a line for each kind of file, each fault that is not one line, and the
slowest file and the most memory of all.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from broken_files import broken_files

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import AnamorphNote
from anamorph.files.opening import open_scene


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=6000, help="broken files")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    opened, refused, faults, slowest = Counter[str](), Counter[str](), 0, (0.0, "")
    warnings.simplefilter("error")
    warnings.simplefilter("ignore", AnamorphNote)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for what, path in broken_files(chosen.count, chosen.seed, folder):
            kind, start = what.split(": ")[1].split(",")[0], time.monotonic()
            try:
                open_scene(path)
                opened[kind] += 1
            except AnamorphError as error:
                refused[kind] += 1
                if not str(error).isprintable() or folder.name not in str(error):
                    faults += 1
                    print(f"{what}: says {str(error)[:200]}", flush=True)
            except Exception as error:
                faults += 1
                print(f"{what}: {type(error).__name__}: {str(error)[:200]}", flush=True)
            slowest = max(slowest, (time.monotonic() - start, what))
    for kind in sorted(opened | refused):
        print(f"{kind:14} opened {opened[kind]:5}, refused {refused[kind]:5}")
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    print(f"faults {faults}; slowest {slowest[0]:.2f} s ({slowest[1]}); most memory {memory:.0f} MiB")


if __name__ == "__main__":
    main()
