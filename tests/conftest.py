"""How hypothesis runs here: the same examples every time, no clock. `HYPOTHESIS_PROFILE=explore` draws fresh ones.

A shell that starts the tests in the background may have them ignore Ctrl-C, and so every process that they start: not here.
"""

from __future__ import annotations

import os
import signal
import threading

from hypothesis import settings

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=500)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN and threading.current_thread() is threading.main_thread():
    signal.signal(signal.SIGINT, signal.default_int_handler)
