"""Draws every picture of gallery.md with the command that stands over it there: python docs/draw_gallery.py"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent


def commands() -> list[str]:
    """The commands of the page, in order."""
    return re.findall(r"^mcdas-opt .*$", (HERE / "gallery.md").read_text("utf-8"), flags=re.MULTILINE)


def main() -> None:
    for command in commands():
        print(f"$ {command}", flush=True)
        done = subprocess.run(
            [sys.executable, "-m", "mcdas_opt", *shlex.split(command)[1:]], cwd=HERE, stdout=subprocess.DEVNULL, check=False
        )
        if done.returncode:
            sys.exit(f"exit {done.returncode}")


if __name__ == "__main__":
    main()
