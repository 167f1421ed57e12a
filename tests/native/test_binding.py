"""The binding: what it hands over, what it refuses, and that its signatures are those of the C texts."""

from __future__ import annotations

import re
import sys
from ctypes import ArgumentError, c_double, c_longlong, c_void_p
from pathlib import Path

import numpy as np
import pytest

from mcdas_opt.native import build, library
from mcdas_opt.native.binding import defined, record
from mcdas_opt.native.build import TEXTS, UNITS, BuildError, text_of
from mcdas_opt.native.form import SWITCH, InterpretedFormWarning, warn_interpreted
from mcdas_opt.native.library import FUNCTIONS, NoLibraryError

PROTOTYPE = re.compile(r"^PUBLIC ([\w ]+?)\s*(mcdas_\w+)\(([^)]*)\)", re.MULTILINE)
RETURNED = {"void": "", "int": "i", "whole": "l", "double": "d"}
needs_library = pytest.mark.skipif(library.library() is None, reason="there is no native library")


def letters(parameter: str) -> str:
    """Those that a C parameter may have."""
    if "*" in parameter:
        return "ap" if parameter.startswith("const") else "wp"
    return RETURNED[parameter.split()[0]]


def test_signatures_are_those_of_the_texts() -> None:
    found = {
        function + unit.suffix: (parameters, kind) for unit in UNITS for kind, function, parameters in PROTOTYPE.findall(text_of(unit.text))
    }
    assert found.keys() == FUNCTIONS.keys()
    for function, (parameters, kind) in found.items():
        given, _, returned = FUNCTIONS[function].partition(">")
        asked = [] if parameters == "void" else [" ".join(parameter.split()) for parameter in parameters.split(",")]
        assert len(given) == len(asked), function
        assert all(letter in letters(parameter) for letter, parameter in zip(given, asked, strict=True)), function
        assert returned == RETURNED[kind], function


def test_every_text_belongs_to_the_library_and_is_whole() -> None:
    names = {unit.text for unit in UNITS}
    assert names == {path.name for path in TEXTS.glob("*.c")}
    included = {header for path in TEXTS.rglob("*.[ch]") for header in re.findall(r'#include "(.*)"', path.read_text("utf-8"))}
    assert included == {path.relative_to(TEXTS).as_posix() for path in TEXTS.rglob("*.h")}
    for text in names:
        assert '#include "' not in text_of(text)
        assert text_of(text).count("#define LESSER(") <= 1


@needs_library
def test_arrays_are_handed_over_as_they_lie() -> None:
    times, numbers, grown = np.arange(3.0), np.array([[2.0, 1.0, 3.0, 2.0, 9.0, 9.0, 1.0, 4.0, 0.0, 0.0, 0.0, 0.0]]), np.zeros((1, 2, 3))
    compiled = library.library()
    assert compiled is not None
    compiled.mcdas_grown(1, 3, times, numbers, grown)
    assert grown.tolist() == [[[5.0] * 3, [7.0] * 3]]
    for array in (times, numbers):
        array.setflags(write=False)
    again = np.zeros_like(grown)
    compiled.mcdas_grown(1, 3, times, numbers, again)
    assert np.array_equal(again, grown)
    for wrong in (
        (np.arange(6.0)[::2], numbers, again),
        (times, np.asfortranarray(np.repeat(numbers, 2, 0)), again),
        (times, numbers, times),
    ):
        with pytest.raises(ArgumentError):
            compiled.mcdas_grown(1, 3, *wrong)
    with pytest.raises(ArgumentError):
        compiled.mcdas_grown(1.5, 3, times, numbers, again)


@needs_library
def test_nothing_to_read_is_a_null_pointer() -> None:
    compiled = library.library()
    assert compiled is not None
    table, rules, work = np.full((9, 2), np.nan), np.zeros(60), np.zeros((4, 11))
    nobody, no_road, doubtful = np.zeros((0, 10)), (0, 0, 0, 0), np.zeros(0, dtype=np.int64)
    assert compiled.mcdas_conservative_accept(table, 2, None, rules, nobody, 0, *no_road, None, 0, work, doubtful) == -1


