"""The site builds without a warning, the notebooks run, and the gallery shows what its commands draw."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import typer
from PIL import Image
from typer.testing import CliRunner

from mcdas_opt.cli.app import app
from tests.studio.browser import chromium

DOCS = Path(__file__).parents[2] / "docs"
NOTEBOOKS = sorted(DOCS.glob("notebooks/*.ipynb"))
TUTORIALS = (
    "first-plan",
    "own-scene",
    "own-planner",
    "own-radar",
    "closed-form-against-mpc",
    "tuning-a-sigmoid",
    "parking-a-car",
    "own-vehicle",
)
REFERENCE = ("api", "cards/", "claims", "files/", "records/", "notebooks/the-paper", "genindex", "py-modindex", "search", "_")
PAGES = [page for folder in ("", "doors", "extend") for page in sorted((DOCS / folder).glob("*.md")) if page.stem not in ("claims", "mpc")]
MEASURED = re.compile(
    r"\b\d[\d,]* (?:of|in) (?:the )?\d[\d,]+\b|\b\d+/\d{2,}\b|\b\d[\d.,]* (?:ms|KiB|kB|MiB|%)(?!\w)|\b\d[\d.]* times (?:as|what)"
)
# intervals, the optimiser's share of a limit, the parking judge's step, a criterion, a lag after its time constant, a deadline's shared end
SETTINGS = {"95 %", "99.5 %", "5 ms", "1 %", "63 %", "20 ms"}
GUIDES = [*sorted(DOCS.glob("*.md")), DOCS.parent / "README.md"]
COMMANDS = typer.main.get_command(app).commands


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built site; a warning is an error."""
    pytest.importorskip("sphinx")
    pytest.importorskip("myst_nb")
    folder = tmp_path_factory.mktemp("built")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-d", str(folder / "trees"), str(DOCS), str(folder / "site")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / "site"


def test_site_builds_and_its_links_lead_somewhere(site: Path) -> None:
    pages = {page.relative_to(site).as_posix(): page.read_text("utf-8") for page in site.rglob("*.html")}
    assert {"index.html", "mpc.html", "api.html", "notebooks/the-paper-in-ten-cells.html", "cards/bicycle.html", "files/scene.html"} <= set(
        pages
    )
    assert "path deviation" in pages["mpc.html"]
    for name, text in pages.items():
        for target in re.findall(r'<(?:a|img)[^>]+(?:href|src)="(?![a-z]+:)([^"#?]+)[^"]*"', text):
            assert (site / name).parent.joinpath(target).exists(), f"{name} leads to {target}, which is not there"


def test_a_page_is_read_on_three_screens_and_no_paragraph_is_a_wall(site: Path) -> None:
    """Reference and records apart; a screen is 1400 x 900. And no page complains on the browser's console, or sticks out of a phone."""
    prose = "article p, article li:not(:has(> p)), article td"
    words = f"[...document.querySelectorAll('{prose}')].map(one => one.innerText.trim().split(/\\s+/).length)"
    long, walls, wide, faults = {}, {}, [], []
    with chromium() as browser:
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
        for file in sorted(site.rglob("*.html")):
            name = file.relative_to(site).as_posix()
            if name.startswith(REFERENCE):
                continue
            page.set_viewport_size({"width": 1400, "height": 900})
            page.goto(file.as_uri())
            screens = page.evaluate("document.querySelector('article').getBoundingClientRect().height") / 900
            most = max(page.evaluate(words), default=0)
            long |= {name: screens} if screens > 3.0 else {}
            walls |= {name: most} if most >= 90 else {}
            page.set_viewport_size({"width": 390, "height": 844})
            if page.evaluate("document.documentElement.scrollWidth") > 391:
                wide.append(name)
    assert not long
    assert not walls
    assert not wide
    assert not faults


def test_no_guide_states_a_measured_figure_of_its_own() -> None:
    """What was measured is a claim, or stands in a dated record: what is left are definitions and settings."""
    found = {}
    for page in PAGES:
        prose = re.sub(r"```.*?```|`[^`]*`", "", page.read_text("utf-8"), flags=re.S)
        typed = {match.group() for match in MEASURED.finditer(prose)} - SETTINGS
        found |= {page.name: typed} if typed else {}
    assert not found


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


def test_pictures_are_what_their_commands_draw_today(tmp_path: Path) -> None:
    """The README's, and the gallery's first: the same picture but for a few pixels, as fonts and antialiasing differ."""
    for name, command in {"sandwich-60-40.png": "simulate sandwich-60-40", "gallery/plan.png": "plan sandwich-60-40"}.items():
        out = tmp_path / Path(name).name
        assert CliRunner().invoke(app, [*command.split(), "--out", str(out)]).exit_code == 0
        with Image.open(DOCS / name) as kept, Image.open(out) as now:
            assert kept.size == now.size, f"{name} is another picture by now: python docs/draw_gallery.py"
            small = [np.asarray(picture.convert("L").resize((160, 160)), dtype=float) for picture in (kept, now)]
        changed = float((abs(small[0] - small[1]) > 40.0).mean())
        assert changed < 0.01, f"{name} is another picture by now: python docs/draw_gallery.py"


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
    assert min(told[name] for name in ("start", "parking", "benchmark", "tuning", "performance", "gallery", "README")) >= 2, told
