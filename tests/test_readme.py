"""What the README shows is run, and what it promises of the import holds."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.domain.parking import ParkingLimits
from mcdas_opt.domain.settings import Settings
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.verification.parking_judge import STEP_S

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_first_plan_runs_as_printed(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    block = re.search(r"```python\n(.*?)```", README, re.S)
    assert block is not None
    assert len(block.group(1).strip().splitlines()) <= 12
    exec(compile(block.group(1), "README.md", "exec"), {})
    words = capsys.readouterr().out.split()
    assert words[0] == "evade"
    assert words[2] == "True"
    assert (tmp_path / "plan.png").is_file()


def test_its_numbers_are_those_of_the_code() -> None:
    """A page of a registry cannot include them; what was measured is a claim, and is not typed here."""
    scene = load_scene("sandwich-60-40")
    rear = next(car for car in scene.neighbour if car.name == "rear")
    drive = simulate(scene.model_copy(update={"duration_s": 0.3}))
    offsets = (load_scene(f"sandwich-offset-{side}").neighbour[0].d_m for side in ("left", "right"))
    said = {
        f"{3.6 * (rear.initial[3] - scene.host.speed_mps):.0f} km/h",
        f"{drive.cycles[1].time_s - drive.cycles[0].time_s:.1f} s",
        f"{Settings().grid.times_s[-1]:.0f} s",
        f"{100 * ParkingLimits().clearance_m:.0f} cm",
        f"{1e3 * STEP_S:.0f} ms",
        f"{max(abs(d or 0.0) for d in offsets):.0f} m",
    }
    prose = re.sub(r"```.*?```|`[^`]*`|\]\([^)]*\)", "", README, flags=re.S)
    assert set(re.findall(r"\b\d[\d.,]* (?:km/h|m/s|ms|cm|m|s|%)(?!\w)", prose)) == said


def test_exactly_two_set_up_commands() -> None:
    section = README.split("## Set up")[1].split("\n## ")[0]
    blocks = re.findall(r"```sh\n(.*?)```", section, re.S)
    assert [len(block.strip().splitlines()) for block in blocks] == [1, 1]


@pytest.mark.repository
def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        if not target.startswith("http"):
            assert (ROOT / target).exists(), target


@pytest.mark.parametrize("heavy", ["casadi", "osqp", "filterpy", "control", "matplotlib", "scipy", "pydantic"])
def test_import_is_light(heavy: str) -> None:
    code = f"import sys, mcdas_opt; sys.exit({heavy!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_public_name_exists() -> None:
    import mcdas_opt

    for name in mcdas_opt.__all__:
        assert getattr(mcdas_opt, name) is not None
    with pytest.raises(AttributeError, match="no_such_name"):
        assert mcdas_opt.no_such_name
