"""Makes the image of real-cameras.md: `.venv/bin/python docs/make_real_cameras.py`."""

from __future__ import annotations

from pathlib import Path

from figures import real_lenses
from figures.panels import save

IMAGES = Path(__file__).resolve().parent / "images" / "real-cameras"


def main() -> None:
    """Make the image."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    save(IMAGES / "models.webp", real_lenses.models())


if __name__ == "__main__":
    main()
