"""The site builds without a warning, the notebooks run, and the gallery shows what its commands draw."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from mcdas_opt.cli.app import app

DOCS = Path(__file__).parents[2] / "docs"
NOTEBOOKS = sorted(DOCS.glob("notebooks/*.ipynb"))
TUTORIALS = ("first-plan", "own-scene", "own-planner", "own-radar", "tuning-a-sigmoid", "parking-a-car", "own-vehicle")
GUIDES = [*sorted(DOCS.glob("*.md")), DOCS.parent / "README.md"]
COMMANDS = typer.main.get_command(app).commands


def test_site_builds_with_warnings_as_errors_and_its_links_lead_somewhere(tmp_path: Path) -> None:
    pytest.importorskip("sphinx")
    pytest.importorskip("myst_nb")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-d", str(tmp_path / "trees"), str(DOCS), str(tmp_path / "site")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    pages = {page.relative_to(tmp_path / "site").as_posix(): page.read_text("utf-8") for page in (tmp_path / "site").rglob("*.html")}
    assert {"index.html", "mpc.html", "api.html", "notebooks/the-paper-in-ten-cells.html", "cards/bicycle.html", "files/scene.html"} <= set(
        pages
    )
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


def test_every_notebook_is_in_the_contents_and_the_paper_takes_ten_cells() -> None:
    listed = re.findall(r"^notebooks/(\S+)$", (DOCS / "index.md").read_text("utf-8"), re.M)
    assert sorted(listed) == [path.stem for path in NOTEBOOKS]
    paper = json.loads((DOCS / "notebooks" / "the-paper-in-ten-cells.ipynb").read_text("utf-8"))
    assert len([cell for cell in paper["cells"] if cell["cell_type"] == "code"]) == 10


@pytest.mark.parametrize("notebook", TUTORIALS)
def test_a_tutorial_goes_through_the_door_shows_a_picture_and_is_short(notebook: str) -> None:
    cells = json.loads((DOCS / "notebooks" / f"{notebook}.ipynb").read_text("utf-8"))["cells"]
    code = "".join(line for cell in cells if cell["cell_type"] == "code" for line in cell["source"])
    assert "import mcdas_opt as mo" in code
    assert len(re.findall(r"from mcdas_opt|import mcdas_opt\.", code)) <= 1
    assert any("image/png" in output.get("data", {}) for cell in cells for output in cell.get("outputs", ()))
    words = [len("".join(cell["source"]).split()) for cell in cells if cell["cell_type"] == "markdown"]
    assert max(words) <= 90
    assert sum(words) <= 400


def test_gallery_shows_what_its_commands_draw() -> None:
    text = (DOCS / "gallery.md").read_text("utf-8")
    drawn = {re.sub(r"\.toml$", ".png", out) for out in re.findall(r"--out (\S+)", text)}
    shown = set(re.findall(r"\]\((gallery/[^)]+)\)", text))
    assert drawn == shown
    assert all((DOCS / picture).is_file() for picture in shown)


def shell_lines(text: str) -> list[list[str]]:
    """The commands of a page's shell blocks, as words, without comments and variables set before them."""
    lines = "\n".join(re.findall(r"^```sh\n(.*?)^```", text, re.S | re.M)).replace("\\\n", " ").splitlines()
    return [[word for word in shlex.split(line, comments=True) if not re.match(r"[A-Z_]+=", word)] for line in lines if line.strip()]


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_what_a_guide_tells_to_run_is_there(page: Path) -> None:
    """Commands and options of ours, and scripts; what they do is tested where they are."""
    for words in shell_lines(page.read_text("utf-8")):
        if words and Path(words[0]).name == "mcdas-opt":
            known = {option for parameter in COMMANDS[words[1]].params for option in parameter.opts}
            assert {word for word in words[2:] if word.startswith("--")} <= known, words
        elif words[0] == "python" and words[1].endswith(".py"):
            assert (DOCS.parent / words[1]).is_file() or (DOCS / words[1]).is_file(), words
        elif words[:2] == ["python", "-m"] and words[2].startswith("benchmarks."):
            module = DOCS.parent / words[2].replace(".", "/")
            assert module.with_suffix(".py").is_file() or (module / "__main__.py").is_file(), words


def test_guides_have_commands() -> None:
    told = {page.stem: len(shell_lines(page.read_text("utf-8"))) for page in GUIDES}
    assert min(told[name] for name in ("start", "parking", "benchmark", "tuning", "performance", "doors", "gallery", "README")) >= 2, told
