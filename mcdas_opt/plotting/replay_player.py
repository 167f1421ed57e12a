"""A recording as a page that plays and scrubs: what the radar's tracks were, what would have been done about them, and why."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.vocabulary import Role
from mcdas_opt.interop.replay_record import Cycle, Replay, SeenTrack
from mcdas_opt.plotting import style, web
from mcdas_opt.plotting.bands import Decided, bands_document
from mcdas_opt.plotting.moments import HOST
from mcdas_opt.plotting.plane import Ground, chart, ellipse, line, plan_path, rounded
from mcdas_opt.plotting.words import doing, sentence

MOST_CYCLES = 6000  # of a longer recording every so-manieth is shown
_BEYOND_M = 200.0
_COLOURS = {Role.FRONT: style.FRONT, Role.REAR: style.REAR}
_SCALE_M = 2.0  # below the road, for the scale
_FARTHEST_M, _NEAREST_M = 90.0, 40.0  # of the window, ahead and behind


def replay_page(replay: Replay) -> str:
    return web.page(f"{replay.name} · {replay.planner or 'tracks alone'}, replayed", "Drive", replay_document(replay))


def replay_document(replay: Replay) -> dict[str, Any]:
    """What the script's `Drive` shows; every body is a track, where it was believed at each cycle. Times count from the first cycle."""
    cycles = replay.cycles[:: -(-len(replay.cycles) // MOST_CYCLES)]
    start = cycles[0].t_s
    t = [cycle.t_s - start for cycle in cycles]
    places = [cycle.host.s_m for cycle in cycles]
    ground = Ground(replay.road, min(places) - _BEYOND_M, max(places) + _BEYOND_M)
    car = replay.vehicle
    poses = ground.place(places, [cycle.host.d_m for cycle in cycles], [cycle.host.heading_rad for cycle in cycles])
    speeds = [cycle.host.speed_mps for cycle in cycles]
    decided = [Decided.of(one.t_s - start, one, passed=one.plan is None or one.plan.verdict.passed) for one in replay.cycles]
    duration = replay.cycles[-1].t_s - start
    return {
        "duration": duration,
        "road": ground.document(),
        "view": _view(replay),
        "poses_t": rounded(t, 3),
        "camera": rounded(ground.place(places, 0.0), 3),
        "speed": rounded(speeds),
        "host": {"name": HOST, "length": car.length_m, "width": car.width_m, "colour": style.HOST, "poses": rounded(poses, 3)},
        "others": [],
        "t": rounded(t, 3),
        "cycles": [_cycle(ground, cycle) for cycle in cycles],
        "charts": _charts(cycles, t, duration),
        **bands_document(decided, duration),
        "outcome": "",
        "safe": True,
        "struck": [],
    }


def _cycle(ground: Ground, cycle: Cycle) -> dict[str, Any]:
    plan, host = cycle.plan, cycle.host
    seen = [_body(ground, cycle, track) for track in cycle.tracks]
    return {
        "action": cycle.mode.value if cycle.side.value == "none" else f"{cycle.mode.value} {cycle.side.value}",
        "status": "seen" if cycle.status is None else cycle.status.value,
        "sound": plan is None or plan.verdict.passed,
        "words": cycle.reason.partition("; before:")[0] if plan is None else _words(plan),
        "plan": [] if plan is None else plan_path(ground, plan.trajectory)[0],
        "seconds": [] if plan is None else plan_path(ground, plan.trajectory)[1],
        "bodies": seen,
        "tracks": [ellipse(ground, host.s_m + q.s_m, host.d_m + q.d_m, q.speed_s_mps, q.speed_d_mps, q.covariance) for q in cycle.tracks],
    }


def _words(plan: Plan) -> str:
    return f"{doing(plan)}: {plan.reason.partition('; before:')[0]} ({sentence(plan)})"


def _body(ground: Ground, cycle: Cycle, track: SeenTrack) -> dict[str, Any]:
    (pose,) = ground.place(cycle.host.s_m + track.s_m, cycle.host.d_m + track.d_m).tolist()
    return {
        "name": track.id,
        "length": round(track.length_m, 2),
        "width": round(track.width_m, 2),
        "colour": _COLOURS.get(track.role, style.NEIGHBOUR),
        "pose": [round(q, 3) for q in pose],
    }


def _view(replay: Replay) -> dict[str, float]:
    """A window that holds nine tenths of the tracks where it can."""
    along = np.array([track.s_m for cycle in replay.cycles for track in cycle.tracks] or [0.0])
    low, high = np.percentile(along, [5.0, 95.0])
    back, ahead = float(np.clip(-low + 8.0, 25.0, _NEAREST_M)), float(np.clip(high + 14.0, 60.0, _FARTHEST_M))
    across = [track.d_m for cycle in replay.cycles for track in cycle.tracks if -back < track.s_m < ahead] or [0.0]
    low, high = np.percentile(across, [5.0, 95.0])
    right, left = min(replay.road.right_edge_m, float(low)) - 1.6, max(replay.road.left_edge_m, float(high)) + 1.6
    return {"back": back, "ahead": ahead, "right": max(right - _SCALE_M, -14.0), "left": min(left, 14.0)}


def _charts(cycles: Sequence[Cycle], t: list[float], duration: float) -> list[dict[str, Any]]:
    """The host's speed; the gap and the closing speed to whoever is next in its lane, ahead and behind."""
    speeds = [cycle.host.speed_mps for cycle in cycles]
    gaps: dict[Role, list[float]] = {role: [] for role in _COLOURS}
    rates: dict[Role, list[float]] = {role: [] for role in _COLOURS}
    for cycle in cycles:
        for role in _COLOURS:
            near = min((track for track in cycle.tracks if track.role is role), key=lambda track: abs(track.s_m), default=None)
            gaps[role].append(np.nan if near is None else abs(near.s_m))
            sign = 1.0 if role is Role.FRONT else -1.0
            rates[role].append(np.nan if near is None else sign * (near.speed_s_mps - cycle.host.speed_mps))
    return [
        _chart("speed", "m/s", t, duration, {style.HOST: speeds}, floor=0.0),
        _chart("distance in the lane, centres", "m", t, duration, {_COLOURS[role]: values for role, values in gaps.items()}, floor=0.0),
        _chart("opening speed in the lane", "m/s", t, duration, {_COLOURS[role]: values for role, values in rates.items()}),
    ]


def _chart(
    title: str, unit: str, t: list[float], duration: float, lines: dict[str, list[float]], floor: float | None = None
) -> dict[str, Any]:
    shown = {colour: values for colour, values in lines.items() if np.isfinite(values).any()}
    every = np.array([v for values in shown.values() for v in values if np.isfinite(v)] or [0.0, 1.0])
    low, high = float(every.min()), float(every.max())
    margin = max(0.08 * (high - low), 0.5)
    bottom = low - margin if floor is None else max(low - margin, floor)
    return chart(
        title, unit, bottom, high + margin, duration=duration, lines=[line(t, values, colour, 2) for colour, values in shown.items()]
    )
