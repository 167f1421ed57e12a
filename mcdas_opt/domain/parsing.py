"""TOML and JSON from outside: their size, nesting, keys and numbers are limited before they are parsed.

`tomllib` takes time and memory in the square of a dotted key's parts, both parsers recurse into what is nested, and Python refuses to read
integers of some thousand digits: each with an error, or a cost, of its own.
"""

from __future__ import annotations

import json
import re
import tomllib
from typing import Any, NoReturn

import numpy as np

from mcdas_opt.domain.rules import is_text
from mcdas_opt.errors import InputError

LARGEST_TOML, LARGEST_JSON = 1_000_000, 50_000_000  # characters
DEEPEST = 64  # brackets within brackets
KEY_PARTS = 16  # of a dotted key or a table's name
DIGITS = 100  # in a row, of a number
_INTEGER_BITS = 64  # with the sign, as TOML has it

# TOML's four kinds of string, closed as `tomllib` closes them (a long one may end in two quotes of its own); nothing is tried twice
_STRINGS = (
    r'"""(?:[^"\\]|\\.|"(?!""))*+"{3,5}',
    r"'''(?:[^']|'(?!''))*+'{3,5}",
    r'"(?:[^"\\\n]|\\.)*+"',
    r"'[^'\n]*+'",
)
_OTHERS = (r"(?P<comment>#[^\n]*)", r"(?P<word>[A-Za-z0-9_+-]+)", r"(?P<mark>[][{}.])", r"(?P<end>[=,\n])", r"(?P<unclosed>[\"'])")
_PIECES = re.compile("|".join((*_STRINGS, *_OTHERS)), re.S)
_JSON_STRING = re.compile(r'"(?:[^"\\]|\\.)*+(?:"|\\?\Z)', re.S)
_DIGITS = re.compile(rf"[0-9_]{{{DIGITS + 1}}}")
_OPENING, _CLOSING = np.frombuffer(b"[{", dtype=np.uint8), np.frombuffer(b"]}", dtype=np.uint8)


def parsed_toml(text: str, file: object) -> dict[str, Any]:
    """The document. Raises `InputError` that names the file and what is wrong or beyond a limit."""
    _limited(text, LARGEST_TOML, file)
    depth = dots = 0
    for piece in _PIECES.finditer(text):
        kind = piece.lastgroup
        if kind == "mark":
            mark = piece.group()
            depth += (mark in "[{") - (mark in "]}")
            dots = dots + 1 if mark == "." else 0
            if depth > DEEPEST:
                _too_deep(file)
            if dots >= KEY_PARTS:
                line = text.count("\n", 0, piece.start()) + 1
                raise InputError(file, f"line {line}", None, f"a dotted key must have at most {KEY_PARTS} parts")
        elif kind == "end":
            dots = 0
        elif kind == "unclosed":
            break  # what follows is no TOML, and is not parsed
        elif kind == "word" and _DIGITS.search(piece.group()):
            _too_long(file)
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(file, "", None, f"is not TOML: {error}") from None
    _fitting(document, file)
    return document


def parsed_json(text: str, file: object) -> Any:
    """The document. Raises `InputError` that names the file and what is wrong or beyond a limit."""
    _limited(text, LARGEST_JSON, file)
    if _depth(text) > DEEPEST and _depth(_JSON_STRING.sub("", text)) > DEEPEST:  # strings are told apart only where there are many brackets
        _too_deep(file)
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(file, f"line {error.lineno}", None, f"is not JSON: {error.msg}") from None
    except ValueError:  # Python's own limit of an integer's digits, which is beyond ours
        _too_long(file)
    _fitting(document, file)
    return document


def _limited(text: str, largest: int, file: object) -> None:
    if len(text) > largest:
        raise InputError(file, "", None, f"must be at most {largest} characters long, and has {len(text)}")


def _depth(text: str) -> int:
    """How deep brackets lie in one another, whether they match or not."""
    letters = np.frombuffer(text.encode("utf-8", "surrogatepass"), dtype=np.uint8)
    steps = np.isin(letters, _OPENING).astype(np.int8) - np.isin(letters, _CLOSING).astype(np.int8)
    return int(np.cumsum(steps[steps != 0], dtype=np.int64).max(initial=0))


def _fitting(document: object, file: object) -> None:
    """Raises `InputError` for an integer beyond 64 bits in a document, whose depth is bounded."""
    left = [document]
    while left:
        part = left.pop()
        if isinstance(part, dict):
            left.extend((*part, *part.values()))
        elif isinstance(part, list):
            left.extend(part)
        elif isinstance(part, str) and not is_text(part):
            raise InputError(file, "", part, "is no text: it holds half of a surrogate pair")
        elif isinstance(part, int) and _is_too_large(part):
            rule = f"is too large: an integer of {part.bit_length()} bits, of at most {_INTEGER_BITS} with the sign"
            raise InputError(file, _key_of_too_large(document).lstrip("."), None, rule)


def _is_too_large(part: object) -> bool:
    return isinstance(part, int) and part.bit_length() >= _INTEGER_BITS


def _key_of_too_large(part: object) -> str:
    """Where in a document there is one: `.key[3].other`; empty where there is none."""
    if isinstance(part, dict):
        inner = ((f".{key}", value) for key, value in part.items())
    elif isinstance(part, list):
        inner = ((f"[{k}]", value) for k, value in enumerate(part))
    else:
        return ""
    for name, value in inner:
        if _is_too_large(value):
            return name
        below = _key_of_too_large(value)
        if below:
            return name + below
    return ""


def _too_deep(file: object) -> NoReturn:
    raise InputError(file, "", None, f"nests lists and tables in one another more than {DEEPEST} deep")


def _too_long(file: object) -> NoReturn:
    raise InputError(file, "", None, f"holds a number of more than {DIGITS} digits")
