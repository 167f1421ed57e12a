"""Over a plan's picture stands what it does, what the judge says, how it ends and why."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.colors import same_color
from matplotlib.figure import Figure
from matplotlib.text import Text

from mcdas_opt import Planner
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.safe_end import EndKind, SafeEnd
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.plotting import style
from mcdas_opt.plotting.plan_sheet import plan_sheet
from mcdas_opt.plotting.words import doing, ending
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


@pytest.mark.parametrize(("margin_m", "said"), [(None, "nobody is ahead"), (3.0, "that can be held if that brakes fully")])
def test_a_distance_to_whoever_is_ahead_is_said_only_where_there_is_one(plan: Plan, margin_m: float | None, said: str) -> None:
    end = SafeEnd(kind=EndKind.HELD, t_s=3.0, front_margin_m=margin_m, follower_demand_mps2=1.0)
    told = ending(replace(plan, safe_end=end))
    assert said in told
    assert ("whoever is ahead" in told) is (margin_m is not None)


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


def test_lines_and_outlines_are_explained_between_road_and_charts(plan: Plan) -> None:
    figure = plan_sheet(plan)
    figure.canvas.draw()
    (legend,) = figure.legends
    said = [text.get_text() for text in legend.get_texts()]
    assert said == ["plan, a dot a second", "track with its 2.5 sigma", "where everybody is believed to be after each second"]
    box, road, chart = legend.get_window_extent(), figure.axes[0].get_window_extent(), figure.axes[1].get_tightbbox()
    assert chart is not None
    assert chart.y1 < box.y0 < box.y1 < road.y0
    later = [text.get_text() for text in plan_sheet(plan, 1.0).legends[0].get_texts()]
    assert later == said[:2]  # without outlines


@pytest.mark.parametrize(
    ("mode", "side", "speeds", "said"),
    [
        (Mode.HOLD, Side.NONE, (11.1, 10.8), "keeps its lane and speed"),
        (Mode.HOLD, Side.NONE, (11.1, 8.0), "keeps its lane, slows down to 8.0 m/s"),
        (Mode.HOLD, Side.NONE, (11.1, 13.0), "keeps its lane, speeds up to 13.0 m/s"),
        (Mode.CRUISE, Side.LEFT, (11.1, 11.1), "moves over, towards the desired speed, to the left"),
        (Mode.BRAKE, Side.NONE, (11.1, 0.0), "brakes in its lane"),
        (Mode.EVADE, Side.RIGHT, (11.1, 11.1), "steers out to the right"),
    ],
)
def test_what_a_plan_does_is_said_truly(plan: Plan, mode: Mode, side: Side, speeds: tuple[float, float], said: str) -> None:
    x = plan.trajectory
    driven = replace(x, speed_mps=np.linspace(*speeds, len(x)))
    assert doing(replace(plan, mode=mode, side=side, trajectory=driven)) == said


def test_who_drives_across_the_road_is_in_the_window_and_named_while_not_there() -> None:
    situation, vehicle = situation_of("crossing-car")
    figure = plan_sheet(Planner(vehicle).plan(situation))
    axes = figure.axes[0]
    assert "▲ track 1 (53 m)" in [text.get_text() for text in axes.texts]
    assert axes.get_ylim()[0] < -5.0  # where it is in 4 s
