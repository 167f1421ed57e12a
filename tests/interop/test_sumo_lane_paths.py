"""Others follow the lanes that the planner is told they are in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcdas_opt.domain.track import Places, Track
from mcdas_opt.interop.sumo.connection import started
from mcdas_opt.interop.sumo.driver import SumoDriver
from mcdas_opt.interop.sumo.episode import EpisodeSettings, wait_for
from mcdas_opt.interop.sumo.lane_paths import LanePaths
from tests.interop.sumo_configuration import edge, ego, network

pytest.importorskip("libsumo")

NODES = {"m": (0.0, 0.0), "w": (-200.0, 0.0), "e": (200.0, 0.0), "n": (0.0, 150.0), "s": (0.0, -150.0)}
EDGES = [edge(a, "m", 2 if a in "ns" else 1) for a in "wens"] + [edge("m", a) for a in "wens"]
WAYS = [(a, b) for a in "nse" for b in "wens" if a != b and (a, b) != ("e", "w")]


def crossing(folder: Path) -> Path:
    flows = "".join(
        f'<flow id="{a}{b}" begin="{k}" end="60" period="11" departLane="best" departSpeed="8"><route edges="{a}-m m-{b}"/></flow>'
        for k, (a, b) in enumerate(WAYS)
    )
    return network(folder, NODES, EDGES, ego("w-m", "m-e") + flows, "--default.junctions.radius", "8")


def beside_m(track: Track, path: Places) -> float:
    """How far its middle is from a path, in a plane of which s and d are the axes."""
    points = np.array(path)
    begins, ways = points[:-1], np.diff(points, axis=0)
    there = np.array([track.s_m, track.d_m])
    share = np.clip(((there - begins) * ways).sum(axis=1) / (ways**2).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*(begins + share[:, None] * ways - there).T).min())


def test_others_are_in_the_lanes_that_were_told_a_while_later(tmp_path: Path) -> None:
    config = crossing(tmp_path)
    told: list[dict[str, Places]] = []
    off_m: list[float] = []
    turned: set[str] = set()
    with started(config, 3) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        sumo.vehicle.setSpeed("ego", 2.0)
        driver = SumoDriver(sumo, "ego", "sumo")
        for _ in range(450):
            driver.step()
            tracks = {track.id: track for track in driver.situation().tracks}
            then = told[-20] if len(told) >= 20 else {}
            off_m += [beside_m(tracks[name], path) for name, path in then.items() if name in tracks]
            turned |= {name[:2] for name, path in then.items() if abs(path[0][0] - path[-1][0]) > 10.0 < abs(path[0][1] - path[-1][1])}
            told.append({name: track.lane_path_m for name, track in tracks.items() if track.lane_path_m is not None})
    assert len(off_m) > 1000
    assert len(turned) >= 4  # of the six ways on which vehicles turn
    assert float(np.percentile(off_m, 99)) < 1.2  # bodies cut turns by some decimetres
    assert max(off_m) < 3.0


@pytest.mark.parametrize(("signals", "end"), [(0, (198.4, 90.0)), (1, (130.0, 151.6)), (2, (195.2, 161.2))])
def test_indicators_tell_which_way_somebody_takes(signals: int, end: tuple[float, float], tmp_path: Path) -> None:
    # the lane leads on straight and to the right; who shows left is known until its end
    config = crossing(tmp_path)
    with started(config, 3) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        while sumo.vehicle.getLaneID("nw.0") != "n-m_0" if "nw.0" in sumo.vehicle.getIDList() else True:
            sumo.simulationStep()
        sumo.vehicle.setSignals("nw.0", signals)
        path = LanePaths(sumo).of("nw.0", "n-m_0", np.array([198.4, 200.0]), 15.0)
    assert path is not None
    assert float(np.hypot(*np.diff(path, axis=0).T).sum()) <= 5.5 + 20.0 + 6.0 * 15.0
    np.testing.assert_allclose(path[-1], end, atol=0.5)
