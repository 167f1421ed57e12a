"""The native library from its C texts (`c`), by the platform's C compiler: while the package is built (`build_hook`), or in a checkout by
`python -m mcdas_opt.native.build`.

Needs the standard library alone: while the package is built, nothing else of it can be imported. Each unit is compiled for one or more
levels of the processor; the functions of a level end in its name, and `library` takes the best that runs. Those without an ending run
everywhere: no instruction of one machine's, no fused operation, scalar mathematics, so that two machines with the same C library get the
same bits. Flags change no result of the others but where `VECTOR_MATH` takes sines and exponentials from glibc's libmvec.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

TEXTS = Path(__file__).parent / "c"
LIBRARY = Path(__file__).parent / {"win32": "mcdas.dll", "darwin": "libmcdas.dylib"}.get(sys.platform, "libmcdas.so")
PORTABLE = ""
_TIMEOUT_S = 300.0
_PUBLIC = re.compile(r"^PUBLIC [\w ]+?\s*\b(mcdas_\w+)\(", re.MULTILINE)


class BuildError(Exception):
    """The library cannot be built; says why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """One C text, the flags that it is compiled with at each level (those that a compiler knows, best first), and how its functions'
    names end besides."""

    text: str
    builds: Mapping[str, Sequence[str]]
    suffix: str = ""
    defines: Mapping[str, str] = field(default_factory=dict)


_TRAPS = "-fno-math-errno -fno-trapping-math"
_EXACT = f"{_TRAPS} -ffp-contract=off"  # no result changed
_WIDE = {"_v3": "-march=x86-64-v3", "_v4": "-march=x86-64-v4 -mprefer-vector-width=512"}
_ROLLED = "--param max-completely-peeled-insns=60"  # gcc else unrolls loops over lanes before it sees that they are vectors: a seventh more


def _same_operations(text: str) -> Unit:
    """The operations of the arrays, one by one."""
    return Unit(text=text, builds={PORTABLE: ("-O2 -ffp-contract=off -fno-math-errno",)})


def _vectors(text: str, flags: str, portable: str, *names: str, suffix: str = "", defines: Mapping[str, str] | None = None) -> Unit:
    """At each level with these functions of whole vectors: other last bits than the C library's."""
    whole = " ".join([*(f"-fno-builtin-{name}" for name in names), "-DVECTOR_MATH"])
    levels = {
        level: tuple(f"{flags} {march} {more}" for more in (f"{whole} {_ROLLED}", whole, _ROLLED, "")) for level, march in _WIDE.items()
    }
    return Unit(text=text, builds={**levels, PORTABLE: (portable,)}, suffix=suffix, defines=defines or {})


UNITS = (
    Unit(text="levels.c", builds={PORTABLE: ("-O2",)}),
    *map(_same_operations, ("rectangle_separations.c", "polygon_separations.c", "grown_bodies.c", "drive.c", "target_filter.c", "plane.c")),
    *map(_same_operations, ("reach.c", "headway.c", "cost_rate.c", "speed_profile.c", "safe_end.c")),
    _vectors("conservative_accept.c", f"-O3 {_TRAPS}", "-O2 -fno-math-errno", "sin", "cos", "tan"),
    _vectors("sharpest_path.c", f"-O3 {_EXACT}", "-O2", "exp", "sin"),
    _vectors("family.c", f"-O3 {_EXACT}", "-O2", "exp", "sin"),
    _vectors("family.c", f"-O3 {_EXACT}", "-O2", "exp", "sin", suffix="_any_length", defines={"ROW": "f->row"}),
    _vectors("interior_point.c", f"-O3 {_TRAPS}", "-O2", "sin", "cos"),
    Unit(
        text="time_to_react.c",
        builds={
            "_v3": tuple(f"-O3 -march=x86-64-v3 {_EXACT}{rolled}" for rolled in (f" {_ROLLED}", "")),
            PORTABLE: (f"-O2 {_EXACT}", "-O2"),
        },
    ),
)


def flags_of(text: str, level: str) -> str:
    """What a unit is compiled with at a level, and linked with besides."""
    unit = next(unit for unit in UNITS if unit.text == text)
    flags = unit.builds[level][0]
    return f"{flags} -lmvec -lm" if "-DVECTOR_MATH" in flags else f"{flags} -lm"


