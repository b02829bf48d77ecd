"""What is being saved: work in steps, done beside the images, a part of a frame after the other."""

from __future__ import annotations

from time import perf_counter

from anamorph.viewer.facts import Progress
from anamorph.viewer.failures import failure_text
from anamorph.viewer.saving import Saving

SHARE = 0.025
"""Seconds of a frame that go to it."""


class Job:
    """Something that is being saved.

    Parameters
    ----------
    saving : Saving

    Attributes
    ----------
    progress : Progress or None
        How far it is; None before the first step.
    """

    def __init__(self, saving: Saving) -> None:
        self._saving = saving
        self.progress: Progress | None = None

    def advance(self) -> str | None:
        """Take steps for a part of a frame; at the end of the work, or where it fails, returns what to say of it."""
        began = perf_counter()
        try:
            while perf_counter() - began < SHARE:
                self.progress = next(self._saving)
        except StopIteration as end:
            return str(end.value)
        except Exception as error:
            return failure_text(error, "saving")
        return None

    def stop(self) -> None:
        """Leave it; what is unfinished leaves nothing behind."""
        self._saving.close()
