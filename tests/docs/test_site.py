"""The site builds without a warning, the notebooks run, and the gallery shows what its commands draw."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
NOTEBOOKS = sorted(DOCS.glob("notebooks/*.ipynb"))


def test_site_builds_with_warnings_as_errors_and_its_links_lead_somewhere(tmp_path: Path) -> None:
    pytest.importorskip("sphinx")
    pytest.importorskip("myst_nb")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-d", str(tmp_path / "trees"), str(DOCS), str(tmp_path / "site")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    pages = {page.relative_to(tmp_path / "site").as_posix(): page.read_text("utf-8") for page in (tmp_path / "site").rglob("*.html")}
    assert {"index.html", "mpc.html", "api.html", "notebooks/the-paper-in-ten-cells.html", "cards/bicycle.html"} <= set(pages)
    assert "path deviation" in pages["mpc.html"]
    for name, text in pages.items():
        for target in re.findall(r'<(?:a|img)[^>]+(?:href|src)="(?![a-z]+:)([^"#?]+)[^"]*"', text):
            assert (tmp_path / "site" / name).parent.joinpath(target).exists(), f"{name} leads to {target}, which is not there"


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs_and_holds_its_outputs(notebook: Path, tmp_path: Path) -> None:
    cells = [cell for cell in json.loads(notebook.read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert all(cell["execution_count"] for cell in cells)
    assert not any(output["output_type"] == "error" for cell in cells for output in cell["outputs"])
    script = "\n".join(["import matplotlib", 'matplotlib.use("Agg")', *("".join(cell["source"]) for cell in cells)])
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr


def test_two_notebooks_and_ten_cells() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["closed-form-against-mpc", "the-paper-in-ten-cells"]
    ten = [cell for cell in json.loads(NOTEBOOKS[1].read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert len(ten) == 10


def test_gallery_shows_what_its_commands_draw() -> None:
    text = (DOCS / "gallery.md").read_text("utf-8")
    drawn = {re.sub(r"\.toml$", ".png", out) for out in re.findall(r"--out (\S+)", text)}
    shown = set(re.findall(r"\]\((gallery/[^)]+)\)", text))
    assert drawn == shown
    assert all((DOCS / picture).is_file() for picture in shown)
