"""Behind a queue nobody enters a junction in which he would stand; where nobody crosses, everybody closes up."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcdas_opt.interop.sumo.connection import started
from mcdas_opt.interop.sumo.driver import SumoDriver
from mcdas_opt.interop.sumo.episode import EpisodeSettings, wait_for
from tests.interop.sumo_configuration import edge, ego, network

NODES = {"a": (0.0, 0.0), "c": (100.0, 0.0), "b": (250.0, 0.0), "d": (100.0, -100.0), "e": (100.0, 100.0)}
ALONG, ACROSS = ("priority='2' speed='13.9'", "priority='1' speed='13.9'")
STANDS_S, LENGTH_M = 30.0, 5.0


def behind_a_queue(folder: Path, room_m: float, *, crossing: bool) -> Path:
    """Somebody stands beyond the junction with so much room behind him, for half a minute."""
    edges = [edge("a", "c", more=ALONG), edge("c", "b", more=ALONG)]
    if crossing:
        edges += [edge("d", "c", more=ACROSS), edge("c", "e", more=ACROSS)]
    at_m = room_m + LENGTH_M
    stands = (
        f'<vehicle id="stands" depart="0" departPos="{at_m}" departSpeed="0"><route edges="c-b"/>'
        f'<stop lane="c-b_0" endPos="{at_m}" duration="{STANDS_S}"/></vehicle>'
    )
    used = {name: place for name, place in NODES.items() if crossing or name in "abc"}
    return network(folder, used, edges, stands + ego("a-c", "c-b"))


@pytest.mark.parametrize(("room_m", "crossing", "enters"), [(3.0, True, False), (12.0, True, True), (4.5, False, True)])
def test_a_junction_is_entered_only_where_it_can_be_left(room_m: float, crossing: bool, enters: bool, tmp_path: Path) -> None:
    config = behind_a_queue(tmp_path, room_m, crossing=crossing)
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver = SumoDriver(sumo, "ego")
        line_m, fronts_m = driver.frame.sections[0].end_m, []
        while driver.step() and sumo.simulation.getTime() < 100.0:
            if sumo.simulation.getTime() < STANDS_S:
                fronts_m.append(driver.snapshots[-1].host.s_m + 0.5 * driver.vehicle.length_m)
        assert (max(fronts_m) > line_m) == enters
        assert max(fronts_m) > line_m - 5.0
        assert driver.summary.ended == "arrived"
        assert not driver.contacts
        assert driver.summary.fallbacks + driver.summary.unavoidable == 0
