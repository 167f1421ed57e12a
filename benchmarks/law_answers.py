"""Answers of a planner as documents: how much of one stays the same when something is changed that must not matter."""

from __future__ import annotations

import json
import math
import re
from enum import IntEnum
from typing import Any

import numpy as np

from mcdas_opt.domain.plan import Plan

Answer = dict[str, Any]


class Kept(IntEnum):
    """How much of an answer stayed the same, least first."""

    NOTHING = 0  # another decision, or an exception
    DECISION = 1
    STATES = 2  # the decision, and the states to the law's tolerance
    BITS = 3  # the whole document


def told(plan: Plan) -> Answer:
    """The plan's document, without what was timed."""
    document = plan.to_dict()
    del document["timing_ms"]
    return document


def raised(error: Exception) -> Answer:
    """The answer of a planner that broke."""
    return {"raised": f"{type(error).__name__}: {error}"[:200]}


def decision(answer: Answer) -> Answer:
    """What was decided, without a number."""
    if "raised" in answer:
        return answer
    end = answer["safe_end"]
    ways = answer.get("escapes") or {}
    return {
        **{name: answer[name] for name in ("planner", "status", "mode", "side", "chosen", "alert", "warning", "literal_mode")},
        "passed": answer["verdict"]["passed"],
        "safe end": None if end is None else end["kind"],
        "open": {name: way["open"] for name, way in ways.items() if isinstance(way, dict)},
    }


def first_difference(before: Any, after: Any, where: str = "") -> str:
    """The key at which two documents first differ, and both values."""
    if isinstance(before, dict) and isinstance(after, dict):
        pairs = [(f"{where}.{key}", before.get(key), after.get(key)) for key in dict.fromkeys([*before, *after])]
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        pairs = [(f"{where}[{k}]", *both) for k, both in enumerate(zip(before, after, strict=True))]
    else:
        return f"{where.removeprefix('.')}: {before} | {after}"
    return next(first_difference(ours, theirs, at) for at, ours, theirs in pairs if ours != theirs)


def apart_m(before: Answer, after: Answer) -> float:
    """Largest distance between samples of the two drives [m]; where the sampling differs, at the first drive's times."""
    ours, theirs = ({name: np.array(answer["trajectory"][name]) for name in ("t_s", "s_m", "d_m")} for answer in (before, after))
    if len(ours["t_s"]) == len(theirs["t_s"]):
        return float(max(np.abs(ours[name] - theirs[name]).max() for name in ("s_m", "d_m")))
    if abs(ours["t_s"][-1] - theirs["t_s"][-1]) > 1e-3:
        return math.inf
    return float(max(np.abs(ours[name] - np.interp(ours["t_s"], theirs["t_s"], theirs[name])).max() for name in ("s_m", "d_m")))


def put_back(answer: Answer, names: dict[str, str]) -> Answer:
    """The document with the old names in its texts."""
    old = {new: name for name, new in names.items()}
    text = re.sub(r"x\d{3}[yz]", lambda found: old.get(found.group(), found.group()), json.dumps(answer))
    back: Answer = json.loads(text)
    return back
