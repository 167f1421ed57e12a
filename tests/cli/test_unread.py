"""An option that a command would not read in the mode that was asked for is refused by name, before anything is done."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.command_line import run

WORKERS = "--workers: not read by --scheduler, which has workers of its own"
FATROP = "--solver = 'fatrop': is asked neither with --checks duals nor with --cost clearance: ipopt is"


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("verify parallel driven.csv --prediction nonsense", "--prediction = 'nonsense': not read by a parking case: nobody moves there"),
        ("judge parallel driven.csv --prediction scene", "--prediction = 'scene': not read by a parking case: nobody moves there"),
        (
            "park parallel --planner two-arc --cost time --guesses search --checks duals --solver fatrop --budget 1",
            "--cost, --guesses, --checks, --solver, --budget: not read by two-arc, which minimises nothing",
        ),
        ("park parallel --planner search --cost path --budget 9 --solver ipopt", "--solver: not read by search, only by nlp"),
        ("live --play front_and_rear --interface pcan", "--interface: not read by --play, which has buses of its own"),
        ("replay front_and_rear --no-plan --planner magic", "--planner: not read by --no-plan"),
        ("benchmark sandwich --workers 2 --scheduler tcp://nobody:1", WORKERS),
        ("benchmark commonroad --data . --workers 2 --scheduler tcp://nobody:1", WORKERS),
        ("tune --scenes sandwich --storage s.db --workers 2 --scheduler tcp://nobody:1", WORKERS),
        ("benchmark sandwich --data recordings", "--data = 'recordings': not read by the suite sandwich, which has no recordings"),
        ("tune --speed 60km/h --speed-bounds 50km/h 70km/h", "--speed: not read by --speed-bounds, within which it is chosen"),
        ("tune --objective clearance --clearance 0.5", "--clearance: not read by --objective clearance, which makes it as large as it can"),
        ("tune --clearance 0.5", "--clearance: not read by a design that passes nobody: --front-gap or --rear-gap says whom"),
        ("park parallel --solver fatrop --checks duals", FATROP),
        ("park parallel --solver fatrop --cost clearance", FATROP),
    ],
)
def test_what_nobody_would_read_is_refused(
    command: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(monkeypatch, capsys, *command.split()) == (2, "", f"mcdas-opt: {words}\n")
    assert not list(tmp_path.iterdir())
