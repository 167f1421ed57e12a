"""Every argument of every public function, given what it is not: our own error, or Python's for one that is missing."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import mcdas_opt as mo
from mcdas_opt.errors import McdasError

SITUATION = mo.Situation(host=mo.HostState(speed_mps=20.0), coverage=mo.Coverage())
PLAN = mo.plan(SITUATION, planner="closed-form-corrected")
SOUND: dict[str, dict[str, Any]] = {
    "plan": {"situation": SITUATION, "planner": "closed-form-corrected"},
    "verify": {"trajectory": PLAN.trajectory, "target": SITUATION},
    "escapes": {"situation": SITUATION},
    "simulate": {"scene": "benign-following", "planner": "closed-form-corrected"},
    "park": {"case": "parallel", "planner": "reeds-shepp"},
}
HOSTILE = (b"x", (1,), [None], {1: 2}, object(), 1j, np.array([1.0, 2.0]), np.array(["a"]), "a\0b", ["x"], int)
FUNCTIONS = dict(inspect.getmembers(mo, inspect.isfunction))


def test_they_are_all_there() -> None:
    assert {"plan", "step", "simulate", "verify", "park", "follow", "tune", "benchmark", "replay", "load_scene"} <= set(FUNCTIONS)


@contextlib.contextmanager
def missing() -> Iterator[None]:
    """Python's own error for an argument that has to be given is let through; no other."""
    try:
        yield
    except TypeError as error:
        if "required" not in str(error):
            raise


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_argument_of_a_wrong_kind_is_one_sentence(name: str) -> None:
    function: Callable[..., object] = FUNCTIONS[name]
    for given in inspect.signature(function).parameters:
        for value in HOSTILE if given != "progress" else HOSTILE[:-1]:  # what is called is the caller's
            with contextlib.suppress(McdasError), missing():
                function(**{**SOUND.get(name, {}), given: value})