@cache
def digest() -> int:
    """Of every text and flag: a library that says another one is of other texts. 63 bits."""
    parts = [repr(UNITS)]
    for path in sorted(TEXTS.rglob("*.[ch]")):
        parts += [path.relative_to(TEXTS).as_posix(), path.read_text("utf-8")]
    return int.from_bytes(hashlib.sha256("\0".join(parts).encode()).digest()[:8], "big") >> 1


def compiler() -> str:
    """The command of the C compiler: $CC, cc, gcc or clang. Raises `BuildError` when there is none."""
    for name in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
        words = shlex.split(name)
        if words and shutil.which(words[0]) is not None:
            return name
    raise BuildError("there is no C compiler")


def build(target: Path = LIBRARY) -> None:
    """Builds the library; it appears whole or not at all. Raises `BuildError`."""
    command = [*shlex.split(compiler()), "-std=c99", "-fPIC", "-fvisibility=hidden", *shlex.split(os.environ.get("ARCHFLAGS", ""))]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tasks = [(unit, level) for unit in UNITS for level in unit.builds if level == PORTABLE or _is_x86_64()]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(pool.map(lambda task: _compiled(command, task[0], task[1], folder), tasks))
        built, made = folder / target.name, [str(path) for path in objects if path is not None]
        vectors = "-lmvec" if any(path is not None and path.stem.endswith("-vector") for path in objects) else ""
        said = _run([*command, "-shared", "-s", "-o", str(built), *made, *vectors.split(), "-lm"])
        if said is not None or not built.is_file():
            raise BuildError(f"the C compiler cannot link it: {said}")
        staged = target.with_name(f".{target.name}.{os.getpid()}")
        shutil.copyfile(built, staged)
        os.replace(staged, target)


def _compiled(command: Sequence[str], unit: Unit, level: str, folder: Path) -> Path | None:
    """The unit's object at a level, with the first of its flags that the compiler knows; None for a level that it does not know."""
    ending = unit.suffix + level
    renamed = [f"-D{name}={name}{ending}" for name in _PUBLIC.findall(text_of(unit.text))] if ending else []
    defined = [f"-D{name}={value}" for name, value in unit.defines.items()]
    if unit.text == "levels.c":
        defined.append(f"-DDIGEST={digest()}LL")
    said: str | None = ""
    for flags in unit.builds[level]:
        kind = "-vector" if "-DVECTOR_MATH" in flags else ""
        if kind and not _has_vector_mathematics():
            continue
        made = folder / f"{Path(unit.text).stem}{ending}{kind}.o"
        said = _run([*command, *flags.split(), *renamed, *defined, "-I", str(TEXTS), "-c", str(TEXTS / unit.text), "-o", str(made)])
        if said is None and kind:  # an older libmvec lacks some of the functions
            said = _run([*command, "-shared", "-Wl,-z,defs", str(made), "-lmvec", "-lm", "-o", str(made.with_suffix(".so"))])
        if said is None:
            return made
    if level == PORTABLE:
        raise BuildError(f"the C compiler cannot build {unit.text}: {said}")
    return None


def _run(command: Sequence[str]) -> str | None:
    """None where it worked, else what was said last."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False)
    except (OSError, subprocess.SubprocessError) as error:
        return str(error)
    if done.returncode == 0:
        return None
    return done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"exit {done.returncode}"


def _is_x86_64() -> bool:
    asked = os.environ.get("ARCHFLAGS", "") if sys.platform == "darwin" else ""
    return "arm64" not in asked and (platform.machine() in ("x86_64", "AMD64") or "x86_64" in asked)


def _has_vector_mathematics() -> bool:
    """Of glibc."""
    return sys.platform == "linux" and platform.libc_ver()[0] == "glibc"


@cache
def text_of(name: str) -> str:
    """A C text of the package, what it includes of the package's own in its place."""
    return "\n".join(_included(name, set())) + "\n"


def _included(name: str, known: set[str]) -> Iterator[str]:
    known.add(name)
    for line in TEXTS.joinpath(*name.split("/")).read_text("utf-8").splitlines():
        if not line.startswith('#include "'):
            yield line
        elif (header := line.split('"')[1]) not in known:
            yield from _included(header, known)


if __name__ == "__main__":
    try:
        build()
    except BuildError as error:
        sys.exit(f"{error}; without the library the interpreted form runs")
    sys.stdout.write(f"{LIBRARY}\n")
