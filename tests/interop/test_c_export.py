"""The exported C code: what Python solves it solves, to 1e-6, warm starts from its own answers; and its check can fail."""

from __future__ import annotations

import json
import re
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from mcdas_opt.catalogue.data_files import shipped
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.cli.app import app
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.interop.c_export.export import Export, ExportError, export_c, run_replay
from mcdas_opt.interop.c_export.recording import one_arithmetic
from mcdas_opt.interop.c_export.source import meaning, native_flags
from mcdas_opt.ocp.lane_mpc import family_parameters

GCC = shutil.which("gcc")
needs_gcc = pytest.mark.skipif(GCC is None, reason="no gcc")


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Export:
    return export_c(tmp_path_factory.mktemp("small"), load_scene("cut-in"), steps=40, neighbours=2, compiler=GCC, flags="-O1 -Wall -Wextra")


@needs_gcc
def test_a_thousand_steps_equal_pythons(tmp_path: Path) -> None:
    done = export_c(tmp_path, load_scene("sandwich-60-40"), steps=1000, neighbours=2, compiler=GCC)
    assert done.flags == "-O3 -Wall -Wextra"
    assert done.python_solver == "interior-point (compiled, portable)"
    assert done.steps == 1000
    assert done.warm_steps > 100
    assert done.steps - done.warm_steps > 100
    assert done.warnings == ""
    assert done.max_error is not None
    assert done.max_error <= 1e-6
    assert done.apart == done.mismatches == 0
    for side in ("c", "python"):
        times = done.timing_us[side]
        assert times is not None
        assert 0.0 < times["p50"] <= times["p99"] <= times["max"]


@needs_gcc
@pytest.mark.parametrize("scene", shipped("scenes"))
def test_every_shipped_scene_where_both_sides_calculate_alike(scene: str, tmp_path: Path) -> None:
    """Also those in which solves hardly converge. The first seconds of each; benchmarks/c_export.py does a thousand."""
    done = export_c(tmp_path, load_scene(scene), steps=60, neighbours=2, compiler=GCC, flags="-O1 -Wall -Wextra -Wpedantic")
    assert done.max_error is not None
    assert done.max_error <= 1e-6
    assert done.apart == done.mismatches == 0
    assert done.warnings == ""


@needs_gcc
def test_against_other_mathematics_what_hardly_converges_is_counted(tmp_path: Path) -> None:
    """Close behind an obstacle some solves wander until the last digit of a sine decides: these are told from the rest."""
    done = export_c(tmp_path, load_scene("stopped-obstacle"), steps=60, neighbours=2, compiler=GCC, flags="-O1", arithmetic="native")
    assert done.max_error is not None
    assert done.apart is not None
    assert done.mismatches is not None
    assert done.mismatches <= 0.1 * done.steps
    assert done.apart <= 0.1 * done.steps
    assert (done.apart > 0) == (done.max_error > 1e-6)


@needs_gcc
def test_with_pythons_own_flags_it_equals_python_as_it_flies(tmp_path: Path) -> None:
    scene = load_scene("both-lanes-blocked")
    try:
        done = export_c(tmp_path, scene, steps=100, neighbours=2, compiler=GCC, flags=native_flags(), arithmetic="native")
    except ExportError as error:
        pytest.skip(f"no vector mathematics here: {error}")
    assert done.max_error is not None
    assert done.max_error <= 1e-9
    assert done.mismatches == 0


@needs_gcc
@pytest.mark.skipif(shutil.which("make") is None, reason="no make")
def test_the_makefile_builds_and_checks(small: Export, tmp_path: Path) -> None:
    folder = _copy(small, tmp_path)
    said = subprocess.run(["make", "-s", "check"], cwd=folder, check=True, capture_output=True, text=True)
    assert json.loads(said.stdout)["apart"] == 0
    assert said.stderr == ""


@needs_gcc
def test_the_solver_takes_no_memory_and_calls_only_mathematics(small: Export, tmp_path: Path) -> None:
    target = tmp_path / "mcdas_mpc.o"
    subprocess.run([str(GCC), "-std=c99", "-O1", "-c", "-o", str(target), str(Path(small.folder) / "mcdas_mpc.c")], check=True)
    listed = subprocess.run(["nm", "-u", str(target)], check=True, capture_output=True, text=True).stdout.split()
    assert set(listed) - {"U"} <= {
        "sin",
        "cos",
        "tan",
        "atan",
        "exp",
        "log",
        "tanh",
        "sqrt",
        "pow",
        "sincos",
        "memcpy",
        "memmove",
        "memset",
    } | {
        "_GLOBAL_OFFSET_TABLE_",
        "__stack_chk_fail",
    }


@needs_gcc
def test_nothing_out_of_bounds_and_nothing_undefined(small: Export) -> None:
    checks = "-O0 -g -fsanitize=address,undefined -fno-sanitize-recover=all"
    said, _ = run_replay(Path(small.folder), str(GCC), checks)
    assert said["steps"] == small.steps
    assert said["max_error"] <= 1e-6


def test_the_same_scene_gives_the_same_bytes(small: Export, tmp_path: Path) -> None:
    again = export_c(tmp_path, load_scene("cut-in"), steps=40, neighbours=2, compiler=GCC, flags="-O1 -Wall -Wextra")
    assert again.checksums == small.checksums
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(small.checksums)


