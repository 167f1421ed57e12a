"""The compiled form of a computation: C texts that ship with the package, built into one library on first use; or none."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping, Sequence
from importlib import resources
from typing import Any

from mcdas_opt.native.compile_cache import HEAD, SWITCH, NoLibraryError, cache_folder, load, to_stderr


def wanted() -> bool:
    """Whether compiled forms may be used: MCDAS_OPT_COMPILE=0 forbids them."""
    return os.environ.get(SWITCH, "1") != "0"


def c_text(package: str, name: str) -> str:
    """A C text that lies in `package`."""
    return resources.files(package).joinpath(name).read_text("utf-8")


def defined(numbers: Mapping[str, Any]) -> str:
    """Numbers, and tuples of them, as macros."""
    return "\n".join(f"#define {name} {_written(value)}" for name, value in numbers.items())


def _written(value: Any) -> str:
    return f"{{{', '.join(map(_written, value))}}}" if isinstance(value, tuple) else repr(value)


def library(texts: Sequence[str], builds: Sequence[str]) -> ctypes.CDLL | None:
    """The library of the common head and `texts`, from the user's cache or built into it; None where it cannot be had."""
    try:
        return load("\n".join([HEAD, *texts]), builds, folder=cache_folder(), announce=to_stderr)
    except NoLibraryError:
        return None
