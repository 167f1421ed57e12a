"""A sound file made unsound: bytes flipped, lines moved, numbers and words replaced by hostile ones."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

Generator = np.random.Generator
_LARGEST = 400_000  # bytes: a line that is repeated may be the whole file
_NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_]{3,}")
_NUMBERS = (
    b"nan", b"inf", b"-inf", b"1e308", b"-1e308", b"1e999", b"5e-324", b"0", b"-0.0", b"-1", b"1", b"99999999999999999999", b"9" * 400,
    b"9" * 6000, b"0x10", b"1_000", b"1e9", b"-1e9", b'"x"', b"true", b"[]", b"{}", b"null", b"",
)  # fmt: skip
_WORDS = (
    b"",
    b"x",
    b"__proto__",
    b"a.b.c",
    b'"',
    b"'",
    b"\x00",
    b"\xff\xfe",
    "é\u202e".encode(),
    b"../../etc/passwd",
    b"a" * 3000,
    b"[[",
    b"]]",
)


def _flip(data: bytes, r: Generator) -> bytes:
    changed = bytearray(data)
    for _ in range(int(r.integers(1, 6))):
        changed[int(r.integers(len(changed)))] ^= 1 << int(r.integers(8))
    return bytes(changed)


def _cut(data: bytes, r: Generator) -> bytes:
    return data[: int(r.integers(len(data)))]


def _drop(data: bytes, r: Generator) -> bytes:
    first, last = sorted(int(k) for k in r.integers(0, len(data), 2))
    return data[:first] + data[last:]


def _repeat(data: bytes, r: Generator) -> bytes:
    lines = data.splitlines(keepends=True)
    k = int(r.integers(len(lines)))
    return b"".join(lines[:k] + lines[k : k + 1] * int(r.integers(2, 200)) + lines[k:])


def _swap(data: bytes, r: Generator) -> bytes:
    lines = data.splitlines(keepends=True)
    i, j = (int(k) for k in r.integers(0, len(lines), 2))
    lines[i], lines[j] = lines[j], lines[i]
    return b"".join(lines)


def _insert(data: bytes, r: Generator) -> bytes:
    k, junk = (
        int(r.integers(len(data))),
        (b"[" * 200, b"{" * 200, b"\n\n[a]\n", b"a.b.c.d.e.f=1\n", b"\x00", bytes(r.integers(0, 256, 8).tolist())),
    )
    return data[:k] + junk[int(r.integers(len(junk)))] + data[k:]


def _replace(pattern: re.Pattern[bytes], others: tuple[bytes, ...]) -> Callable[[bytes, Generator], bytes]:
    def replaced(data: bytes, r: Generator) -> bytes:
        places = list(pattern.finditer(data))
        if not places:
            return _flip(data, r)
        one = places[int(r.integers(len(places)))]
        return data[: one.start()] + others[int(r.integers(len(others)))] + data[one.end() :]

    return replaced


_number, _word = _replace(_NUMBER, _NUMBERS), _replace(_WORD, _WORDS)
_MUTATORS = (_number, _number, _number, _word, _word, _flip, _cut, _drop, _repeat, _swap, _insert)


def mutated(data: bytes, r: Generator) -> bytes:
    """One to four mutations of it; never of a file that they left empty."""
    for _ in range(int(r.integers(1, 5))):
        if data:
            data = _MUTATORS[int(r.integers(len(_MUTATORS)))](data, r)[:_LARGEST]
    return data
