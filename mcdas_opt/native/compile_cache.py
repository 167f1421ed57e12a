"""C texts to a shared library, compiled once with the machine's compiler and kept in the user's cache folder.

A library is found by a hash of its texts, flags and processor, and its file name carries a digest of its content: a file that was
cut off or changed is thrown away and built again. It appears under its name whole or not at all, so processes may build at once.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import logging
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

SWITCH = "MCDAS_OPT_COMPILE"  # environment variable: 0 forbids the compiler, "portable" all but the last of the builds
PORTABLE = "portable"
_SUFFIX = ".dll" if sys.platform == "win32" else ".so"
_TIMEOUT_S = 300.0


class NoLibraryError(Exception):
    """There is no compiled library; says why."""


@cache
def say_once(line: str) -> None:
    """The default announcement of a build, a warning in the log; the same line is said once a process, however many libraries follow."""
    logging.getLogger(__name__).warning("%s", line)


def cache_folder() -> Path:
    """$XDG_CACHE_HOME/mcdas-opt, or ~/.cache/mcdas-opt. Raises `NoLibraryError` for a user without a home."""
    home = os.environ.get("XDG_CACHE_HOME", "")
    try:
        return (Path(home) if os.path.isabs(home) else Path.home() / ".cache") / "mcdas-opt"
    except RuntimeError:
        raise NoLibraryError("there is no home folder to keep it in; set XDG_CACHE_HOME") from None


def load(texts: Sequence[str], builds: Sequence[str], *, folder: Path, announce: Callable[[str], None]) -> ctypes.CDLL:
    """The library of C `texts`, each a unit of its own, from `folder`; or built into it, with the first of `builds` that works (compiler
    flags, best first).

    The last of the builds is the portable one: no instruction of this machine's, no fused operation, the C library's scalar mathematics,
    so that two machines with the same C library get the same bits. MCDAS_OPT_COMPILE=portable allows no other.

    Raises `NoLibraryError` when there is no compiler, none of the builds works, or the folder cannot be written.
    """
    if os.environ.get(SWITCH) == PORTABLE:
        builds = builds[-1:]
    key = hashlib.sha256("\0".join([*texts, *builds, _processor()]).encode()).hexdigest()[:24]
    try:
        for path in sorted(folder.glob(f"{key}-*{_SUFFIX}")):
            library = _kept(path)
            if library is not None:
                return library
        found = compiler()
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        announce("compiling the planner's kernels once (half a minute; `mcdas-opt warmup` does it ahead) ...")
        with tempfile.TemporaryDirectory(dir=folder, prefix="build-") as name:
            built = _built(texts, builds, found, Path(name))
            path = folder / f"{key}-{_digest(built)}{_SUFFIX}"
            os.replace(built, path)
        library = _kept(path)
    except OSError as error:
        raise NoLibraryError(f"the cache folder {folder} cannot be used: {error}") from error
    if library is None:
        raise NoLibraryError("the library that was built cannot be loaded")
    return library


def _kept(path: Path) -> ctypes.CDLL | None:
    """A library that is whole, our own and loads; else it is removed."""
    with contextlib.suppress(OSError):
        own = sys.platform == "win32" or path.stat().st_uid == os.getuid()
        if own and path.stem.endswith(_digest(path)):
            return ctypes.CDLL(str(path))
    with contextlib.suppress(OSError):
        path.unlink()
    return None


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:24]


def compiler() -> str:
    """The path of the C compiler: $CC, cc, gcc or clang. Raises `NoLibraryError` when there is none."""
    for name in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
        found = shutil.which(name) if name else None
        if found is not None:
            return found
    raise NoLibraryError("there is no C compiler")


def _built(texts: Sequence[str], builds: Sequence[str], compiler: str, folder: Path) -> Path:
    target, sources = folder / f"kernels{_SUFFIX}", [folder / f"{k}.c" for k in range(len(texts))]
    for source, text in zip(sources, texts, strict=True):
        source.write_text(text, "utf-8")
    said = ""
    for flags in builds:
        options = flags.split()
        libraries = [o for o in options if o.startswith("-l")]
        command = [compiler, "-std=c99", *(o for o in options if o not in libraries), "-fPIC", "-shared", "-o", str(target)]
        command += [*map(str, sources), *libraries]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False)
        except (OSError, subprocess.SubprocessError) as error:
            said = str(error)
            continue
        if done.returncode == 0 and target.is_file():
            try:
                ctypes.CDLL(str(target))
            except OSError as error:  # a symbol that no library has
                said = str(error)
                continue
            return target
        said = done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"exit {done.returncode}"
    raise NoLibraryError(f"{compiler} cannot build it: {said}")


def _processor() -> str:
    """What "native" means here."""
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
        return "\n".join(
            [platform.machine(), *dict.fromkeys(line for line in lines if line.startswith(("model name", "flags", "Features")))]
        )
    return f"{platform.machine()} {platform.processor()}"
