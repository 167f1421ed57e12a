"""Building and loading come before planning, never in it."""

from __future__ import annotations

import gc
import json
from ctypes import CDLL
from dataclasses import replace

import pytest
from typer.testing import CliRunner

import mcdas_opt as mo
from mcdas_opt.cli.app import app
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.native import library
from mcdas_opt.native.form import SWITCH
from mcdas_opt.planning.lane_problem import transcribed_problem
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.solvers.osqp_engine import OsqpEngine


@pytest.mark.parametrize("planner", ["mpc", "closed-form", "closed-form-corrected", "aeb", "un-r157", "idm-mobil"])
@pytest.mark.parametrize("scene", ["sandwich-60-40", "both-lanes-blocked"])
def test_a_planner_that_is_built_loads_nothing_more(planner: str, scene: str, monkeypatch: pytest.MonkeyPatch) -> None:
    library.forget()
    situation, asked = mo.load_situation(scene), list[bool]()
    built = mo.Planner(method=planner)
    load = library.load

    def noted(*, portable: bool = False) -> CDLL:
        asked.append(portable)
        return load(portable=portable)

    monkeypatch.setattr(library, "load", noted)
    built.plan(situation)
    assert asked == []


def test_a_road_whose_edges_change_waits_for_no_problem_to_be_posed(monkeypatch: pytest.MonkeyPatch) -> None:
    built, lanes = mo.Planner(), (Lane(lane=1, width_m=((40.0, 3.7), (90.0, 3.0))),)
    situation = replace(mo.load_situation("sandwich-60-40"), road=Road(lanes_left=1, lanes=lanes))
    posed = transcribed_problem._original.cache_info().misses
    assert situation.road.edges is not None
    built.plan(situation)
    assert transcribed_problem._original.cache_info().misses == posed


def test_the_first_planner_has_the_collector_look_through_what_was_loaded_and_loads_the_backup(monkeypatch: pytest.MonkeyPatch) -> None:
    loaded = list[bool]()
    monkeypatch.setattr(MpcMethod, "_is_rehearsed", False)
    monkeypatch.setattr(OsqpEngine, "load", lambda: loaded.append(True))
    full = gc.get_stats()[2]["collections"]
    mo.Planner()
    once = gc.get_stats()[2]["collections"]
    assert once > full
    assert loaded
    mo.Planner()
    assert gc.get_stats()[2]["collections"] == once


def test_a_plan_says_which_form_made_it_also_where_the_fallback_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    blocked = mo.plan(mo.load_situation("both-lanes-blocked"))
    assert blocked.status is not mo.Status.PLANNED
    assert blocked.solver.startswith("interior-point (")
    monkeypatch.setenv(SWITCH, "0")
    assert mo.Planner().plan(mo.load_situation("benign-following")).solver == "interior-point (interpreted)"


def test_warmup_names_the_form_of_every_vehicle() -> None:
    done = CliRunner().invoke(app, ["warmup", "--vehicle", "sedan", "--json"])
    (ready,) = json.loads(done.stdout)["vehicles"]
    assert ready["vehicle"] == "sedan"
    assert ready["solver"].startswith("interior-point (")
    wrong = CliRunner().invoke(app, ["warmup", "--vehicle", "bicycle"])
    assert isinstance(wrong.exception, mo.InputError)
