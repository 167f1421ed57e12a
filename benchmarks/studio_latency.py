"""How long a slider of the studio waits, measured in the browser: from the user's event to the painted answer; and the page's weight.

    python -m benchmarks.studio_latency [--turns 20] [--scene sandwich-60-40]

Needs the extra `web`, playwright and a Chromium. Every slider is turned by key, answer by answer; then one is dragged for a second.
Run it on a machine that has nothing else to do: planners, server and browser share its cores.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from typing import Any

READY = "window.mcdas.studio && !mcdas.studio.asking.busy && Object.keys(mcdas.studio.plans).length > 2"
TIMES = "mcdas.studio.asking.latencies.splice(0)"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def ready(port: int) -> str:
    """The address of the studio on that port, once it answers."""
    for _ in range(240):
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{port}", timeout=5).read()
            return f"http://127.0.0.1:{port}"
        except OSError:
            time.sleep(0.25)
    raise SystemExit("the studio did not start")


def started(folder: str) -> tuple[subprocess.Popen[bytes], str]:
    """The studio on a free port, once it answers."""
    port = free_port()
    command = [sys.executable, "-m", "mcdas_opt", "studio", "--port", str(port), "--folder", folder, "--no-show"]
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return server, ready(port)


def figures(times: list[float]) -> dict[str, float]:
    ordered = sorted(times)
    rank = min(int(0.9 * len(ordered)), len(ordered) - 1)
    median, p90, most = (round(ms, 1) for ms in (statistics.median(ordered), ordered[rank], ordered[-1]))
    return {"answers": len(ordered), "median_ms": median, "p90_ms": p90, "max_ms": most}


def turned(page: Any, key: str, turns: int) -> dict[str, float]:
    page.evaluate(TIMES)
    page.locator(f"input[name={key}]").focus()
    for k in range(turns):
        page.keyboard.press("ArrowLeft" if k < turns // 2 else "ArrowRight")
        page.wait_for_function(READY)
    return figures(page.evaluate(TIMES))


def dragged(page: Any, key: str) -> dict[str, float]:
    page.evaluate(TIMES)
    box = page.locator(f"input[name={key}]").bounding_box()
    x, y, width = box["x"], box["y"] + 0.5 * box["height"], box["width"]
    page.mouse.move(x + 0.3 * width, y)
    page.mouse.down()
    for k in range(60):
        page.mouse.move(x + (0.3 + 0.4 * k / 60) * width, y)
        page.wait_for_timeout(16)
    page.mouse.up()
    page.wait_for_function(READY)
    return figures(page.evaluate(TIMES))


def main() -> None:
    from playwright.sync_api import sync_playwright

    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--turns", type=int, default=20)
    asked.add_argument("--scene", default="sandwich-60-40")
    options = asked.parse_args()
    chromium = next((found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        server, address = started(folder)
        try:
            browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            weight = [0.0]
            network = page.context.new_cdp_session(page)
            network.send("Network.enable")
            network.on("Network.loadingFinished", lambda event: weight.__setitem__(0, weight[0] + event["encodedDataLength"]))
            page.goto(address)
            page.wait_for_function(READY, timeout=60_000)
            page.locator(".mcdas-files").first.select_option(options.scene)
            page.wait_for_timeout(2000)
            page.wait_for_function(READY)
            sliders = page.evaluate("Object.values(mcdas.studio.knobs.rows).filter(r => !r.slider.disabled).map(r => r.knob.key)")
            report = {
                "scene": options.scene,
                "page_kB": round(weight[0] / 1e3, 1),
                "load_before": os.getloadavg()[0],
                "cores": os.cpu_count(),
                "turned": {key: turned(page, key, options.turns) for key in sliders},
                "dragged": {key: dragged(page, key) for key in sliders[:2]},
            }
            browser.close()
        finally:
            server.terminate()
            server.wait()
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
