"""A user of whom the system knows nothing, as in many containers: no entry of the uid, no HOME, nowhere to keep anything."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import os
from pathlib import Path
os.getuid = os.geteuid = lambda: 54321
try:
    raise SystemExit(f"a home after all: {Path.home()}")
except RuntimeError:
    from mcdas_opt.cli import main
main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="operating system: users as POSIX has them")
@pytest.mark.parametrize("command", ["plan sandwich-60-40 --out drawn.png", "tune --out drawn.png", "doctor --json"])
def test_a_user_without_an_entry_and_without_a_home_is_served(command: str, tmp_path: Path) -> None:
    known = {name: value for name, value in os.environ.items() if name not in ("HOME", "USER", "LOGNAME") and not name.startswith("XDG_")}
    run = [sys.executable, "-c", PROGRAM, *command.split()]
    done = subprocess.run(run, cwd=tmp_path, env=known, capture_output=True, text=True, timeout=120.0, check=False)
    assert (done.returncode, "Traceback" in done.stderr) == (0, False), done.stderr
    assert not command.endswith(".png") or (tmp_path / "drawn.png").is_file()
