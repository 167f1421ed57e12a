"""Settings cannot be born wrong: name, value and rule are in the message."""

import math

import pytest

from mcdas_opt.errors import ParameterError
from mcdas_opt.parking.closed_loop.settings import FollowSettings, ParkingNoise
from mcdas_opt.parking.closed_loop.tracker import ParkingActuators
from mcdas_opt.parking.cost import ParkingCosts
from mcdas_opt.parking.program.exchange import ExchangeSettings
from mcdas_opt.parking.program.windows import WindowSettings
from mcdas_opt.parking.search.arc_search import Resolution
from mcdas_opt.parking.settings import ParkSettings


@pytest.mark.parametrize(
    ("record", "name", "value"),
    [
        (ExchangeSettings, "rounds", 0),
        (ExchangeSettings, "trust_region_m", math.nan),
        (ExchangeSettings, "tolerance", (1e-5, 0.0)),
        (ExchangeSettings, "work", -1),
        (ExchangeSettings, "end_share", 1.5),
        (WindowSettings, "stride", 0),
        (ParkSettings, "starts", 0),
        (ParkSettings, "time_budget_s", -1.0),
        (Resolution, "cell_m", math.nan),
        (Resolution, "max_nodes", 0),
        (ParkingCosts, "gear_changes", -0.1),
        (ParkingNoise, "position_m", math.nan),
        (FollowSettings, "tracked_m", 0.0),
        (FollowSettings, "replans", -1),
        (ParkingActuators, "drive_lag_s", 0.0),
    ],
)
def test_nonsense_is_refused_by_name(record, name, value):
    with pytest.raises(ParameterError, match=f"{name}.*must"):
        record(**{name: value})
