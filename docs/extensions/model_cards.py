"""Copies models/cards into the site's sources for the time of a build, so that cards stand once, beside the models."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any


def _bring(app: Any) -> None:
    source, target = Path(app.srcdir).parent / "models" / "cards", Path(app.srcdir) / "cards"
    target.mkdir(exist_ok=True)
    for card in source.glob("*.md"):
        if not (target / card.name).is_file() or (target / card.name).read_bytes() != card.read_bytes():
            shutil.copyfile(card, target / card.name)


def setup(app: Any) -> dict[str, Any]:
    app.connect("builder-inited", _bring)
    return {"parallel_read_safe": True}
