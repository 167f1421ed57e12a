"""A recording as a page: what was believed and decided at each moment, bands over time, and jumps to what changed."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import same_color

from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status
from mcdas_opt.errors import InputError
from mcdas_opt.interop.replay import replay
from mcdas_opt.interop.replay_record import Replay
from mcdas_opt.plotting import replay_player, style
from mcdas_opt.plotting.bands import Decided, bands_document
from mcdas_opt.plotting.replay import replay_figure
from mcdas_opt.plotting.replay_player import replay_document
from tests.studio.browser import chromium


@pytest.fixture(scope="module")
def done() -> Replay:
    return replay("front_and_rear", planner="closed-form-corrected")


def test_the_page_shows_what_was_believed_at_each_moment(done: Replay) -> None:
    document = replay_document(done)
    json.dumps(document, allow_nan=False)
    start = done.cycles[0].t_s
    assert document["t"] == [round(cycle.t_s - start, 3) for cycle in done.cycles]
    for shown, cycle, pose in zip(document["cycles"], done.cycles, document["host"]["poses"], strict=True):
        assert (len(shown["bodies"]), len(shown["tracks"])) == (len(cycle.tracks),) * 2
        for body, track in zip(shown["bodies"], cycle.tracks, strict=True):
            assert body["name"] == track.id
            np.testing.assert_allclose(np.subtract(body["pose"][:2], pose[:2]), [track.s_m, track.d_m], atol=2e-3)
        assert cycle.plan is not None
        assert shown["sound"] is cycle.plan.verdict.passed
        assert shown["plan"]
    lengths = {len(document[key]) for key in ("poses_t", "camera", "speed", "t", "cycles")}
    assert lengths == {len(done.cycles)}


def test_a_replay_without_plans_has_no_status(done: Replay) -> None:
    document = replay_document(replay("front_and_rear", plan=False))
    assert [row["name"] for row in document["bands"]] == ["mode"]
    assert all(cycle["plan"] == [] for cycle in document["cycles"])


def test_a_long_recording_is_thinned_and_its_events_are_not(done: Replay, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = replay_document(done)
    monkeypatch.setattr(replay_player, "MOST_CYCLES", 40)
    thin = replay_document(done)
    assert len(thin["cycles"]) <= 40 < len(whole["cycles"])
    assert (thin["events"], thin["bands"], thin["duration"]) == (whole["events"], whole["bands"], whole["duration"])


def said(t_s: float, mode: Mode = Mode.HOLD, status: Status = Status.PLANNED, alert: Alert = Alert.NONE, passed: bool = True) -> Decided:
    return Decided(t_s=t_s, mode=mode, side=Side.NONE, status=status, alert=alert, reason=f"why {t_s}; before: x", passed=passed)


def test_bands_cover_the_whole_time_and_every_change_is_one_event() -> None:
    decided = [
        said(0.0),
        said(0.1, Mode.BRAKE, alert=Alert.WARN),
        said(0.2, Mode.BRAKE, Status.FALLBACK, Alert.ACT),
        said(0.3, Mode.BRAKE, Status.FALLBACK, Alert.ACT, passed=False),
        said(0.4),
    ]
    document = bands_document(decided, 0.5)
    for row in document["bands"]:
        edges = [(span[0], span[1]) for span in row["spans"]]
        assert edges[0][0] == 0.0
        assert edges[-1][1] == 0.5
        assert all(a[1] == b[0] for a, b in pairwise(edges))
    mode, status, alert = ([span[2] for span in row["spans"]] for row in document["bands"])
    assert (mode, alert) == (["hold", "brake", "hold"], ["none", "warn", "act", "none"])
    assert status == ["planned", "fallback", "fallback, failed by the judge", "planned"]
    found = [(event["t"], event["kind"], event["word"], event["why"]) for event in document["events"]]
    assert found == [(0.1, "alert", "warn", "why 0.1"), (0.2, "status", "fallback", "why 0.2"), (0.4, "mode", "hold", "why 0.4")]


def test_only_pages_and_pictures_are_made_of_it(done: Replay, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"must end in .* \.html"):
        done.save(tmp_path / "a.gif")
    assert done.save(tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_the_page_jumps_to_events_in_the_light_and_in_the_dark(done: Replay, tmp_path: Path) -> None:
    file = done.save(tmp_path / "replay.html")
    events = replay_document(done)["events"]
    assert len(events) >= 2
    with chromium() as browser:
        papers = set()
        for scheme in ("light", "dark"):
            tab = browser.new_page(viewport={"width": 390, "height": 800}, color_scheme=scheme)
            faults: list[str] = []
            tab.on("pageerror", lambda error, faults=faults: faults.append(str(error)))
            tab.on("console", lambda said, faults=faults: faults.append(said.text) if said.type == "error" else None)
            tab.goto(file.as_uri())
            tab.get_by_role("button", name="event ▶").click()
            assert tab.evaluate("view.transport.time") == pytest.approx(events[0]["t"])
            tab.get_by_role("button", name="event ▶").click()
            assert tab.evaluate("view.transport.time") == pytest.approx(events[1]["t"])
            assert events[1]["why"] in tab.locator(".mcdas-why").inner_text()
            tab.get_by_role("button", name="◀ event").click()
            assert tab.evaluate("view.transport.time") == pytest.approx(events[0]["t"])
            assert tab.evaluate("document.documentElement.scrollWidth") <= 390
            papers.add(tab.evaluate("getComputedStyle(document.body).backgroundColor"))
            assert faults == []
        assert len(papers) == 2


def test_the_picture_says_whose_tracks_it_shows_and_the_host_is_blue(done: Replay) -> None:
    above, below, band = replay_figure(done).axes
    assert above.get_title(loc="left") == "front_and_rear  ·  tracks, planned by closed-form-corrected"
    (host,) = (line for line in below.lines if line.get_label() == "host")
    assert same_color(host.get_color(), style.HOST)
    low, high = band.get_xlim()
    times = [cycle.t_s for cycle in done.cycles]
    assert times[0] - 0.2 < low < times[0] < times[-1] < high < times[-1] + 0.2
