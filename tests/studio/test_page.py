"""The studio end to end, in a headless Chromium: what is turned is answered, what is dragged is planned, nothing leaves the machine."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
import tomllib
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from tests.studio.browser import chromium

pytest.importorskip("nicegui")
NASTY = "<script>window.hacked = true</script>"
ANSWERED = "window.mcdas.studio && !window.mcdas.studio.asking.busy && Object.keys(window.mcdas.studio.plans).length >= 3"
PARKED = "!window.mcdas.parkingTab.asking.busy && window.mcdas.parkingTab.view.yard.yard"


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("outside") / "room"
    folder.mkdir()
    (folder / "nasty.toml").write_text(f'name = "{NASTY}"\n[host]\nspeed_mps = 11.1\n')
    (folder.parent / "secret.toml").write_text("[host]\nspeed_mps = 1.0\n")
    return folder


@pytest.fixture(scope="module")
def address(room: Path) -> Iterator[str]:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "NICEGUI"))}
    command = [sys.executable, "-m", "mcdas_opt", "studio", "--port", str(port), "--folder", str(room), "--no-show"]
    server = subprocess.Popen(command, cwd=room, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    url = f"http://127.0.0.1:{port}"
    try:
        for _ in range(240):
            try:
                urllib.request.urlopen(url, timeout=5).read()
                break
            except OSError:
                assert server.poll() is None, server.stdout.read() if server.stdout else ""
                time.sleep(0.25)
        else:
            pytest.fail("the studio did not start")
        yield url
    finally:
        server.terminate()
        said, _ = server.communicate(timeout=30)
    assert "Traceback" not in said, said
    assert not list(room.glob(".nicegui")), "the studio leaves nothing behind"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture
def page(browser: Any, address: str) -> Iterator[Any]:
    """A page that has answered once; afterwards nothing may have gone wrong in it, and nothing may have left the machine."""
    context = browser.new_context(viewport={"width": 1280, "height": 800}, accept_downloads=True, reduced_motion="reduce")
    page = context.new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda said: faults.append(said.text) if said.type == "error" and "413" not in said.text else None)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(address)
    page.wait_for_function(ANSWERED, timeout=60_000)
    yield page
    context.close()
    assert not faults
    assert all(url.startswith((address, "data:", "blob:", address.replace("http", "ws"))) for url in asked), asked


def settle(page: Any) -> None:
    page.wait_for_function(ANSWERED, timeout=60_000)


def test_a_slider_is_answered_by_keyboard_and_by_pointer(page: Any) -> None:
    ends = "Object.values(mcdas.studio.plans).map(p => [p.planner, p.poses.at(-1), p.words])"
    before = page.evaluate(ends)
    slider = page.get_by_label("gap to the rear car [m]")
    slider.focus()
    for _ in range(6):
        page.keyboard.press("ArrowLeft")
    settle(page)
    assert page.evaluate("mcdas.studio.state.positions.rear_gap_m") == pytest.approx(22.0)
    rear = page.evaluate("mcdas.studio.outlook.picture.bodies.find(b => b.name === 'rear').poses[0][0]")
    assert rear == pytest.approx(-26.5, abs=0.01)
    box = page.get_by_label("host [m/s]").bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + box["height"] / 2)
    page.mouse.down()
    for k in range(12):
        page.mouse.move(box["x"] + (0.3 + 0.03 * k) * box["width"], box["y"] + box["height"] / 2)
    page.mouse.up()
    settle(page)
    wanted = float(page.get_by_label("host [m/s]").input_value())
    speeds = page.evaluate("Object.values(mcdas.studio.plans).map(p => p.lines.speed[0])")
    assert speeds == pytest.approx([wanted] * len(speeds), abs=0.01)
    assert page.evaluate(ends) != before
    times = page.evaluate("mcdas.studio.asking.latencies")
    assert times
    assert all(ms > 0.0 for ms in times)
    assert "ms (median)" in page.locator(".mcdas-latency").first.inner_text()


def test_everything_that_was_promised_is_on_the_page(page: Any, tmp_path: Path) -> None:
    rows = page.locator(".mcdas-verdicts tbody tr:visible")
    names = rows.locator("th").all_inner_texts()
    assert {"literal", "corrected", "MPC"} <= set(names)
    verdicts = dict(zip(names, rows.locator("td:nth-child(4)").all_inner_texts(), strict=True))
    assert "failed by the judge" in verdicts["literal"]
    assert "passed by the judge" in verdicts["MPC"]
    dashes = page.evaluate("mcdas.studio.setup.planners.map(p => p.colour + p.dash)")
    assert len(set(dashes)) == len(dashes), "colour and dashes tell every planner apart"
    timeline = page.locator(".mcdas-escapes").inner_text()
    for candidate in ("brake", "accelerate", "steer left", "steer right"):
        assert candidate in timeline
    assert page.locator(".mcdas-paths .mcdas-strip").count() == 4
    shown = page.evaluate("mcdas.studio.shown().length")
    page.get_by_label("show literal").uncheck()
    assert page.evaluate("mcdas.studio.shown().length") == shown - 1
    page.get_by_label("also show aeb").click()
    page.wait_for_function("mcdas.studio.shown().some(plan => plan.planner === 'aeb')")
    page.get_by_label("look ahead in time, as predicted").fill("1.5")
    assert "in 1.50 s" in page.locator(".mcdas-ahead .mcdas-clock").inner_text()
    page.screenshot(path=tmp_path / "sandwich.png", full_page=True)
    for width, height in ((390, 844), (1680, 1000)):
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(200)
        assert page.evaluate("document.documentElement.scrollWidth") <= width + 1, "nothing sticks out sideways"


def test_the_closed_loop_plays_pauses_and_scrubs(page: Any) -> None:
    page.get_by_label("who drives the closed loop").select_option("closed-form-corrected")
    page.get_by_role("button", name="Drive the closed loop").click()
    page.get_by_role("button", name="Back to the paths").wait_for(timeout=90_000)
    assert page.evaluate("mcdas.studio.drives.transport.time") == 0.0
    page.locator(".mcdas-loop .mcdas-play").click()
    page.wait_for_function("mcdas.studio.drives.transport.time > 0.2")
    page.locator(".mcdas-loop .mcdas-play").click()
    held = page.evaluate("mcdas.studio.drives.transport.time")
    page.wait_for_timeout(150)
    assert page.evaluate("mcdas.studio.drives.transport.time") == held
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("End")
    ended = page.locator(".mcdas-loop .mcdas-words").inner_text()
    assert ended == page.evaluate("mcdas.studio.drives.all[0].drive.outcome")
    page.keyboard.press("ArrowLeft")
    duration = page.evaluate("mcdas.studio.drives.all[0].drive.duration")
    assert page.evaluate("mcdas.studio.drives.transport.time") == pytest.approx(duration - 0.1, abs=1e-6)
    page.get_by_role("button", name="Back to the paths").click()
    assert page.locator(".mcdas-paths").is_visible()


def test_a_name_with_tags_runs_nothing(page: Any) -> None:
    page.locator(".mcdas-files").first.select_option("nasty.toml")
    page.wait_for_function("document.querySelector('.mcdas-bar h2').textContent.includes('script')")
    settle(page)
    assert page.locator(".mcdas-bar h2").first.inner_text() == NASTY
    assert page.evaluate("window.hacked === undefined")


def test_paths_out_of_the_folder_and_wrong_values_are_told(page: Any) -> None:
    problem = page.locator(".mcdas-problem").first
    page.evaluate("mcdas.studio.emit('open', {kind: 'scene', name: '../secret.toml'})")
    problem.get_by_text("outside of the folder").wait_for()
    page.evaluate("mcdas.studio.emit('open', {kind: 'shipped', name: '../../etc/passwd'})")
    problem.get_by_text("no shipped scene").wait_for()
    page.evaluate("mcdas.studio.change({friction: 'x'})")
    problem.get_by_text("friction = 'x': must be a number").wait_for()
    page.evaluate("mcdas.studio.change({rear_gap_m: 2})")
    settle(page)
    assert not problem.is_visible(), "a good answer clears the complaint"


def test_scenes_go_up_and_come_down(page: Any, tmp_path: Path) -> None:
    sent = tmp_path / "mine.toml"
    sent.write_text('name = "mine"\n[host]\nspeed_mps = 20.0\n[[neighbour]]\nname = "front"\ns_m = 40.0\nspeed_mps = 10.0\n')
    page.locator("input[type=file]").set_input_files(sent)
    page.wait_for_function("document.querySelector('.mcdas-bar h2').textContent === 'mine'")
    settle(page)
    page.get_by_label("friction [-]").fill("0.5")
    settle(page)
    with page.expect_download() as got:
        page.get_by_role("button", name="Download").first.click()
    scene = tomllib.loads(Path(got.value.path()).read_text())
    assert (got.value.suggested_filename, scene["road"]["friction"], scene["neighbour"][0]["s_m"]) == ("mine.toml", 0.5, 40.0)
    with page.expect_download() as got:
        page.get_by_role("button", name="PNG").first.click()
    with Image.open(got.value.path()) as picture:
        assert picture.width > 1000
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 50
    sent.write_text("[host]\nspeed_mps = -3\n")
    page.locator("input[type=file]").set_input_files(sent)
    page.locator(".mcdas-problem").first.get_by_text("mine.toml: host.speed_mps").wait_for()


def drag(page: Any, key: str, by: tuple[int, int]) -> None:
    box = page.locator(f"[data-grip='{key}'] path").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(x + k * by[0] / 8, y + k * by[1] / 8)
        page.wait_for_timeout(20)
    page.mouse.up()
    settle(page)


CARS = "mcdas.studio.state.scene.neighbour.map(car => [car.name, car.s_m, car.d_m])"


def test_cars_are_dragged_added_removed_and_all_is_undone(page: Any) -> None:
    began = page.evaluate(CARS)
    scale = page.evaluate("mcdas.studio.outlook.bird.camera.scale")
    drag(page, "neighbour[0]", (60, 0))
    (_, s, d), _ = page.evaluate(CARS)
    assert (s, d) == (pytest.approx(began[0][1] + 60 / scale, abs=0.2), 0.0)
    shown = page.evaluate("mcdas.studio.outlook.picture.bodies.find(b => b.name === 'front').poses[0]")
    assert shown[:2] == pytest.approx([s, 0.0], abs=0.01), "the picture is of the dragged car"
    page.get_by_label("speed of the chosen car [m/s]").fill("7")
    page.keyboard.press("Enter")
    settle(page)
    assert page.evaluate("mcdas.studio.state.scene.neighbour[0].speed_mps") == 7
    page.get_by_role("button", name="add a car").click()
    settle(page)
    assert [name for name, *_ in page.evaluate(CARS)] == ["front", "rear", "car 3"]
    page.locator("[data-grip='neighbour[2]']").focus()
    page.keyboard.press("Delete")
    settle(page)
    assert len(page.evaluate(CARS)) == 2
    scale = page.evaluate("mcdas.studio.outlook.bird.camera.scale")
    drag(page, "neighbour[0]", (int(-s * scale), 0))  # onto the host, which cannot be
    assert "overlaps" in page.locator(".mcdas-problem").first.inner_text()
    undo = page.get_by_role("button", name="undo")
    while undo.is_enabled():
        undo.click()
        settle(page)
    assert page.evaluate(CARS) == began
    page.keyboard.press("Control+y")
    settle(page)
    assert page.evaluate(CARS) != began


def test_a_link_shows_the_same_scene_and_planners(page: Any) -> None:
    page.locator(".mcdas-files").first.select_option("curved-road")
    page.wait_for_function("mcdas.studio.title.textContent === 'curved-road' && mcdas.studio.state.scene.name === 'curved-road'")
    settle(page)
    drag(page, "neighbour[0]", (-20, -12))
    page.get_by_label("b [-]").fill("60")
    settle(page)
    page.get_by_label("show tuned").uncheck()
    asked = "[mcdas.studio.state.scene, mcdas.studio.state.positions.b, mcdas.studio.told().map(p => p.name)]"
    here, link = page.evaluate(asked), page.evaluate("location.href")
    other = page.context.new_page()
    other.goto(link)
    other.wait_for_function(ANSWERED, timeout=60_000)
    assert other.evaluate(asked) == here
    other.goto("about:blank")
    other.goto(link.partition("#")[0] + "#scene=nonsense")
    other.locator(".mcdas-problem").first.get_by_text("shared link: is damaged").wait_for()
    other.close()


def test_on_a_phone_the_picture_stays_in_sight(page: Any) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    page.locator(".mcdas-form summary", has_text="road").first.click()
    for down in (0, 500, 1500, 10_000):
        page.evaluate(f"window.scrollTo(0, {down})")
        page.wait_for_timeout(60)
        box = page.evaluate("mcdas.studio.outlook.bird.svg.getBoundingClientRect().toJSON()")
        assert box["top"] >= 0.0
        assert box["bottom"] <= 0.5 * 844
    assert page.evaluate("document.documentElement.scrollWidth") <= 391
    page.get_by_label("road.lanes_left").fill("3")
    page.keyboard.press("Tab")
    settle(page)
    assert page.evaluate("mcdas.studio.state.scene.road.lanes_left") == 3


def test_planners_drive_side_by_side(page: Any) -> None:
    for name in ("literal", "MPC"):
        page.get_by_label(f"show {name}", exact=True).uncheck()
    page.get_by_label("who drives the closed loop").select_option("")
    page.evaluate(
        "() => { const sign = mcdas.studio.waiting; window.signs = [];"
        " new MutationObserver(() => signs.push(sign.textContent)).observe(sign, { childList: true }); }"
    )
    page.get_by_role("button", name="Drive the closed loop").click()
    page.wait_for_function("mcdas.studio.stop.hidden && mcdas.studio.drives.all.length === 2", timeout=90_000)
    assert "driving …" in page.evaluate("signs"), "a sign that may be gone before anybody looks"
    page.evaluate("mcdas.studio.drives.transport.go(2)")
    assert page.locator(".mcdas-drive h3").all_inner_texts() == ["corrected", "tuned"]
    clocks = page.locator(".mcdas-loop .mcdas-transport")
    assert clocks.count() == 1, "one clock for all"


def test_a_scene_is_saved_over_another_only_when_asked(page: Any, room: Path) -> None:
    page.get_by_label("name of the scene in the folder").fill("kept")
    save = page.get_by_role("button", name="Save", exact=True).first
    save.click()
    page.get_by_text("Saved").wait_for()
    page.get_by_label("friction [-]").fill("0.5")
    settle(page)
    save.click()
    page.get_by_text("kept.toml: is there already").wait_for()
    assert tomllib.loads((room / "kept.toml").read_text())["road"].get("friction", 0.9) == 0.9
    page.get_by_role("button", name="Replace it").click()
    page.get_by_text("Saved").wait_for()
    assert tomllib.loads((room / "kept.toml").read_text())["road"]["friction"] == 0.5
    (room / "kept.toml").unlink()


def test_a_slot_is_dragged_and_planned_in(page: Any, tmp_path: Path) -> None:
    page.get_by_role("tab", name="Parking").click()
    page.wait_for_function(f"window.mcdas.parkingTab && {PARKED} && mcdas.parkingTab.view.manoeuvre", timeout=90_000)
    page.get_by_label("parking planner").select_option("search")
    page.wait_for_function(PARKED, timeout=90_000)
    handle = page.locator("[data-handle=length]")
    box = handle.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(x + 10 * k, y)
        page.wait_for_timeout(20)
    page.mouse.up()
    page.wait_for_function(PARKED, timeout=90_000)
    length = page.evaluate("mcdas.parkingTab.values.length_m")
    assert length > 6.35
    assert float(page.get_by_label("length [m]").input_value()) == pytest.approx(length)
    front = page.evaluate("Math.min(...mcdas.parkingTab.view.yard.yard.obstacles[1].map(p => p[0]))")
    assert front == pytest.approx(length)
    assert "passed by the judge" in page.locator(".q-tab-panel:visible .mcdas-words").inner_text()
    page.screenshot(path=tmp_path / "parking.png", full_page=True)
    page.get_by_label("clearance asked for [m]").fill("0.4")
    page.wait_for_function(f"{PARKED} && mcdas.parkingTab.values.clearance_m === 0.4", timeout=90_000)


def refusal(request: urllib.request.Request | str) -> tuple[int, dict[str, str]]:
    with pytest.raises(urllib.error.HTTPError) as told:
        urllib.request.urlopen(request, timeout=20)
    return told.value.code, json.loads(told.value.read())


def test_strangers_and_floods_are_refused(address: str) -> None:
    code, said = refusal(urllib.request.Request(address, headers={"Host": "evil.com"}))
    assert (code, "evil.com" in said["error"]) == (403, True)
    code, said = refusal(urllib.request.Request(address, headers={"Origin": "http://evil.com"}))
    assert (code, "evil.com" in said["error"]) == (403, True)
    host, port = address.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=20) as line:
        head = f"POST /studio/file?page=x&name=a.toml HTTP/1.1\r\nHost: {host}:{port}\r\nContent-Length: 50000000\r\n\r\n"
        line.sendall(head.encode())
        assert b" 413 " in line.recv(4096)


def test_a_page_that_is_gone_gets_no_files(address: str) -> None:
    request = urllib.request.Request(f"{address}/studio/file?page=nobody&name=../../x.toml", data=b"a = 1", method="POST")
    said = json.loads(urllib.request.urlopen(request, timeout=20).read())
    assert "no longer known" in said["error"]
