"""What the doctor finds: all well where all is well, and by name what is not."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from mcdas_opt.cli.app import app
from mcdas_opt.evaluation import doctor
from mcdas_opt.evaluation.doctor import Check, Diagnosis, Package, diagnose
from mcdas_opt.native import build
from mcdas_opt.native.form import SWITCH
from mcdas_opt.planning.mpc import MpcMethod


def test_doctor_finds_a_working_installation_and_says_so_in_json() -> None:
    done = CliRunner().invoke(app, ["doctor", "--json"])
    assert done.exit_code == 0, done.stdout
    found = json.loads(done.stdout)
    assert set(found) >= {"python", "packages", "solvers", "compiler", "self_test", "schema_version"}
    assert all(check["works"] for check in found["solvers"] + found["self_test"])
    assert {check["name"] for check in found["solvers"]} == {"interior-point", "osqp", "ipopt"}
    assert found["form"]["name"] in ("compiled", "interpreted")
    assert (found["form"]["why"] == "") == (found["form"]["name"] == "compiled")
    assert found["form"]["plan_ms"] > 0.0
    needed = {package["name"]: package["version"] for package in found["packages"] if not package["extra"]}
    assert {"casadi", "osqp", "numpy", "filterpy", "control"} <= set(needed)
    assert all(needed.values())


def test_what_fails_is_named_and_the_exit_code_says_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(self: MpcMethod, *_: object) -> None:
        raise RuntimeError("the solver is on strike")

    monkeypatch.setattr(MpcMethod, "plan", broken)
    found = diagnose()
    assert not found.well
    assert [check.name for check in found.solvers if not check.works] == ["interior-point", "osqp", "ipopt"]
    assert all("on strike" in check.detail for check in found.solvers)
    assert CliRunner().invoke(app, ["doctor"]).exit_code == 1


def test_without_a_compiler_all_is_still_well(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build.shutil, "which", lambda name: None)
    check = doctor._tried("C compiler", doctor._compiler)
    assert not check.works
    assert "no C compiler" in check.detail
    fine = Check(name="x", works=True, detail="")
    found = Diagnosis(
        version="0", python="3", packages=(Package(name="a", version="", extra="web"),), solvers=(fine,), compiler=check, self_test=(fine,)
    )
    assert found.well


def test_the_interpreted_form_is_named_with_its_reason_and_its_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SWITCH, "0")
    found = doctor._form()
    assert found is not None
    assert found.name == "interpreted"
    assert "MCDAS_OPT_COMPILE=0 asks for it" in found.why
    assert "slower" in found.why


def test_version_names_what_this_stands_on() -> None:
    lines = CliRunner().invoke(app, ["--version"]).stdout.splitlines()
    assert lines[0].startswith("mcdas-opt ")
    assert {line.split()[0] for line in lines[1:]} >= {"casadi", "osqp", "numpy", "filterpy", "control"}
