"""Over a plan's picture stands what it does, what the judge says, how it ends and why."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from matplotlib.colors import same_color
from matplotlib.figure import Figure
from matplotlib.text import Text

from mcdas_opt import Planner
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.safe_end import EndKind, SafeEnd
from mcdas_opt.plotting import style
from mcdas_opt.plotting.plan_sheet import plan_sheet
from mcdas_opt.plotting.words import ending
from mcdas_opt.simulation.first_situation import situation_of

LONG = "rear 2, 25.0 m behind, met in 4.6 s; left-same costs 2.52, the least of 8 that pass, next right-same with 2.52; " * 4


@pytest.fixture(scope="module")
def plan() -> Plan:
    situation, vehicle = situation_of("sandwich-60-40")
    return Planner(vehicle).plan(situation)


def head_of(figure: Figure) -> list[Text]:
    figure.canvas.draw()
    return figure.texts


def test_the_end_is_always_said(plan: Plan) -> None:
    said = [text.get_text() for text in head_of(plan_sheet(plan))]
    assert said[2] == "its end: nobody is in its way, after 4.0 s"
    assert head_of(plan_sheet(replace(plan, safe_end=None)))[2].get_text() == "its end: not looked at"


@pytest.mark.parametrize(
    ("demand_mps2", "said"),
    [(0.0, ""), (2.34, "; asks 2.3 m/s² of whoever is behind"), (math.inf, "; no braking of whoever is behind is enough")],
)
def test_what_is_asked_of_whoever_is_behind_is_a_number_or_never_enough(plan: Plan, demand_mps2: float, said: str) -> None:
    end = SafeEnd(kind=EndKind.STOPPED, t_s=3.0, follower_demand_mps2=demand_mps2)
    assert ending(replace(plan, safe_end=end)) == f"at rest in its lane, after 3.0 s{said}"


@pytest.mark.parametrize("kind", [EndKind.STOPPED, EndKind.OPEN])
def test_only_a_plan_with_a_safe_end_is_green(plan: Plan, kind: EndKind) -> None:
    assert plan.verdict.passed
    _, judged, end, *_ = head_of(plan_sheet(replace(plan, safe_end=SafeEnd(kind=kind, t_s=3.0))))
    assert same_color(judged.get_color(), style.VERMILION if kind is EndKind.OPEN else style.GREEN)
    assert same_color(end.get_color(), style.VERMILION) == (kind is EndKind.OPEN)


@pytest.mark.parametrize(("reason", "lines"), [("short", 1), (LONG[:220], 2), (LONG, 2)])
def test_a_reason_takes_up_to_two_lines_and_nothing_overlaps(plan: Plan, reason: str, lines: int) -> None:
    figure = plan_sheet(replace(plan, reason=reason))
    texts = head_of(figure)
    why = [text.get_text() for text in texts[3:]]
    assert len(why) == lines
    assert " ".join(why).endswith(" …") == (reason == LONG)
    boxes = [text.get_window_extent() for text in texts]
    assert all(upper.y0 > lower.y1 for upper, lower in pairwise(boxes))
    assert boxes[-1].y0 > figure.axes[0].get_window_extent().y1
    assert max(box.x1 for box in boxes) < figure.bbox.x1
