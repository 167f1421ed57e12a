"""How hypothesis runs here: the same examples every time, no clock. `HYPOTHESIS_PROFILE=explore` draws fresh ones."""

from __future__ import annotations

import os

from hypothesis import settings

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=500)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))
