"""What holds for all tests: none fails because the machine has something else to do, or because the dice fell so."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("repeated", deadline=None, derandomize=True)
settings.register_profile("exploring", deadline=None, print_blob=True)
# The same cases in every run, so that a change is judged by what it changed; the other profile looks for new ones.
settings.load_profile("repeated")
