"""The C texts that are generated (`native/c/generated`): `python -m mcdas_opt.planning.generated_texts` writes them anew."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mcdas_opt.manoeuvres import compiled_family
from mcdas_opt.native.binding import defined
from mcdas_opt.native.build import TEXTS
from mcdas_opt.ocp.lane_mpc import lane_family
from mcdas_opt.reference import offset_path
from mcdas_opt.solvers.kernel_source import stage_text
from mcdas_opt.time_to_react import compiled_case

FOLDER = TEXTS / "generated"


def generated_texts() -> dict[str, str]:
    """Each by its name."""
    return {
        "family_numbers.h": _numbers("manoeuvres.compiled_family", compiled_family.NUMBERS_IN_C),
        "lane_stage.h": stage_text(lane_family()),
        "sharpest_path_numbers.h": _numbers("reference.offset_path", offset_path.NUMBERS_IN_C),
        "time_to_react_numbers.h": _numbers("time_to_react.compiled_case", compiled_case.NUMBERS_IN_C),
    }


def _numbers(module: str, numbers: Mapping[str, Any]) -> str:
    return f"/* Generated: the numbers of `{module}`. */\n{defined(numbers)}"


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, text in generated_texts().items():
        (FOLDER / name).write_text(text, "utf-8")
