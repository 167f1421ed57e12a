"""What the README shows is run, and what it promises of the import holds."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

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


def test_exactly_two_set_up_commands() -> None:
    section = README.split("## Set up")[1].split("\n## ")[0]
    blocks = re.findall(r"```sh\n(.*?)```", section, re.S)
    assert [len(block.strip().splitlines()) for block in blocks] == [1, 1]


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
