"""The attack on every door, in its quick form: nothing foreign, nothing that hangs, nothing that is not finite, unverified or lost."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from benchmarks.attack import guided
from benchmarks.attack.__main__ import ATTACKS, run

# cases here: what takes a process each has its tests in tests/cli and tests/studio
QUICK = {
    "constructors": 300,
    "situations": 30,
    "sequences": 60,
    "crowds": 3,
    "methods": 30,
    "streams": 60,
    "files": 300,
    "journals": 30,
    "kills": 2,
    "planners": 15,
    "parkings": 20,
    "clocks": 10,
    "live": 60,
}


def test_every_attack_is_quick_somewhere() -> None:
    assert set(QUICK) | {"commands", "interrupts", "studio", "deadlines"} == set(ATTACKS)


@pytest.mark.skipif(sys.platform == "win32", reason="operating system: kills as POSIX has them")
@pytest.mark.parametrize("name", QUICK)
def test_an_attack_finds_nothing(name: str) -> None:
    tally = run(name, QUICK[name], seed=21)
    assert tally.wrong == 0, tally.faults
    assert tally.answered > 0
    assert tally.tried == tally.answered + tally.refused


@pytest.mark.parametrize("kind", [kind for kind in guided.KINDS if kind != "commonroad"])
def test_guided_attacks_begin_with_sound_files(kind: str, tmp_path: Path) -> None:
    read, sound = guided.reader(kind)
    assert sound
    for k, data in enumerate(sound):
        file = tmp_path / f"{k}"
        file.write_bytes(data)
        assert read(file)
