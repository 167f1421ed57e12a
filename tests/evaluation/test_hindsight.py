"""What could still have been done: found where there is something, and nothing found where there is nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.evaluation import hindsight
from mcdas_opt.evaluation.commonroad_campaign import NOT_SHOWN, OURS, RECORDING, blame_of
from mcdas_opt.evaluation.hindsight import is_free, last_chance, would_have_braked
from mcdas_opt.evaluation.oracle import seen_from
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.neighbours import known_bodies
from mcdas_opt.simulation.record import Outcome, Simulation

pytest.importorskip("shapely")


def lost(folder: Path, neighbours: str, *, host: str = "speed_mps = 20.0", road: str = "", planner: str = "acc") -> Simulation:
    path = folder / "lost.toml"
    path.write_text(f"duration_s = 8.0\n[road]\n{road}\n[host]\n{host}\n{neighbours}", "utf-8")
    return simulate(load_scene(path), planner)


WALL = "[[neighbour]]\ns_m = {s}\nspeed_mps = 0.0\nwidth_m = {width}\n"


def test_a_wall_too_near_leaves_nothing_to_do(tmp_path: Path) -> None:
    drive = lost(tmp_path, WALL.format(s=14.0, width=3.6))
    assert drive.outcome is Outcome.COLLISION
    assert last_chance(drive) is None
    assert blame_of(drive) == (NOT_SHOWN, None)


def test_who_could_have_steered_out_had_a_chance_that_goes_well_in_the_plane(tmp_path: Path) -> None:
    curve = "lanes_left = 1\ncurvature = [[0.0, 0.003]]"
    drive = lost(tmp_path, WALL.format(s=28.0, width=1.8), road=curve)
    assert drive.outcome is Outcome.COLLISION
    chance = last_chance(drive)
    assert chance is not None
    assert 0.5 <= chance.before_s <= drive.duration_s
    scene = drive.scene
    assert is_free(chance.drive, seen_from(known_bodies(scene), drive.duration_s - chance.before_s), scene.vehicle, scene.true_road)
    assert blame_of(drive) == (OURS, round(chance.before_s, 2))


def test_who_took_a_bend_too_fast_before_a_follower_need_not_have_stood(tmp_path: Path) -> None:
    bend = "curvature = [[0.0, 0.0], [25.0, 0.0], [29.0, 0.16], [34.0, 0.16], [38.0, 0.0]]"
    follower = "[[neighbour]]\ns_m = -9.0\nspeed_mps = 7.0\n"
    drive = lost(tmp_path, follower, host="speed_mps = 7.0\ndesired_speed_mps = 7.0", road=bend)
    assert drive.outcome is Outcome.LEFT_ROAD
    assert blame_of(drive) == (OURS, 0.5)


def test_it_is_looked_for_as_far_back_as_the_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = lost(tmp_path, "", host="speed_mps = 10.0", road="curvature = [[0.0, 0.0], [70.0, 0.0], [74.0, 0.16], [90.0, 0.16]]")
    assert drive.outcome is Outcome.LEFT_ROAD
    assert drive.duration_s > 6.5
    kept = drive.trajectory
    monkeypatch.setattr(hindsight, "_found", lambda begun, *_: kept if begun.s_m == 0.0 else None)
    assert last_chance(drive) == (drive.duration_s, kept)


@pytest.mark.parametrize(("behind_m", "blame"), [(-40.0, RECORDING), (-9.0, None)])
def test_who_drives_into_a_slow_host_from_afar_would_have_braked(tmp_path: Path, behind_m: float, blame: str | None) -> None:
    follower = f"[[neighbour]]\ns_m = {behind_m}\nspeed_mps = 20.0\n"
    drive = lost(tmp_path, follower, host="speed_mps = 8.0\ndesired_speed_mps = 8.0")
    assert drive.outcome is Outcome.COLLISION
    assert would_have_braked(drive) is (blame == RECORDING)
    if blame is not None:
        assert blame_of(drive) == (blame, None)
