"""Which form of the planner runs: compiled, or interpreted, which decides the same and is many times slower. It says so once."""

from __future__ import annotations

import warnings
from functools import cache

from mcdas_opt.native.library import SWITCH, NoLibraryError, load, wanted

COST = "ten times slower or more, with the same decisions"
HELPS = "with a C compiler (cc, gcc or clang) reinstall mcdas-opt, or run `python -m mcdas_opt.native.build` in a checkout"


class InterpretedFormWarning(UserWarning):
    """The compiled form was wanted and cannot be had."""


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


def interpreted_because() -> str:
    """Why the interpreted form runs; empty where the compiled one does."""
    if not wanted():
        return f"{SWITCH}=0 asks for it"
    try:
        load()
    except NoLibraryError as error:
        return str(error)
    return ""
