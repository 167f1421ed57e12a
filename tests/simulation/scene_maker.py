"""Scenes from a few words."""

from __future__ import annotations

from typing import Any

from mcdas_opt.catalogue.scenes import Scene


def make_scene(*neighbours: dict[str, Any], speed_mps: float = 11.1, **parts: Any) -> Scene:
    """A scene with ideal sensors on a straight three-lane road, the host in its middle lane; `parts` replace or add."""
    document: dict[str, Any] = {
        "road": {"lanes_left": 1, "lanes_right": 1, **parts.pop("road", {})},
        "host": {"speed_mps": speed_mps, **parts.pop("host", {})},
        "neighbour": list(neighbours),
        **parts,
    }
    return Scene.model_validate(document)
