"""Which form of the planner runs: compiled, or interpreted, which decides the same and is many times slower. It says so once."""

from __future__ import annotations

import warnings
from functools import cache
from os import environ

SWITCH = "MCDAS_OPT_COMPILE"  # environment variable: 0 forbids the compiled forms, "portable" all that is of one processor
COST = "ten times slower or more, with the same decisions"
HELPS = "with a C compiler (cc, gcc or clang) reinstall mcdas-opt, or run `python -m mcdas_opt.native.build` in a checkout"


class InterpretedFormWarning(UserWarning):
    """The compiled form was wanted and cannot be had."""


def wanted() -> bool:
    """Whether compiled forms may be used: MCDAS_OPT_COMPILE=0 forbids them."""
    return environ.get(SWITCH) != "0"


@cache
def warn_interpreted(reason: str) -> None:
    """Once a process and reason; nothing where the compiled form is switched off, for that somebody chose."""
    if wanted():
        warnings.warn(f"{interpreted(reason)}; `mcdas-opt doctor` says more", InterpretedFormWarning, stacklevel=2)


def interpreted(reason: str) -> str:
    """In words, with what would help."""
    if not wanted():
        return f"the interpreted form runs, {COST}: {reason}"
    return f"the interpreted form runs, {COST}: {reason}; {HELPS}"
