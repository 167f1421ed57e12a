"""The studio's row of times to react says what each candidate asks now, or that it cannot begin just now."""

from __future__ import annotations

from pathlib import Path

import mcdas_opt.studio
from mcdas_opt.domain.escapes import Closer, Escape, Escapes
from mcdas_opt.plotting.web import palette, script
from tests.studio.browser import chromium

SCRIPT = Path(mcdas_opt.studio.__file__).with_name("web") / "times_to_react.js"


def test_a_candidate_that_cannot_begin_just_now_is_told_as_that() -> None:
    brake = Escape(open=True, last_moment_s=2.44, closed_by=Closer.SIDE, last_comfortable_s=1.3)
    left = Escape(open=True, last_moment_s=2.0, closed_by=Closer.REAR, demand_mps2=1.1)
    found = Escapes(brake=brake, left=left, right=Escape(closed_by=Closer.EDGE)).to_dict()
    with chromium() as browser:
        tab = browser.new_page(viewport={"width": 1000, "height": 400})
        tab.set_content("<main style='width: 900px'></main>")
        for content in (script(), SCRIPT.read_text("utf-8")):
            tab.add_script_tag(content=content)
        tab.evaluate("([look, found]) => new mcdas.TimesToReact(document.querySelector('main'), look).show(found)", [palette(), found])
        tab.wait_for_selector("svg text")
        said = tab.locator("svg text").all_text_contents()
    assert "not just now; 2.4 s, then closed by side car" in said
    assert "2.0 s, then closed by rear, asks 1.1 m/s² now" in said
    assert "closed by road edge" in said