def test_the_library_is_there_once_and_not_where_it_is_forbidden(monkeypatch: pytest.MonkeyPatch) -> None:
    before = library.library()
    assert library.library() is before
    monkeypatch.setenv(SWITCH, "0")
    assert library.library() is None
    monkeypatch.delenv(SWITCH)
    assert library.library() is before


def test_while_it_is_held_the_form_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    before = library.library()
    with library.Held(), library.Held():
        monkeypatch.setenv(SWITCH, "0")
        assert library.library() is before
    assert library.library() is None


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Where the library is looked for, and is not."""
    monkeypatch.delenv(SWITCH, raising=False)
    monkeypatch.setattr(library, "_loaded", {})
    place = tmp_path / build.LIBRARY.name
    monkeypatch.setattr(library, "LIBRARY", place)
    warn_interpreted.cache_clear()
    return place


def test_what_was_not_built_is_said_once(elsewhere: Path) -> None:
    with pytest.warns(InterpretedFormWarning, match="the native library was not built"):
        assert library.library() is None
    assert library.library() is None  # said once


@pytest.mark.parametrize("content", [b"", b"no library at all"])
def test_a_broken_library_is_named(elsewhere: Path, content: bytes) -> None:
    elsewhere.write_bytes(content)
    with pytest.raises(NoLibraryError, match="cannot be used"):
        library.load()


@needs_library
@pytest.mark.parametrize("share", [0.02, 0.5, 0.999])
def test_a_library_that_was_cut_off_is_named(elsewhere: Path, share: float) -> None:
    whole = build.LIBRARY.read_bytes()
    elsewhere.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(NoLibraryError, match="cannot be used"):
        library.load()


@needs_library
def test_a_library_of_other_texts_is_not_used(elsewhere: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    elsewhere.write_bytes(build.LIBRARY.read_bytes())
    assert library.load().mcdas_digest() == build.digest()
    monkeypatch.setattr(library, "digest", lambda: build.digest() + 1)
    with pytest.raises(NoLibraryError, match="is of another version"):
        library.load()


@pytest.mark.parametrize(("compiler", "said"), [(None, "no C compiler"), ("echo broken >&2; exit 1", "broken"), ("exit 0", "cannot link")])
def test_without_a_working_compiler_there_is_a_reason_and_no_library(
    compiler: str | None, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CC", raising=False)
    if compiler is not None:
        fake = tmp_path / "fakecc"
        fake.write_text(f"#!/bin/sh\n{compiler}\n")
        fake.chmod(0o755)
        monkeypatch.setenv("CC", str(fake))
    else:
        monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BuildError, match=said):
        build.build(tmp_path / "built")
    assert not (tmp_path / "built").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="operating system: a shell as POSIX has it")
def test_a_compiler_that_hangs_is_given_up_before_every_unit_was_tried(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake = tmp_path / "hanging"
    fake.write_text(f"#!/bin/sh\necho asked >> {tmp_path}/asked\nexec sleep 600\n")
    fake.chmod(0o755)
    monkeypatch.setenv("CC", str(fake))
    monkeypatch.setattr(build, "_TIMEOUT_S", 1.0)
    with pytest.raises(BuildError, match="timed out"):
        build.build(tmp_path / "built")
    assert len((tmp_path / "asked").read_text("utf-8").split()) < len(build.UNITS)


def test_numbers_become_macros() -> None:
    assert defined({"A": 2, "B": 0.5, "C": (1, (2.0, 3))}) == "#define A 2\n#define B 0.5\n#define C {1, {2.0, 3}}\n"


def test_a_record_is_the_struct_of_the_text() -> None:
    ground, case = record("time_to_react.c", "Ground"), record("time_to_react.c", "Case")
    assert ground._fields_[0] == ("bare", case)
    assert [name for name, *_ in ground._fields_[1:]] == ["moments_s", "lattice_s", "coarse", "exact", "near_d", "latest_s"]
    assert {c_void_p, c_longlong, c_double} == {kind for _, kind in case._fields_}
    with pytest.raises(LookupError, match="no struct Nothing"):
        record("time_to_react.c", "Nothing")
