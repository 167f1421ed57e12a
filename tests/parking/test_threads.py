"""Two threads that park at once: each has a solver of its own, and the answer that one alone has."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from typing import Any

import pytest

from mcdas_opt.parking.program import nlp


def test_no_two_threads_share_a_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its statistics are read after its call."""
    monkeypatch.setattr(nlp, "nlp_of", lambda *_: ({}, {}))
    monkeypatch.setattr(nlp.ca, "nlpsol", lambda *_: object())
    together = Barrier(2)

    def built() -> tuple[Any, Any]:
        together.wait(60.0)
        structure = ("half-planes", (0, 1, 2), (), (), 7, False, 1e-5, nlp.get_ident())
        return nlp._solver(*structure), nlp._solver(*structure)

    with ThreadPoolExecutor(2) as pool:
        (one, again), (other, _) = (asked.result() for asked in [pool.submit(built), pool.submit(built)])
    nlp._solver.cache_clear()
    assert one is again
    assert one is not other
