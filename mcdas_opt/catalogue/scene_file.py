"""A scene back into its file, to be read again by `load_scene` as the same scene."""

from __future__ import annotations

from typing import Any

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.errors import ParameterError


def scene_file(scene: Scene) -> str:
    """TOML of what differs from the defaults, numbers to the last bit.

    Raises `ParameterError` for neighbours with a recorded trajectory, which stands in a file of its own.
    """
    if any(part.trajectory is not None for part in scene.neighbour):
        raise ParameterError("neighbour.trajectory", scene.name, "a scene with recorded trajectories cannot be written as one file")
    return toml_text(scene_document(scene))


def scene_document(scene: Scene) -> dict[str, Any]:
    """What differs from the defaults, as the scene's file says it."""
    return scene.model_dump(mode="json", exclude_defaults=True, exclude_none=True)
