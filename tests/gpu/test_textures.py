"""Images on the way to the device: resized without a change of colour, and never too large for it."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.base.errors import AnamorphError
from anamorph.gpu import textures
from anamorph.gpu.buffers import grown_buffer, storage_buffer
from anamorph.gpu.device import get_device
from anamorph.scene.model import Texture


def test_a_transparent_texel_keeps_its_colour_when_it_is_resized(monkeypatch) -> None:
    pixels = np.full((3, 5, 4), (200, 100, 50, 0), np.uint8)
    uploaded: list[np.ndarray] = []
    monkeypatch.setattr(textures, "upload", uploaded.extend)
    textures.texture_array((Texture(pixels),))
    assert uploaded[1].shape == (8, 8, 4)
    assert (uploaded[1][..., :3] == (200, 100, 50)).all()


def test_a_sky_wider_than_the_device_allows_is_made_smaller(monkeypatch) -> None:
    uploaded: list[np.ndarray] = []
    monkeypatch.setattr(textures, "upload", uploaded.extend)
    monkeypatch.setattr(textures, "maximum_size", lambda: 16)
    textures.sky_texture(Texture(np.full((8, 40, 4), 255, np.uint8)))
    assert uploaded[0].shape == (8, 16, 4)


def test_more_images_or_vertices_than_the_device_takes_are_refused() -> None:
    limits = get_device().limits
    white = Texture(np.full((1, 1, 4), 255, np.uint8))
    with pytest.raises(AnamorphError, match="images"):
        textures.texture_array((white,) * limits["max-texture-array-layers"])
    vertices = np.broadcast_to(np.float32(0.0), limits["max-storage-buffer-binding-size"] // 4 + 1)
    with pytest.raises(AnamorphError, match="in one buffer"):
        storage_buffer(vertices)
    with pytest.raises(AnamorphError, match="in one buffer"):
        grown_buffer(None, vertices.nbytes)
