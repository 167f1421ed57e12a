"""The report: complete, self-contained, and a page that a browser shows without a network."""

from __future__ import annotations

import html as html_module
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.evaluation.case import Traffic
from mcdas_opt.evaluation.reporting.contents import card, report
from mcdas_opt.evaluation.reporting.document import Bars, Heading, Table, html, markdown
from mcdas_opt.evaluation.row import Row, row_of
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.evaluation.summary import contradictions, pairs, summarise, worst
from mcdas_opt.plotting.animation import draw_thumbnail
from mcdas_opt.plotting.benchmark import draw_cycle_times, draw_scatter
from mcdas_opt.plotting.style import figure, png_bytes
from mcdas_opt.simulation.loop import simulate

PLANNERS = ("mpc", "closed-form", "aeb")
BROWSER = next((path for path in map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome")) if path), None)


def table(count: int = 30, seed: int = 1) -> tuple[list[dict[str, Any]], list[list[float]]]:
    """Rows as a run leaves them, drawn at random: scripted scenes with labels, reacting ones that are nominal, one failure."""
    rng = np.random.default_rng(seed)
    rows, cycles = [], []
    for index in range(count):
        scripted = index % 3 > 0
        label = str(rng.choice(list("AACU?"))) if scripted else "-"
        for planner in PLANNERS:
            outcome = str(rng.choice(["safe", "safe", "collision", "left_road"])) if label != "U" else "collision"
            hit = str(rng.choice(["front", "rear", "side"])) if outcome == "collision" else ""
            row = Row(
                index=index,
                scene=f"scene<{index}>",
                family=f"family-{index % 4}",
                traffic=(Traffic.SCRIPTED if scripted else Traffic.REACTING).value,
                nominal=not scripted,
                seed=index,
                planner=planner,
                plant="kinematic",
                outcome=outcome,
                hit=hit,
                collided_with="rear & co" if hit else "",
                impact_speed_mps=float(rng.uniform(1, 20)) if hit else 0.0,
                duration_s=8.0,
                min_clearance_m=0.0 if hit else float(rng.uniform(0.1, 9.0)),
                max_lateral_acceleration_mps2=float(rng.uniform(0, 6)),
                max_deceleration_mps2=float(rng.uniform(0, 8)),
                intervention=str(rng.choice(["", "steering"])),
                plans=80,
                unverified_plans=int(rng.integers(0, 3)),
            )
            rows.append(
                {**row.to_dict(), "label": label, "label_late": label, "label_with_room": label, "onset_s": 1.0 if scripted else None}
            )
            cycles.append([float(ms) for ms in rng.lognormal(2.0, 1.0, 20)])
    failed = Row(index=count, scene="last", family="family-0", traffic="scripted", nominal=False, seed=1, planner="mpc", plant="kinematic")
    for planner in PLANNERS:
        row = {**failed.to_dict(), "planner": planner, "ended": "raised", "error": "ValueError: no"}
        rows.append(row | {"label": "A", "label_late": "A", "label_with_room": "A", "onset_s": 0.0})
        cycles.append([])
    return rows, cycles


def manifest(rows: int) -> dict[str, Any]:
    return {
        "suite": "a <suite>",
        "scenes": rows,
        "planners": list(PLANNERS),
        "plant": "kinematic",
        "seed": 7,
        "suite_hash": "5" * 64,
        "labels_hash": "1" * 64,
        "rows_hash": "2" * 64,
        "versions": {"python": "3.11", "mcdas-opt": "0.1.0"},
        "commit": "abcdef012345",
    }


@pytest.fixture(scope="module")
def page() -> tuple[str, str]:
    """HTML and Markdown of a report with two cards."""
    rows, cycles = table()
    summary = summarise(rows, cycles, [0.5] * len(rows), PLANNERS)
    blank = png_bytes(figure(2.0, 1.0))
    chosen = worst(rows, "mpc", 2)
    pages = {row["index"]: f"worst/{row['scene']}.html" for row in chosen}
    cards = [card(row, blank, f"mcdas-opt simulate worst/{row['scene']}.toml --planner mpc", pages[row["index"]]) for row in chosen]
    found = report(manifest(31), rows, cycles, summary, cards, ["About <this> suite."], pages)
    return html(found), markdown(found)


def test_shares_count_what_they_say() -> None:
    rows, cycles = table()
    summary = summarise(rows, cycles, [0.5] * len(rows), PLANNERS)
    for planner in PLANNERS:
        mine = [row for row in rows if row["planner"] == planner and row["traffic"] == "scripted"]
        figures = summary[planner]["scripted"]
        avoidable = [row for row in mine if row["label"] == "A"]
        hits = [row for row in avoidable if row["outcome"] == "collision" or row["ended"] != "drove"]
        assert (figures["collisions_on_A"]["k"], figures["collisions_on_A"]["n"]) == (len(hits), len(avoidable))
        faces = sum(figures[f"{face}_hits"]["k"] for face in ("front", "rear", "side"))
        assert faces + figures["failures"]["k"] == figures["collisions"]["k"]
        assert figures["lost"]["k"] == figures["collisions"]["k"] + figures["road_departures"]["k"]
        assert sum(part["lost"]["n"] for part in figures["families"].values()) == figures["scenes"]
        nominal = summary[planner]["reacting"]["false_interventions"]
        assert nominal["n"] == 10
        assert figures["false_interventions"]["n"] == 0
        assert summary[planner]["cycle_ms"]["n"] == 600
        assert summary[planner]["cycle_ms"]["drives_per_s"] == pytest.approx(2.0)


def test_traffic_is_never_mixed_and_pairs_mirror() -> None:
    rows, _ = table()
    found = pairs(rows, ("mpc", "aeb"))
    back = pairs(rows, ("aeb", "mpc"))
    assert {pair["traffic"] for pair in found} == {"scripted", "reacting"}
    for one, other in zip(found, back, strict=True):
        assert (one["only_first"], one["only_second"], one["p"]) == (other["only_second"], other["only_first"], other["p"])
    everywhere = [pair for pair in found if pair["measure"] == "lost"]
    assert sum(pair["n"] for pair in everywhere) == 31


def test_a_planner_that_fails_has_lost_and_hit() -> None:
    rows, cycles = table(0)
    figures = summarise(rows, cycles, [0.5] * len(rows), PLANNERS)["mpc"]["scripted"]
    assert figures["collisions_on_A"]["k"] == figures["lost_on_A"]["k"] == figures["failures"]["k"] == 1


def test_the_worst_come_first_and_a_safe_drive_on_u_is_a_contradiction() -> None:
    rows, _ = table()
    order = worst(rows, "mpc", 100)
    fates = [row["outcome"] != "safe" for row in order]
    assert fates == sorted(fates, reverse=True)
    labels = [row["label"] for row in order if row["outcome"] != "safe"]
    assert labels == sorted(labels, key="A?-CU".index)
    assert contradictions(rows) == []
    safe = next(row for row in rows if row["outcome"] == "safe")
    assert contradictions([safe | {"label": "U"}]) == [safe | {"label": "U"}]


class Elements(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "link", "img"):
            self.open.append(tag)
        self.links += [value or "" for name, value in attributes if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_html_is_whole_and_needs_nothing_else(page: tuple[str, str]) -> None:
    elements = Elements()
    elements.feed(page[0])
    assert elements.open == []
    assert elements.links
    beside = {link for link in elements.links if not link.startswith("data:")}
    assert beside
    assert beside <= {*(f"worst/scene%3C{index}%3E.html" for index in range(30)), "worst/last.html"}
    assert "<script" not in page[0]
    assert "a &lt;suite&gt;" in page[0]
    assert "About &lt;this&gt; suite." in page[0]
    assert re.search(r"scene<\d", page[0]) is None


def test_the_report_leads_with_what_was_lost_on_a_and_names_every_such_scene() -> None:
    rows, cycles = table()
    summary = summarise(rows, cycles, [0.5] * len(rows), PLANNERS)
    mine = [row for row in rows if row["planner"] == "mpc" and row["label"] in "A-" and row["outcome"] != "safe"]
    blocks = report(manifest(31), rows, cycles, summary, [], (), {row["index"]: "page.html" for row in mine[:2]}).blocks
    heading, bars = blocks[:2]
    assert isinstance(heading, Heading)
    assert heading.text == "Lost, of the avoidable scenes (A): scripted traffic"
    assert isinstance(bars, Bars)
    assert [bar.name for bar in bars.bars] == list(PLANNERS)
    share = summary["mpc"]["scripted"]["lost_on_A"]
    assert bars.bars[0].says.startswith(f"{share['k']} of {share['n']}, ")
    lost_table = next(block for block in blocks if isinstance(block, Table))
    assert {cells[0].text for cells in lost_table.rows} == {row["scene"] for row in mine}
    assert [cells[0].page for cells in lost_table.rows].count("page.html") == 2
    also = {(row["scene"], row["planner"]) for row in rows if row["outcome"] != "safe"}
    for scene, _, _, others in lost_table.rows:
        named = [] if others.text == "nobody" else others.text.split(", ")
        assert set(named) == {planner for planner in PLANNERS[1:] if (scene.text, planner) in also}


def test_many_planners_and_families_stay_tables() -> None:
    rows, cycles = table()
    names = [f"planner-{k}" for k in range(9)]
    many = [{**row, "planner": name} for row in rows if row["planner"] == "mpc" for name in names]
    times = [times for row, times in zip(rows, cycles, strict=True) if row["planner"] == "mpc" for _ in names]
    found = report({**manifest(31), "planners": names}, many, times, summarise(many, times, [0.5] * len(many), names), [])
    assert not [picture.name for picture in found.pictures if picture.name.startswith("families")]
    by_family = [block for block in found.blocks if isinstance(block, Table) and block.columns[0] == "family"]
    assert [list(block.columns[1:]) for block in by_family] == [names, names]
    compared = next(block for block in found.blocks if isinstance(block, Table) and block.columns[0] == "pair")
    assert all(cells[0].text.startswith("planner-0 against") for cells in compared.rows)


def test_nobody_is_praised_for_drives_that_ended_early() -> None:
    """Who leaves the road hits nobody: fewer collisions, and no better."""
    rows, cycles = table()
    for row in rows:
        if row["planner"] == "closed-form":
            row.update(outcome="left_road", collided_with=None, hit="")
    found = report(manifest(31), rows, cycles, summarise(rows, cycles, [0.5] * len(rows), PLANNERS), [])
    shares = [block for block in found.blocks if isinstance(block, Table) and block.columns[0] == "share of drives"]
    assert len(shares) == 2
    for block in shares:
        praised = {cells[0].text: [cell.best for cell in cells[1:]] for cells in block.rows}
        assert not any(praised["collisions, every scene"])
        assert any(praised["lost, every scene"])
        assert not praised["lost, every scene"][PLANNERS.index("closed-form")]
        assert "until the drive ended" in block.caption


def test_a_reason_is_shortened_at_a_word() -> None:
    rows, _ = table(1)
    reason = " ".join(f"because{k}" for k in range(99))
    facts = card({**rows[0], "first_reason": reason}, b"", "").facts
    assert "because20 " in facts
    assert facts.endswith(" …")
    assert facts.removesuffix(" …").split()[-1] in reason.split()


def test_markdown_says_the_same(page: tuple[str, str]) -> None:
    cells = re.findall(r"(\d+/\d+ \[[\d., ]+\])", page[0].replace("\u00a0", " "))
    assert cells
    assert cells == re.findall(r"(\d+/\d+ \[[\d., ]+\])", page[1])
    for fact in ("5" * 64, "abcdef012345", "mcdas-opt 0.1.0"):
        assert fact in page[0]
        assert fact in page[1]


@pytest.mark.skipif(BROWSER is None, reason="no Chromium here")
def test_a_browser_shows_it_without_a_network(page: tuple[str, str], tmp_path: Path) -> None:
    """The page's own script, added for the test, tells what the browser made of it."""
    probe = (
        "<script>addEventListener('load', () => { const seen = {"
        " images: [...document.images].filter(i => i.complete && i.naturalWidth > 50).length, of: document.images.length,"
        " rows: document.querySelectorAll('tbody tr').length, wide: document.documentElement.scrollWidth - innerWidth,"
        " fetched: performance.getEntriesByType('resource').filter(e => !e.name.startsWith('data:')).length };"
        " const at = document.createElement('pre'); at.id = 'seen'; at.textContent = JSON.stringify(seen); document.body.append(at); })"
        "</script></body>"
    )
    path = tmp_path / "report.html"
    path.write_text(page[0].replace("</body>", probe), encoding="utf-8")
    assert BROWSER is not None
    offline = ["--host-resolver-rules=MAP * ~NOTFOUND", "--disable-background-networking"]
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}", *offline]
    done = subprocess.run(
        [*command, "--window-size=1280,2000", "--virtual-time-budget=5000", "--dump-dom", path.as_uri()],
        capture_output=True,
        text=True,
        timeout=180,
    )
    seen = re.search(r'<pre id="seen">(.*?)</pre>', done.stdout)
    assert seen is not None, done.stderr[-2000:]
    facts = json.loads(html_module.unescape(seen[1]))
    assert facts["images"] == facts["of"] == 7
    assert facts["rows"] >= 3 * 5
    assert facts["wide"] <= 0
    assert facts["fetched"] == 0


def test_the_row_of_a_drive_agrees_with_the_drive() -> None:
    """A lane change settles near its lane's centre; a struck face is where the other was."""
    scene = load_scene("sandwich-60-40")
    case = expand("sandwich", 1).cases[0]
    case = type(case)(index=0, family="shipped", traffic=Traffic.SCRIPTED, scene=scene)
    drive = simulate(scene, "closed-form-corrected")
    row = row_of(case, drive)
    assert row.outcome == drive.outcome.value
    assert row.plans == len(drive.cycles)
    if drive.lane_change_completed:
        assert row.settling_error_m is not None
        assert row.settling_error_m < 0.4
        assert "steering" in row.intervention
    struck = simulate(load_scene("both-lanes-blocked"), "aeb")
    told = row_of(case, struck)
    assert (told.hit == "") == (struck.collided_with is None)
    if struck.collided_with is not None:
        other = next(other for other in struck.neighbours if other.name == struck.collided_with)
        ahead = float(other.s_m[-1]) > float(struck.trajectory.s_m[-1])
        assert told.hit in ("side", "front" if ahead else "rear")


def test_cycle_times_are_drawn_of_nobody_who_planned_too() -> None:
    drawn = draw_cycle_times({"raised": np.zeros(0), "planned": np.array([1.0, 2.0])})
    assert len(drawn.axes[0].get_legend_handles_labels()[0]) == 1
    assert png_bytes(draw_cycle_times({"raised": np.zeros(0)}))  # a warning would fail here


def test_axes_say_what_is_drawn_at_their_ends_and_times_are_plain_numbers() -> None:
    scatter = draw_scatter({"mpc": np.array([[9.0, 20.0, 0.0]])})
    assert scatter.get_supxlabel() == "largest acceleration [m/s²] (13: that or more)"
    assert scatter.get_supylabel() == "least clearance [m] (6: that or more)"
    (axes,) = draw_cycle_times({"mpc": np.linspace(2.0, 30.0, 50)}).axes
    axes.figure.canvas.draw()
    shown = [text.get_text() for text in (*axes.get_xticklabels(which="both"), *axes.get_yticklabels())]
    assert {"2", "10", "20", "0.1"} <= set(shown)
    assert not any("10^" in text for text in shown)


def test_a_thumbnail_shows_three_moments_of_any_drive() -> None:
    drive = simulate(load_scene("curved-road"), "aeb")
    assert len(draw_thumbnail(drive).axes) == 3
    assert png_bytes(draw_thumbnail(drive)) == png_bytes(draw_thumbnail(drive))