@needs_gcc
@pytest.mark.parametrize(("value", "least"), [(1e-3, 0.5e-3), (float("nan"), 1e6)])
def test_a_solver_that_answers_otherwise_is_found_out(small: Export, tmp_path: Path, value: float, least: float) -> None:
    """The last number that Python answered, an input, is changed by `value`."""
    folder = _copy(small, tmp_path)
    raw = bytearray((folder / "replay.bin").read_bytes())
    (last,) = struct.unpack_from("<d", raw, len(raw) - 8)
    struct.pack_into("<d", raw, len(raw) - 8, last + value)
    (folder / "replay.bin").write_bytes(bytes(raw))
    said, _ = run_replay(folder, str(GCC), "-O1")
    assert said["max_error"] >= least


@needs_gcc
def test_a_state_that_is_not_finite_ends_as_such(small: Export, tmp_path: Path) -> None:
    """NaN in the first measured state: the first step ends otherwise than Python's did, and the way's next begins cold or is wrong too."""
    folder = _copy(small, tmp_path)
    raw = bytearray((folder / "replay.bin").read_bytes())
    struct.pack_into("<d", raw, 8 + 6 * 4 + 40 * 8 + 5 * 4, float("nan"))
    (folder / "replay.bin").write_bytes(bytes(raw))
    said, _ = run_replay(folder, str(GCC), "-O1")
    assert said["mismatches"] >= 1
    assert np.isfinite(said["max_error"])


@needs_gcc
def test_a_recording_that_is_cut_off_or_of_another_problem_is_refused(small: Export, tmp_path: Path) -> None:
    folder = _copy(small, tmp_path)
    raw = (folder / "replay.bin").read_bytes()
    for content, said in ((raw[:-4], "cut off in step 39"), (b"\1" + raw[1:], "no recording of this solver"), (raw[:352], "holds no step")):
        (folder / "replay.bin").write_bytes(content)
        with pytest.raises(ExportError, match=said):
            run_replay(folder, str(GCC), "-O1")


def test_bad_input_is_named(tmp_path: Path) -> None:
    scene = load_scene("cut-in")
    taken = tmp_path / "file"
    taken.write_text("")
    with pytest.raises(InputError, match="cannot be made a folder"):
        export_c(taken, scene)
    with pytest.raises(ParameterError, match="steps = 0"):
        export_c(tmp_path, scene, steps=0)
    with pytest.raises(ParameterError, match="neighbours = 17"):
        export_c(tmp_path, scene, neighbours=17)
    with pytest.raises(ParameterError, match="must be one of portable, native"):
        one_arithmetic("fast")
    with pytest.raises(ParameterError, match="no-such-compiler"):
        export_c(tmp_path, scene, compiler="no-such-compiler")


@needs_gcc
def test_code_that_does_not_compile_is_our_own_fault_and_says_why(small: Export, tmp_path: Path) -> None:
    folder = _copy(small, tmp_path)
    (folder / "mcdas_mpc.h").write_text("#error spoilt\n")
    with pytest.raises(ExportError, match="spoilt"):
        run_replay(folder, str(GCC), "-O1")


@needs_gcc
def test_the_command_prints_the_contracts_keys(tmp_path: Path) -> None:
    arguments = ["export-c", str(tmp_path / "c"), "--scene", "cut-in", "--steps", "20", "--neighbours", "2", "--flags", "-O1", "--json"]
    result = CliRunner().invoke(app, arguments, catch_exceptions=False)
    document = json.loads(result.stdout)
    assert result.exit_code == 0
    assert {"files", "checksums", "max_error", "timing_us"} <= set(document)
    assert all(Path(name).is_file() for name in document["files"])


def _copy(export: Export, to: Path) -> Path:
    return Path(shutil.copytree(export.folder, to / "copy"))


@pytest.mark.skipif(GCC is None or shutil.which("g++") is None, reason="no gcc and g++")
def test_cpp_calls_it(small: Export, tmp_path: Path) -> None:
    folder = next(Path(name).parent for name in small.files if name.endswith("mcdas_mpc.h"))
    caller = tmp_path / "caller.cpp"
    caller.write_text('#include "mcdas_mpc.h"\nint main() { return mcdas_mpc_bytes() > 0 ? 0 : 1; }\n', encoding="utf-8")
    for command in (
        ["gcc", "-std=c99", "-O0", "-c", str(folder / "mcdas_mpc.c"), "-o", "mpc.o"],
        ["g++", "-Wall", "-Werror", f"-I{folder}", str(caller), "mpc.o", "-lm", "-o", "caller"],
        ["./caller"],
    ):
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


@needs_gcc
def test_every_parameter_is_explained(small: Export) -> None:
    """With its unit, in the header; also those of cars that slip and of free weights."""
    header = next(Path(name) for name in small.files if name.endswith("mcdas_mpc.h")).read_text("utf-8")
    entries = [line for line in header.splitlines() if line.startswith("    MCDAS_P_")]
    assert len(entries) > 30
    assert all(re.search(r", /\* .+\[.+\].* \*/$", line) for line in entries)
    assert all("[" in meaning(name) for name in family_parameters())
