"""What somebody may do besides is drawn dashed, pale and by name, and only where it is apart from the body."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt import Planner
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.plotting.outlook import Outlook
from mcdas_opt.plotting.plan_sheet import plan_sheet

SURE = np.diag([0.04, 0.04, 0.01, 0.01])
BRAKES = Track(
    id="1", s_m=35.0, d_m=0.0, speed_s_mps=14.0, covariance=SURE, acceleration_s_mps2=-5.0, acceleration_s_sd_mps2=0.8, width_m=1.7
)
CHANGES = Track(id="3", s_m=14.0, d_m=3.1, speed_s_mps=17.0, speed_d_mps=-1.2, covariance=SURE)
STAYS = Track(id="bus", s_m=-40.0, d_m=3.7, speed_s_mps=14.0, covariance=SURE)
SITUATION = Situation(
    host=HostState(speed_mps=20.0), road=Road(lanes_left=1, lanes_right=1), tracks=(BRAKES, CHANGES, STAYS), coverage=Coverage()
)


def test_every_body_has_the_colour_of_its_track_and_its_own_name() -> None:
    outlook = Outlook(SITUATION, Vehicle())
    assert outlook.names() == ["front 1", "front 1 braking", "track 3", "track 3 changing lanes", "bus"]
    assert outlook.supposed == [False, True, False, True, False]
    colours = outlook.colours()
    assert colours[0] == colours[1] != colours[2]
    assert colours[2] == colours[3] == colours[4]
    document = outlook.document()
    assert [body.get("supposed", False) for body in document["bodies"]] == outlook.supposed


@pytest.mark.parametrize("after_s", [0.0, 1.5])
def test_the_sheet_names_what_may_be(after_s: float) -> None:
    planner = Planner()
    plan = planner.plan(SITUATION)
    outlook = Outlook(SITUATION, planner.vehicle)
    shown = outlook.moment(plan, after_s).others
    assert [one.name for one in shown if one.supposed] == (["front 1 braking", "track 3 changing lanes"] if after_s else [])
    assert len([one for one in shown if not one.supposed]) == 3
    figure = plan_sheet(plan, after_s)
    axes = figure.axes[0]
    words = [text.get_text() for text in axes.texts]
    assert "front 1 braking" in words
    assert "track 3 changing lanes" in words
    dashed = [patch for patch in axes.patches if patch.get_linestyle() not in ("solid", "-")]
    assert len(dashed) >= 2
