"""Path ends in the visibility buffer: what the processor packs is what the device packs and reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from compute import computed

from anamorph.methods.tracing.packing import BLANK, PLACES, packed

SHADER = Path(__file__).with_name("pack_ends.wgsl")


def on_the_device(ends):
    """Texels (2, N, 4) uint32 and what is read from them (N, 12) float32, of ends (N, 12) float32."""
    results = computed(SHADER, {}, len(ends), np.dtype(("u4", 20)), {0: [ends]}).reshape(-1, 20)
    texels, again = results[:, :8], np.ascontiguousarray(results[:, 8:])
    return texels.reshape(-1, 2, 4).swapaxes(0, 1), again.view(np.float32)


def throughputs(random):
    """Of all sizes, with those at which an exponent changes, and beyond what can be held."""
    colors = 2.0 ** random.uniform(-20.0, 18.0, (4000, 1)) * random.uniform(0.0, 1.0, (4000, 3))
    steps = np.repeat(2.0 ** np.arange(-18.0, 18.0)[:, None], 3, axis=1)
    edges = [steps, np.nextafter(steps.astype(np.float32), np.float32(0.0)), steps * [1.0, 0.5, 2047.5 / 2048.0]]
    halves = (np.arange(2048.0)[:, None] + [0.0, 0.5, 0.25]) / 2048.0
    return np.concatenate([colors, *edges, halves, np.zeros((1, 3)), -np.ones((1, 3))]).astype(np.float32)


@pytest.fixture(scope="module")
def ends():
    """Records of paths, (N, 16) float32, and the same ends as the device holds them, (N, 12)."""
    random = np.random.default_rng(5)
    throughput = throughputs(random)
    count = len(throughput)
    records = np.zeros((count, 16), np.float32)
    words = records.view(np.uint32)
    directions = random.normal(size=(count, 3))
    directions[:26] = [each for each in np.ndindex(3, 3, 3) if each != (1, 1, 1)]
    directions[:26] -= 1.0
    records[:, :3] = random.normal(size=(count, 3)) * 10.0 ** random.uniform(-4.0, 4.0, (count, 1))
    records[:, 4:7] = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    words[:, 3] = random.integers(0, 2**31, count)
    words[::7, 3] = BLANK
    words[:, 7] = random.integers(0, 2**32, count)
    records[:, 8:11] = throughput
    device = records[:, :12].copy()
    device.view(np.uint32)[:, 3] += 1
    return records, device


def test_the_processor_packs_as_the_device_does(ends):
    records, given = ends
    texels, (expected, _) = packed(records), on_the_device(given)
    assert (texels[0] == expected[0]).all(), "origin and triangle, bit for bit"
    assert (texels[1, :, 2:] == expected[1, :, 2:]).all(), "flags and throughput, bit for bit"
    # The processor divides in float64, and no device divides by the same rounding.
    places, others = ((each[1, :, :2] & PLACES).astype(int) for each in (texels, expected))
    assert np.abs(places - others).max() <= 2
    assert (texels[1, :, :2] >> 24 == expected[1, :, :2] >> 24).all(), "red, bit for bit"


def test_what_the_device_reads_is_what_was_packed(ends):
    records, given = ends
    _, again = on_the_device(given)
    assert (again.view(np.uint32)[:, [0, 1, 2, 3, 7]] == given.view(np.uint32)[:, [0, 1, 2, 3, 7]]).all()
    assert np.abs(again[:, 4:7] - records[:, 4:7]).max() < 1e-6
    held = np.clip(records[:, 8:11], 0.0, 65504.0)
    assert (np.abs(again[:, 8:11] - held) <= np.maximum(held / 2048.0, 2.0**-25)).all(), "half floats"
