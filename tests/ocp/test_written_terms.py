"""A term of somebody's own with a mistake in it is refused by name when the problem is posed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import pytest

from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.ocp.lane_mpc import LaneProblem
from mcdas_opt.ocp.terms import Comfort


@dataclass(frozen=True, kw_only=True)
class Own:
    write: Any
    name: str = "own term [m]"
    slack: str = "comfort"
    parameters: tuple[str, ...] = ()
    weight: float = 1.0
    terminal_weight: float = 1.0

    def rows(self, stage: Any) -> Any:
        return self.write(stage)

    residual = rows


def posed(monkeypatch: pytest.MonkeyPatch, constraint: Any) -> Any:
    monkeypatch.setattr(LaneProblem, "constraints", property(lambda _: (Comfort(), constraint)))
    return LaneProblem(vehicle=Vehicle(), neighbours=0, road_margin_m=0.2).stage_problem()


@pytest.mark.parametrize(
    ("write", "says"),
    [
        (lambda stage: [stage.p["my_limit"]], "my_limit"),
        (lambda stage: stage.v - 3.0, "must be a list"),
        (lambda stage: [stage.v <= 3.0], "no comparison"),
        (lambda stage: [stage.v == 3.0], "no comparison"),
        (lambda stage: [ca.vertcat(stage.v, stage.d)], "one expression"),
        (lambda stage: ["v"], "one expression"),
        (lambda stage: [], "at least one"),
        (lambda stage: None, "must be a list"),
        (lambda stage: [stage.w], "AttributeError"),
    ],
)
def test_a_wrong_constraint_is_named(monkeypatch: pytest.MonkeyPatch, write: Any, says: str) -> None:
    with pytest.raises(ParameterError, match=r"^own term \[m\] = ") as told:
        posed(monkeypatch, Own(write=write))
    assert says in str(told.value)


def test_an_unknown_slack_is_named_with_the_known_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ParameterError, match=r"own term \[m\] = 'comfy': .*friction, road, collision, headway, comfort"):
        posed(monkeypatch, Own(write=lambda stage: [stage.v], slack="comfy"))


def test_a_sound_constraint_is_posed(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = posed(monkeypatch, Own(write=lambda stage: (stage.v - 3.0, 0.0), parameters=("my_limit",)))
    assert problem.rows[-2:] == ("own term [m]", "own term [m]")


@pytest.mark.parametrize("write", [lambda stage: stage.p["my"], lambda stage: stage.v < 3.0, lambda stage: None, lambda stage: [stage.v]])
def test_a_wrong_cost_is_named(write: Any) -> None:
    with pytest.raises(ParameterError, match=r"^own term \[m\] = "):
        LaneProblem(vehicle=Vehicle(), neighbours=0, costs=(Own(write=write),)).stage_problem()


def test_a_column_of_residuals_is_posed() -> None:
    problem = LaneProblem(vehicle=Vehicle(), neighbours=0, costs=(Own(write=lambda stage: ca.vertcat(stage.v, stage.d)),)).stage_problem()
    assert problem.residual.size1_out(0) == 2
