"""The binding: what it hands over, what it refuses, and that its signatures are those of the C texts."""

from __future__ import annotations

import re
from ctypes import ArgumentError, c_double, c_longlong, c_void_p
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from mcdas_opt.native import kernels
from mcdas_opt.native.binding import Library, defined, record, text_of
from mcdas_opt.native.compile_cache import SWITCH, NoLibraryError
from mcdas_opt.native.form import InterpretedFormWarning, warn_interpreted
from mcdas_opt.native.kernels import PLAIN

LIBRARIES = {name: library for name, library in vars(kernels).items() if isinstance(library, Library)}
FOLDER = Path(str(resources.files("mcdas_opt.native"))) / "c"
PROTOTYPE = re.compile(r"^PUBLIC ([\w ]+?)\s*(mcdas_\w+)\(([^)]*)\)", re.MULTILINE)
RETURNED = {"void": "", "int": "i", "whole": "l", "double": "d"}
needs_compiler = pytest.mark.skipif(PLAIN.loaded() is None, reason="there is no compiler")


def letters(parameter: str) -> str:
    """Those that a C parameter may have."""
    if "*" in parameter:
        return "ap" if parameter.startswith("const") else "wp"
    return RETURNED[parameter.split()[0]]


@pytest.mark.parametrize("name", LIBRARIES)
def test_signatures_are_those_of_the_text(name: str) -> None:
    library = LIBRARIES[name]
    found = {function: (parameters, kind) for text in library.texts for kind, function, parameters in PROTOTYPE.findall(text_of(text))}
    assert found.keys() == library.functions.keys()
    for function, (parameters, kind) in found.items():
        given, _, returned = library.functions[function].partition(">")
        asked = [] if parameters == "void" else [" ".join(parameter.split()) for parameter in parameters.split(",")]
        assert len(given) == len(asked), function
        assert all(letter in letters(parameter) for letter, parameter in zip(given, asked, strict=True)), function
        assert returned == RETURNED[kind], function


def test_every_text_belongs_to_a_library_and_is_whole() -> None:
    names = [text for library in LIBRARIES.values() for text in library.texts]
    assert sorted(names) == sorted(path.name for path in FOLDER.glob("*.c"))
    included = {header for path in FOLDER.rglob("*.[ch]") for header in re.findall(r'#include "(.*)"', path.read_text("utf-8"))}
    generated = {"stage_functions.h"}  # what generated texts begin with
    assert included | generated == {path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*.h")}
    for text in names:
        assert '#include "' not in text_of(text)
        assert text_of(text).count("#define LESSER(") <= 1


@needs_compiler
def test_arrays_are_handed_over_as_they_lie() -> None:
    times, numbers, grown = np.arange(3.0), np.array([[2.0, 1.0, 3.0, 2.0, 9.0, 9.0, 1.0, 4.0, 0.0, 0.0, 0.0, 0.0]]), np.zeros((1, 2, 3))
    compiled = PLAIN.loaded()
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


@needs_compiler
def test_nothing_to_read_is_a_null_pointer() -> None:
    compiled = kernels.CONSERVATIVE_ACCEPT.loaded()
    assert compiled is not None
    table, rules, work = np.full((9, 2), np.nan), np.zeros(60), np.zeros((4, 11))
    assert compiled.mcdas_conservative_accept(table, 2, None, rules, np.zeros((0, 10)), 0, 0, 0, 0, 0, work) == 0


def test_a_library_is_there_once_and_not_where_it_is_forbidden(monkeypatch: pytest.MonkeyPatch) -> None:
    before = PLAIN.loaded()
    assert PLAIN.loaded() is before
    monkeypatch.setenv(SWITCH, "0")
    assert all(library.loaded() is None for library in LIBRARIES.values())
    monkeypatch.delenv(SWITCH)
    assert PLAIN.loaded() is before


def test_without_a_compiler_there_is_none_until_it_is_asked_for_anew(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with monkeypatch.context() as nowhere:
        nowhere.setenv("XDG_CACHE_HOME", str(tmp_path))
        nowhere.setenv("PATH", str(tmp_path))
        nowhere.delenv("CC", raising=False)
        nowhere.delenv(SWITCH, raising=False)
        own = Library(texts=("grown_bodies.c",), builds=PLAIN.builds, functions={"mcdas_grown": "llaaw"})
        warn_interpreted.cache_clear()
        with pytest.warns(InterpretedFormWarning, match=r"no C compiler; install one .* and run `mcdas-opt warmup`"):
            assert own.loaded() is None
        own.forget()
        assert own.loaded() is None  # said once
    assert own.loaded() is None
    own.forget()
    assert (own.loaded() is None) == (PLAIN.loaded() is None)


def test_numbers_become_macros() -> None:
    assert defined({"A": 2, "B": 0.5, "C": (1, (2.0, 3))}) == "#define A 2\n#define B 0.5\n#define C {1, {2.0, 3}}\n"


def test_a_record_is_the_struct_of_the_text() -> None:
    ground, case = record("time_to_react.c", "Ground"), record("time_to_react.c", "Case")
    assert ground._fields_[0] == ("bare", case)
    assert [name for name, *_ in ground._fields_[1:]] == ["moments_s", "lattice_s", "coarse", "exact", "near_d", "latest_s"]
    assert {c_void_p, c_longlong, c_double} == {kind for _, kind in case._fields_}
    with pytest.raises(LookupError, match="no struct Nothing"):
        record("time_to_react.c", "Nothing")


def test_a_user_without_a_home_is_told_and_has_the_readable_forms(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", nowhere)
    library = Library(texts=PLAIN.texts, builds=PLAIN.builds, functions=PLAIN.functions)
    with pytest.raises(NoLibraryError, match="no home folder to keep it in; set XDG_CACHE_HOME"):
        library.load()
    warn_interpreted.cache_clear()
    with pytest.warns(InterpretedFormWarning, match="no home folder"):
        assert library.loaded() is None
