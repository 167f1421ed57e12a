"""A drive as a row of moments: everything that one picture of it shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Track
from mcdas_opt.plotting import style
from mcdas_opt.simulation.record import Outcome, Simulation

HOST = "host"
_BACK_M, _AHEAD_M, _ASIDE_M = 55.0, 75.0, 8.0  # the window is widened for whoever is nearer
Pose = tuple[float, float, float]  # s [m], d [m], heading relative to the road [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """A body to draw; a `supposed` one is what a body that is drawn may do besides."""

    name: str
    pose: Pose
    length_m: float
    width_m: float
    colour: str
    supposed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """The host, the others, what the tracker believed and what was planned at `time_s`."""

    time_s: float
    host: Shown
    speed_mps: float
    others: tuple[Shown, ...]
    tracks: tuple[Track, ...]
    plan: Plan
    ended: Outcome | None = None
    struck: frozenset[str] = frozenset()

    @property
    def action(self) -> str:
        """What the plan does, in a word or two."""
        side = "" if self.plan.side.value == "none" else f" {self.plan.side.value}"
        return f"{self.plan.mode.value}{side}"


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """The window around the host's place on the road [m]: backward, forward, and to either side of the reference line."""

    back_m: float
    ahead_m: float
    right_m: float
    left_m: float

    @property
    def aspect(self) -> float:
        """Height over width."""
        return (self.left_m - self.right_m) / (self.back_m + self.ahead_m)


def moments(simulation: Simulation, at_most: int | None = None) -> list[Moment]:
    """One for every cycle and one for the end; `at_most` so many evenly spread ones where that is more."""
    times = [*(cycle.time_s for cycle in simulation.cycles), simulation.duration_s]
    if at_most is not None and len(times) > at_most:
        times = np.linspace(0.0, simulation.duration_s, at_most).tolist()
    return [moment_at(simulation, t) for t in times]


def moment_at(simulation: Simulation, time_s: float) -> Moment:
    """The drive at a time, with the plan and the tracks of the latest cycle."""
    starts = [cycle.time_s for cycle in simulation.cycles]
    over = time_s >= simulation.duration_s - 1e-9
    cycle = simulation.cycles[max(int(np.searchsorted(starts, time_s + 1e-9)) - 1, 0)]
    x, car = simulation.trajectory, simulation.scene.vehicle
    s, d, psi, v = (float(np.interp(time_s, x.t_s, column)) for column in (x.s_m, x.d_m, x.heading_rad, x.speed_mps))
    others = tuple(
        Shown(
            name=other.name,
            pose=(_at(time_s, x.t_s, other.s_m), _at(time_s, x.t_s, other.d_m), _at(time_s, x.t_s, other.heading_rad)),
            length_m=other.length_m,
            width_m=other.width_m,
            colour=colour,
        )
        for other, colour in zip(simulation.neighbours, neighbour_colours(simulation), strict=True)
    )
    return Moment(
        time_s=time_s,
        host=Shown(name=HOST, pose=(s, d, psi), length_m=car.length_m, width_m=car.width_m, colour=style.HOST),
        speed_mps=v,
        others=others,
        tracks=tuple(track.later(time_s - cycle.time_s) for track in cycle.tracks),
        plan=cycle.plan,
        ended=simulation.outcome if over else None,
        struck=frozenset({HOST, simulation.collided_with}) if over and simulation.collided_with else frozenset(),
    )


def view_of(simulation: Simulation) -> View:
    """A window that holds the neighbours over the whole drive where it can, and the road's bend across its length."""
    road, host = simulation.scene.true_road, simulation.trajectory
    away = [(other.s_m - host.s_m, other.d_m) for other in simulation.neighbours]
    near = np.concatenate([np.column_stack(q)[(q[0] > -_BACK_M) & (q[0] < _AHEAD_M)] for q in away] or [np.zeros((0, 2))])
    back = min(max(-float(near[:, 0].min(initial=0.0)) + 8.0, 25.0), _BACK_M)
    ahead = min(max(float(near[:, 0].max(initial=0.0)) + 14.0, 45.0), _AHEAD_M)
    margin = 1.6
    right, left = aside(near[:, 1], road.right_edge_m - margin, road.left_edge_m + margin)
    for reach in (back, ahead):
        bend = 0.5 * reach**2
        kappas = _curvatures(simulation, road)
        left = max(left, min(road.left_edge_m + margin + bend * max(kappas), 20.0))
        right = min(right, max(road.right_edge_m - margin + bend * min(kappas), -20.0))
    return View(back_m=back, ahead_m=ahead, right_m=right, left_m=left)


def aside(d_m: Array, right_m: float, left_m: float) -> tuple[float, float]:
    """A window from `right_m` to `left_m`, widened for bodies that are beyond it and not far."""
    near = d_m[np.abs(d_m) < _ASIDE_M]
    length = 2.5  # half of a car that stands across
    return min(right_m, float(near.min(initial=0.0)) - length), max(left_m, float(near.max(initial=0.0)) + length)


def _curvatures(simulation: Simulation, road: Road) -> list[float]:
    s = simulation.trajectory.s_m
    return [float(k) for k in road.curvature_at(np.linspace(float(s.min()) - 20.0, float(s.max()) + 40.0, 200))]


def neighbour_colours(simulation: Simulation) -> list[str]:
    """Orange for whoever is next ahead in the host's lane at the start, vermilion for whoever is next behind, grey for the rest."""
    host, lane_width_m = simulation.trajectory, simulation.scene.true_road.lane_width_m
    away = [(float(other.s_m[0] - host.s_m[0]), float(other.d_m[0] - host.d_m[0])) for other in simulation.neighbours]
    return lane_colours(away, lane_width_m)


def lane_colours(away_m: Sequence[tuple[float, float]], lane_width_m: float) -> list[str]:
    """Of bodies so far from the host along and across the road: orange for the next ahead in its lane, vermilion for the next behind,
    grey for the rest."""
    colours = [style.NEIGHBOUR] * len(away_m)
    near: dict[str, tuple[float, int]] = {}
    for i, (ahead, aside) in enumerate(away_m):
        if abs(aside) < 0.65 * lane_width_m:
            colour = style.FRONT if ahead > 0.0 else style.REAR
            near[colour] = min(near.get(colour, (math.inf, i)), (abs(ahead), i))
    for colour, (_, i) in near.items():
        colours[i] = colour
    return colours


def _at(time_s: float, t_s: np.ndarray, column: np.ndarray) -> float:
    return float(np.interp(time_s, t_s, column))
