"""What a machine says that has no memory, descriptors, processes or disk left."""

from __future__ import annotations

import errno
import os
import sys
import threading

_ERRNOS = (errno.ENOMEM, errno.EMFILE, errno.ENFILE, errno.EAGAIN, errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_SAYINGS = (  # of whom has no number for it: the loader of libraries, threads
    "failed to map segment",
    "cannot allocate memory",
    "too many open files",
    "can't start new thread",
    "no space left",
)

_MOST_OF_A_LIBRARY, _OF_A_COMMAND = 64, 8  # threads
_LEAST_MIB = 1024  # `park` takes two thirds of it on two cores


def lacking_at_start() -> str:
    """Memory or threads, which libraries wait for for ever or end the process without; empty where there is enough of both."""
    return _memory_lacking() or _threads_lacking()


def _threads_lacking() -> str:
    """Starts as many threads at once as two libraries of linear algebra, NumPy's and SciPy's, and a command may."""
    go_on, needed = threading.Event(), 2 * min(os.cpu_count() or 1, _MOST_OF_A_LIBRARY) + _OF_A_COMMAND
    try:
        for _ in range(needed):
            threading.Thread(target=go_on.wait, daemon=True).start()
    except RuntimeError as error:
        return f"{error}, and {needed} are needed (ulimit -u)"
    finally:
        go_on.set()
    return ""


def _memory_lacking() -> str:
    if sys.platform == "win32":
        return ""
    import resource

    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    if allowed == resource.RLIM_INFINITY or allowed >= _LEAST_MIB << 20:
        return ""
    return f"{allowed >> 20} MiB of memory are allowed (ulimit -v), and {_LEAST_MIB} are needed"


def shortage(error: BaseException | None) -> str:
    """What was lacking, in the machine's own words, where this error or one that led to it says so; else empty."""
    seen: list[BaseException] = []
    while error is not None and error not in seen:
        seen.append(error)
        if isinstance(error, MemoryError):
            return "out of memory"
        if isinstance(error, OSError) and error.errno in _ERRNOS:
            return (error.strerror or str(error)).lower()
        said = str(error).lower()
        if isinstance(error, (ImportError, RuntimeError, OSError)) and any(saying in said for saying in _SAYINGS):
            return str(error)
        error = error.__cause__ or error.__context__
    return ""
